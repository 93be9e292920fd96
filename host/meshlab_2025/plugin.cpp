// SPDX-License-Identifier: GPL-3.0-only
#include "host/meshlab_2025/plugin.h"

#include <langinfo.h>

#include <QAction>
#include <QTextCodec>
#include <cstring>
#include <utility>

#include "host/messages.h"
#include "host/window.h"

namespace sphere_propagation::host {
namespace {

std::map<std::string, QVariant> toVariants(const Outputs& outputs) {
  std::map<std::string, QVariant> variants;
  for (const auto& [key, value] : outputs)
    variants[key] = std::visit([](const auto& v) { return QVariant::fromValue(v); }, value);
  return variants;
}

/// In the locale C, as of many servers, Qt turns every letter beyond ASCII in a file's name into a
/// question mark, and MeshLab finds no such file. UTF-8 is what Python uses there, and what holds
/// ASCII unchanged.
void openNamesBeyondAscii() {
  if (std::strcmp(nl_langinfo(CODESET), "ANSI_X3.4-1968") == 0)
    if (QTextCodec* const utf8 = QTextCodec::codecForName("UTF-8"))
      QTextCodec::setCodecForLocale(utf8);
}

}  // namespace

Plugin::Plugin(const char* name, std::vector<std::unique_ptr<Filter>> filters,
               const std::vector<Message>& ownMessages)
    : name_(name), filters_(std::move(filters)) {
  openNamesBeyondAscii();
  QStringList lines;
  for (const Message& message : messages::all) lines << qt(outline(message));
  for (const Message& message : ownMessages) lines << qt(outline(message));
  setProperty("messages", lines);
  for (int id = 0; id < filters_.size(); ++id) {
    typeList.push_back(id);
    // The GUI finds the plugin as an action's parent.
    actionList.push_back(new QAction(filterName(id), this));
    if ((filters_.description(id).menus & static_cast<int>(Menu::MeshCreation)) != 0)
      keepEnabled(*actionList.back());
  }
}

FilterPlugin::FilterClass Plugin::getClass(const QAction* action) const {
  const int menus = filters_.description(ID(action)).menus;
  const auto has = [menus](Menu m) { return (menus & static_cast<int>(m)) != 0; };
  int result = 0;
  if (has(Menu::Remeshing)) result |= FilterPlugin::Remeshing;
  if (has(Menu::Layer)) result |= FilterPlugin::Layer;
  if (has(Menu::Measure)) result |= FilterPlugin::Measure;
  if (has(Menu::MeshCreation)) result |= FilterPlugin::MeshCreation;
  if (has(Menu::VertexColoring)) result |= FilterPlugin::VertexColoring;
  if (has(Menu::Quality)) result |= FilterPlugin::Quality;
  if (has(Menu::Cleaning)) result |= FilterPlugin::Cleaning;
  return static_cast<FilterClass>(result);
}

FilterPlugin::FilterArity Plugin::filterArity(const QAction* action) const {
  switch (filters_.description(ID(action)).arity) {
    case Arity::None:
      return FilterPlugin::NONE;
    case Arity::CurrentLayer:
      return FilterPlugin::SINGLE_MESH;
    case Arity::VisibleLayers:
      return FilterPlugin::VARIABLE;
  }
  return FilterPlugin::UNKNOWN_ARITY;
}

RichParameterList Plugin::initParameterList(const QAction* action, const MeshDocument& document) {
  return filters_.parameters(ID(action), document);
}

std::map<std::string, QVariant> Plugin::applyFilter(const QAction* action,
                                                    const RichParameterList& values,
                                                    MeshDocument& document,
                                                    unsigned int& postConditionMask,
                                                    vcg::CallBackPos* callback) {
  const FilterSet::Result result = filters_.run(ID(action), values, document, callback,
                                                [this](const std::string& line) { log(line); });
  if (result.failure) {
    // PyMeshLab leaves the log of a MeshSet with the plugin when a filter throws, also after that
    // MeshSet is gone.
    setLog(nullptr);
    throw MLException(qt(*result.failure));
  }
  postConditionMask = static_cast<unsigned int>(result.changed);
  return toVariants(result.outputs);
}

}  // namespace sphere_propagation::host
