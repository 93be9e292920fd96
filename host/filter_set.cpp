// SPDX-License-Identifier: GPL-3.0-only
#include "host/filter_set.h"

#include <algorithm>
#include <exception>
#include <new>
#include <utility>

#include "host/input_guard.h"
#include "host/messages.h"
#include "host/remedies.h"
#include "host/warnings.h"
#include "host/window.h"

namespace sphere_propagation::host {
namespace {

void add(RichParameterList& list, const Parameter& parameter, const MeshDocument& document) {
  struct Visitor {
    RichParameterList& list;
    const Parameter& p;
    const MeshDocument& document;
    void operator()(bool v) const { addRichParameter<RichBool>(list, p, v); }
    void operator()(int v) const { addRichParameter<RichInt>(list, p, v); }
    void operator()(double v) const {
      addRichParameter<RichFloat>(list, p, static_cast<Scalarm>(v));
    }
    void operator()(const std::string& v) const { addRichParameter<RichString>(list, p, qt(v)); }
    void operator()(const Parameter::Choice& v) const {
      QStringList names;
      for (const std::string& n : v.names) names << qt(n);
      addRichParameter<RichEnum>(list, p, v.chosen, names);
    }
    void operator()(const Parameter::LayerId&) const { addLayerParameter(list, p, document); }
    void operator()(const Parameter::File& v) const {
      addRichParameter<RichFileOpen>(list, p, QString(), QStringList(qt(v.filter)));
    }
    void operator()(const Parameter::NewFile& v) const {
      addRichParameter<RichFileSave>(list, p, QString(), qt(v.filter));
    }
  };
  std::visit(Visitor{list, parameter, document}, parameter.value);
}

class RichValues : public ParameterValues {
 public:
  explicit RichValues(const RichParameterList& list) : list_(list) {}
  bool flag(const std::string& name) const override { return list_.getBool(qt(name)); }
  int integer(const std::string& name) const override { return list_.getInt(qt(name)); }
  double real(const std::string& name) const override {
    return static_cast<double>(list_.getFloat(qt(name)));
  }
  std::string text(const std::string& name) const override {
    return list_.getString(qt(name)).toStdString();
  }
  int index(const std::string& name) const override { return list_.getEnum(qt(name)); }
  int layerId(const std::string& name) const override { return chosenLayerId(list_, name); }
  std::string file(const std::string& name) const override {
    return list_.getOpenFileName(qt(name)).toStdString();
  }
  std::string newFile(const std::string& name) const override {
    return list_.getSaveFileName(qt(name)).toStdString();
  }

 private:
  const RichParameterList& list_;
};

/// Writes what is kept for the end of the log, also where the filter fails.
class EndOfLog {
 public:
  EndOfLog(const std::vector<Remark>& remarks, const std::function<void(const std::string&)>& log)
      : remarks_(remarks), log_(log) {}
  EndOfLog(const EndOfLog&) = delete;
  EndOfLog& operator=(const EndOfLog&) = delete;
  ~EndOfLog() {
    try {
      write(false);
      write(true);
    } catch (...) {  // the log has no room
    }
  }

 private:
  void write(bool summaries) const {
    for (const Remark& remark : remarks_)
      if (remark.kind != Message::Kind::News &&
          (remark.kind == Message::Kind::Summary) == summaries)
        log_(remark.line());
  }

  const std::vector<Remark>& remarks_;
  const std::function<void(const std::string&)>& log_;
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

}  // namespace

FilterSet::FilterSet(std::vector<std::unique_ptr<Filter>> filters) : filters_(std::move(filters)) {
  for (const auto& filter : filters_) descriptions_.push_back(filter->describe());
}

FilterSet::~FilterSet() = default;

const std::string& FilterSet::info(int index) const {
  const FilterDescription& filter = description(index);
  return thisHost() == Host::PyMeshLab ? filter.info : filter.brief;
}

RichParameterList FilterSet::parameters(int index, const MeshDocument& document) const {
  RichParameterList list;
  for (const Parameter& p : outline(index, document)) add(list, p, document);
  return list;
}

std::vector<Parameter> FilterSet::outline(int index, const MeshDocument& document) const {
  return filters_.at(static_cast<size_t>(index))->parameters(Layers(document));
}

int FilterSet::changes() {
  return MeshModel::MM_VERTTEXCOORD | MeshModel::MM_VERTNUMBER | MeshModel::MM_FACENUMBER;
}

FilterSet::Result FilterSet::run(int index, const RichParameterList& values, MeshDocument& document,
                                 vcg::CallBackPos* callback,
                                 const std::function<void(const std::string&)>& log) {
  if (running_) return {said(messages::stillRunning), {}};
  struct Running {
    bool& flag;
    explicit Running(bool& f) : flag(f) { flag = true; }
    ~Running() { flag = false; }
    Running(const Running&) = delete;
    Running& operator=(const Running&) = delete;
  } running(running_);
  const InputGuard handsOff;

  std::string name;
  try {
    name = description(index).name;
    const Filter& filter = *filters_.at(static_cast<size_t>(index));
    Changes changes(document);
    const Layers layers(document);
    layers.requireRead();
    const RichValues richValues(values);
    std::vector<Remark> remarks;
    const auto tell = [&](const Remark& remark) {
      if (remark.kind == Message::Kind::News) log(remark.line());
      remarks.push_back(remark);
    };
    // What matters is said last, where it is seen: warnings and notes, then where the job stands.
    const EndOfLog end(remarks, log);
    Task task{layers, richValues, changes, tell, percentReporter(callback, name)};
    Outputs outputs = filter.run(task);
    if (auto warnings = encodedWarnings(remarks)) outputs[warningsKey] = std::move(*warnings);
    report(task.progress, 1);  // runs the GUI's event loop, which must not meet layers that MeshLab
                               // has yet to take in
    const bool moves = changes.movesLayers();
    const int changed = changes.commit();
    if (moves) showEverything();
    return {std::nullopt, std::move(outputs), changed};
  } catch (const Error& error) {
    return {sentence(error), {}};
  } catch (const MLException& error) {  // a parameter is missing
    return {error.what(), {}};
  } catch (const std::bad_alloc&) {
    return {said(messages::notEnoughMemory, name), {}};
  } catch (const std::exception& error) {
    return {said(messages::internalError, name, error.what()), {}};
  } catch (...) {
    return {said(messages::unknownError, name), {}};
  }
}

}  // namespace sphere_propagation::host
