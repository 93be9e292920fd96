// SPDX-License-Identifier: GPL-3.0-only
#include "host/meshlab_2020/plugin.h"

#include <common/filterscript.h>

#include <QAction>
#include <map>
#include <utility>

#include "host/messages.h"
#include "host/window.h"

namespace sphere_propagation::host {

Plugin::Plugin(const char* name, std::vector<std::unique_ptr<Filter>> filters,
               const std::vector<Message>& ownMessages)
    : name_(name), filters_(std::move(filters)) {
  QStringList lines;
  for (const Message& message : messages::all) lines << qt(outline(message));
  for (const Message& message : ownMessages) lines << qt(outline(message));
  setProperty("messages", lines);
  for (int id = 0; id < filters_.size(); ++id) {
    typeList.push_back(id);
    // The host finds the plugin as an action's parent.
    actionList.push_back(new QAction(filterName(id), this));
    if ((filters_.description(id).menus & static_cast<int>(Menu::MeshCreation)) != 0)
      keepEnabled(*actionList.back());
  }
}

MeshFilterInterface::FilterClass Plugin::getClass(QAction* action) {
  const int menus = filters_.description(ID(action)).menus;
  const auto has = [menus](Menu m) { return (menus & static_cast<int>(m)) != 0; };
  int result = 0;
  if (has(Menu::Remeshing)) result |= Remeshing;
  if (has(Menu::Layer)) result |= Layer;
  if (has(Menu::Measure)) result |= Measure;
  if (has(Menu::MeshCreation)) result |= MeshCreation;
  if (has(Menu::VertexColoring)) result |= VertexColoring;
  if (has(Menu::Quality)) result |= Quality;
  if (has(Menu::Cleaning)) result |= Cleaning;
  return static_cast<FilterClass>(result);
}

MeshFilterInterface::FILTER_ARITY Plugin::filterArity(QAction* action) const {
  switch (filters_.description(ID(action)).arity) {
    case Arity::None:
      return NONE;
    case Arity::CurrentLayer:
      return SINGLE_MESH;
    case Arity::VisibleLayers:
      return VARIABLE;
  }
  return UNKNOWN_ARITY;
}

void Plugin::initParameterSet(QAction* action, MeshDocument& document, RichParameterList& list) {
  const int index = ID(action);
  list = filters_.parameters(index, document);
  std::map<QString, Dialog::Row> known;
  for (const Parameter& p : filters_.outline(index, document)) {
    const bool isFile = std::holds_alternative<Parameter::File>(p.value) ||
                        std::holds_alternative<Parameter::NewFile>(p.value);
    known[qt(p.name)] = {qt(p.name), p.advanced, isFile};
  }
  std::vector<Dialog::Row> rows;
  for (const RichParameter& p : list) rows.push_back(known[p.name()]);
  dialog_.expect(filterName(index), std::move(rows));
}

bool Plugin::applyFilter(QAction* action, MeshDocument& document, const RichParameterList& values,
                         vcg::CallBackPos* callback) {
  RichParameterList given(values);
  const std::map<QString, QString> paths = dialog_.pathsAtApply(filterName(ID(action)));
  for (const auto& [name, path] : paths)
    if (given.hasParameter(name)) given.setValue(name, FileValue(path));
  // The script of the project is to do what was done.
  if (FilterScript* history = document.filterHistory; !paths.empty() && history != nullptr &&
                                                      !history->isEmpty() &&
                                                      history->last().first == action->text())
    history->last().second = given;
  const FilterSet::Result result = filters_.run(ID(action), given, document, callback,
                                                [this](const std::string& line) { Log(line); });
  if (!result.failure) return true;
  errorMessage = qt(*result.failure);
  Log(*result.failure);  // meshlabserver prints the log, not the message
  return false;
}

}  // namespace sphere_propagation::host
