#pragma once
/// The one header on which plugins meet the hosts: a MeshLab filter plugin made of host::Filter objects. Whatever
/// differs between the hosts' interfaces stays in plugin.cpp, layers.cpp and changes.cpp.
///
/// A plugin derives from it, passes its filters, and adds Qt's declarations:
///   class MyPlugin : public QObject, public host::Plugin {
///     Q_OBJECT
///     MESHLAB_PLUGIN_IID_EXPORTER(FILTER_PLUGIN_IID)
///     Q_INTERFACES(FilterPlugin)
///    public:
///     MyPlugin() : host::Plugin("MyPlugin", makeMyFilters()) {}
///   };

#include <common/plugins/interfaces/filter_plugin.h>

#include <memory>
#include <vector>

#include "host/filter.h"

namespace sphere_propagation::host {

class Plugin : public FilterPlugin {
 public:
  Plugin(const char* name, std::vector<std::unique_ptr<Filter>> filters);
  ~Plugin() override;
  Plugin(const Plugin&) = delete;
  Plugin& operator=(const Plugin&) = delete;

  QString pluginName() const override { return name_; }
  QString vendor() const override { return "Sphere Propagation"; }
  QString filterName(ActionIDType id) const override;
  QString pythonFilterName(ActionIDType id) const override;
  QString filterInfo(ActionIDType id) const override;
  FilterClass getClass(const QAction* action) const override;
  FilterArity filterArity(const QAction* action) const override;
  int getRequirements(const QAction*) override { return MeshModel::MM_NONE; }
  int getPreConditions(const QAction*) const override { return MeshModel::MM_NONE; }
  int postCondition(const QAction* action) const override;
  RichParameterList initParameterList(const QAction* action, const MeshDocument& document) override;
  std::map<std::string, QVariant> applyFilter(const QAction* action, const RichParameterList& values,
                                              MeshDocument& document, unsigned int& postConditionMask,
                                              vcg::CallBackPos* callback) override;

 private:
  const Filter& filter(ActionIDType id) const { return *filters_.at(static_cast<size_t>(id)); }

  QString name_;
  std::vector<std::unique_ptr<Filter>> filters_;
  std::vector<FilterDescription> descriptions_;
  bool running_ = false;  // the GUI's progress callback runs its event loop: a second click on Apply comes in here
};

}  // namespace sphere_propagation::host
