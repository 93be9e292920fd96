#include "host/plugin.h"

#include <common/parameters/rich_parameter_list.h>

#include <algorithm>
#include <exception>
#include <new>
#include <utility>

namespace sphere_propagation::host {
namespace {

QString qt(const std::string& s) { return QString::fromStdString(s); }

void addRichParameter(RichParameterList& list, const Parameter& p, const MeshDocument& document) {
  const QString name = qt(p.name), label = qt(p.label), help = qt(p.help);
  struct Visitor {
    RichParameterList& list;
    const MeshDocument& document;
    const QString &name, &label, &help;
    bool advanced;
    void operator()(bool v) const { list.addParam(RichBool(name, v, label, help, advanced)); }
    void operator()(int v) const { list.addParam(RichInt(name, v, label, help, advanced)); }
    void operator()(double v) const { list.addParam(RichFloat(name, static_cast<Scalarm>(v), label, help, advanced)); }
    void operator()(const std::string& v) const { list.addParam(RichString(name, qt(v), label, help, advanced)); }
    void operator()(const Parameter::Choice& v) const {
      QStringList names;
      for (const std::string& n : v.names) names << qt(n);
      list.addParam(RichEnum(name, v.chosen, names, label, help, advanced));
    }
    void operator()(const Parameter::LayerId& v) const {
      list.addParam(RichMesh(name, static_cast<unsigned int>(std::max(v.id, 0)), &document, label, help, advanced));
    }
  };
  std::visit(Visitor{list, document, name, label, help, p.advanced}, p.value);
}

class RichValues : public ParameterValues {
 public:
  explicit RichValues(const RichParameterList& list) : list_(list) {}
  bool flag(const std::string& name) const override { return list_.getBool(qt(name)); }
  int integer(const std::string& name) const override { return list_.getInt(qt(name)); }
  double real(const std::string& name) const override { return static_cast<double>(list_.getFloat(qt(name))); }
  std::string text(const std::string& name) const override { return list_.getString(qt(name)).toStdString(); }
  int choice(const std::string& name) const override { return list_.getEnum(qt(name)); }
  int layerId(const std::string& name) const override { return static_cast<int>(list_.getMeshId(qt(name))); }

 private:
  const RichParameterList& list_;
};

/// Calls MeshLab's callback when the percentage changes, and never backwards.
Progress percentReporter(vcg::CallBackPos* callback, const std::string& name) {
  if (callback == nullptr) return {};
  const auto last = std::make_shared<int>(-1);  // shared by the copies that steps make of it
  return [callback, name, last](double fraction) {
    const int percent = std::clamp(static_cast<int>(100 * fraction), 0, 100);
    if (percent > *last) callback(*last = percent, name.c_str());
  };
}

std::map<std::string, QVariant> toVariants(const Outputs& outputs) {
  std::map<std::string, QVariant> variants;
  for (const auto& [key, value] : outputs)
    variants[key] = std::visit([](const auto& v) { return QVariant::fromValue(v); }, value);
  return variants;
}

}  // namespace

Plugin::Plugin(const char* name, std::vector<std::unique_ptr<Filter>> filters)
    : name_(name), filters_(std::move(filters)) {
  for (size_t i = 0; i < filters_.size(); ++i) {
    descriptions_.push_back(filters_[i]->describe());
    typeList.push_back(static_cast<ActionIDType>(i));
  }
  for (size_t i = 0; i < filters_.size(); ++i)
    actionList.push_back(new QAction(qt(descriptions_[i].name)));  // owned by the host, as in all of its plugins
}

Plugin::~Plugin() = default;

QString Plugin::filterName(ActionIDType id) const { return qt(descriptions_.at(static_cast<size_t>(id)).name); }
QString Plugin::pythonFilterName(ActionIDType id) const {
  return qt(descriptions_.at(static_cast<size_t>(id)).pythonName);
}
QString Plugin::filterInfo(ActionIDType id) const { return qt(descriptions_.at(static_cast<size_t>(id)).info); }

FilterPlugin::FilterClass Plugin::getClass(const QAction* action) const {
  const int menus = descriptions_.at(static_cast<size_t>(ID(action))).menus;
  const auto has = [menus](Menu m) { return (menus & static_cast<int>(m)) != 0; };
  int result = 0;
  if (has(Menu::Remeshing)) result |= FilterPlugin::Remeshing;
  if (has(Menu::Layer)) result |= FilterPlugin::Layer;
  if (has(Menu::Measure)) result |= FilterPlugin::Measure;
  if (has(Menu::MeshCreation)) result |= FilterPlugin::MeshCreation;
  return static_cast<FilterClass>(result);
}

FilterPlugin::FilterArity Plugin::filterArity(const QAction* action) const {
  switch (descriptions_.at(static_cast<size_t>(ID(action))).arity) {
    case Arity::None:
      return FilterPlugin::NONE;
    case Arity::CurrentLayer:
      return FilterPlugin::SINGLE_MESH;
    case Arity::VisibleLayers:
      return FilterPlugin::VARIABLE;
  }
  return FilterPlugin::UNKNOWN_ARITY;
}

int Plugin::postCondition(const QAction*) const { return MeshModel::MM_VERTTEXCOORD; }

RichParameterList Plugin::initParameterList(const QAction* action, const MeshDocument& document) {
  RichParameterList list;
  for (const Parameter& p : filter(ID(action)).parameters(Layers(document))) addRichParameter(list, p, document);
  return list;
}

std::map<std::string, QVariant> Plugin::applyFilter(const QAction* action, const RichParameterList& values,
                                                    MeshDocument& document, unsigned int& postConditionMask,
                                                    vcg::CallBackPos* callback) {
  if (running_) throw MLException("A filter of this plugin is still running: wait until it has finished.");
  struct Running {
    bool& flag;
    explicit Running(bool& f) : flag(f) { flag = true; }
    ~Running() { flag = false; }
    Running(const Running&) = delete;
    Running& operator=(const Running&) = delete;
  } running(running_);
  const FilterDescription& description = descriptions_.at(static_cast<size_t>(ID(action)));
  // PyMeshLab leaves the log of a MeshSet with the plugin when a filter throws, also after that MeshSet is gone.
  struct ForgetLogOnError {
    FilterPlugin& plugin;
    const int before = std::uncaught_exceptions();
    ~ForgetLogOnError() {
      if (std::uncaught_exceptions() > before) plugin.setLog(nullptr);
    }
  } forgetLogOnError{*this};
  // Hosts survive their own exception only.
  try {
    Changes changes(document);
    const Layers layers(document);
    const RichValues richValues(values);
    Task task{layers, richValues, changes, [this](const std::string& line) { log(line); },
              percentReporter(callback, description.name)};
    const Outputs outputs = filter(ID(action)).run(task);
    changes.commit();
    report(task.progress, 1);
    postConditionMask = MeshModel::MM_VERTTEXCOORD | MeshModel::MM_VERTCOLOR;
    return toVariants(outputs);
  } catch (const MLException&) {
    throw;
  } catch (const Error& error) {
    throw MLException(qt(error.what()));
  } catch (const std::bad_alloc&) {
    throw MLException(qt(description.name + ": there is not enough memory for this."));
  } catch (const std::exception& error) {
    throw MLException(qt(description.name + ": internal error: " + error.what()));
  } catch (...) {
    throw MLException(qt(description.name + ": internal error of an unknown kind."));
  }
}

}  // namespace sphere_propagation::host
