// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The plugin as MeshLab and PyMeshLab since 2021 see it. Errors reach them as MLException.

#include <common/plugins/interfaces/filter_plugin.h>

#include <QObject>
#include <map>
#include <memory>
#include <vector>

#include "host/filter_set.h"

#define HOST_PLUGIN_INTERFACE FilterPlugin
#define HOST_PLUGIN_IID FILTER_PLUGIN_IID

namespace sphere_propagation::host {

class Plugin : public QObject, public FilterPlugin {
 public:
  /// ownMessages: what these filters say beside host/messages.def, for the tests of the pages,
  /// which read all of it as the property "messages".
  Plugin(const char* name, std::vector<std::unique_ptr<Filter>> filters,
         const std::vector<Message>& ownMessages = {});

  QString pluginName() const override { return name_; }
  QString vendor() const override { return "Sphere Propagation"; }
  QString filterName(ActionIDType id) const override { return qt(filters_.description(id).name); }
  QString pythonFilterName(ActionIDType id) const override {
    return qt(filters_.description(id).pythonName);
  }
  QString filterInfo(ActionIDType id) const override { return qt(filters_.info(id)); }
  FilterClass getClass(const QAction* action) const override;
  FilterArity filterArity(const QAction* action) const override;
  int getRequirements(const QAction*) override { return MeshModel::MM_NONE; }
  int getPreConditions(const QAction*) const override { return MeshModel::MM_NONE; }
  int postCondition(const QAction*) const override { return FilterSet::changes(); }
  RichParameterList initParameterList(const QAction* action, const MeshDocument& document) override;
  std::map<std::string, QVariant> applyFilter(const QAction* action,
                                              const RichParameterList& values,
                                              MeshDocument& document,
                                              unsigned int& postConditionMask,
                                              vcg::CallBackPos* callback) override;

 private:
  QString name_;
  FilterSet filters_;
};

}  // namespace sphere_propagation::host
