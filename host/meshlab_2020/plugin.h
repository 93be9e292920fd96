// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The plugin as MeshLab 2020.09 and its meshlabserver see it. They catch no exception but
/// std::bad_alloc in the GUI: errors are told by `false` and errorMessage.

#include <common/interfaces.h>

#include <QObject>
#include <memory>
#include <vector>

#include "host/filter_set.h"
#include "host/meshlab_2020/dialog.h"

#define HOST_PLUGIN_INTERFACE MeshFilterInterface
#define HOST_PLUGIN_IID MESH_FILTER_INTERFACE_IID

namespace sphere_propagation::host {

class Plugin : public QObject, public MeshFilterInterface {
 public:
  /// ownMessages: what these filters say beside host/messages.def, for the tests of the pages,
  /// which read all of it as the property "messages".
  Plugin(const char* name, std::vector<std::unique_ptr<Filter>> filters,
         const std::vector<Message>& ownMessages = {});

  QString pluginName() const override { return name_; }
  QString filterName(FilterIDType id) const override { return qt(filters_.description(id).name); }
  QString filterScriptFunctionName(FilterIDType id) override {
    return qt(filters_.description(id).pythonName);
  }
  QString filterInfo(FilterIDType id) const override { return qt(filters_.info(id)); }
  FilterClass getClass(QAction* action) override;
  FILTER_ARITY filterArity(QAction* action) const override;
  int getRequirements(QAction*) override { return MeshModel::MM_NONE; }
  int getPreConditions(QAction*) const override { return MeshModel::MM_NONE; }
  int postCondition(QAction*) const override { return FilterSet::changes(); }
  void initParameterSet(QAction* action, MeshDocument& document, RichParameterList& list) override;
  bool applyFilter(QAction* action, MeshDocument& document, const RichParameterList& values,
                   vcg::CallBackPos* callback) override;

 private:
  QString name_;
  FilterSet filters_;
  Dialog dialog_;
};

}  // namespace sphere_propagation::host
