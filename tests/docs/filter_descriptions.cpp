// SPDX-License-Identifier: GPL-3.0-only
// What a plugin says of its filters, read through MeshLab's own interface. reference.py loads this
// library into a Python that has imported pymeshlab, whose MeshLab it then uses: PyMeshLab itself
// passes neither the description of a filter on, nor its menus.

#include <QDomDocument>
#include <QPluginLoader>
#include <string>

#include "common/ml_document/mesh_document.h"
#include "common/plugins/interfaces/filter_plugin.h"

namespace {

QDomElement describe(const FilterPlugin& plugin, const QAction* action, QDomDocument& xml) {
  QDomElement filter = xml.createElement("filter");
  filter.setAttribute("name", plugin.filterName(action));
  filter.setAttribute("python_name", plugin.pythonFilterName(action));
  filter.setAttribute("classes", static_cast<int>(plugin.getClass(action)));
  filter.setAttribute("info", plugin.filterInfo(action));
  return filter;
}

}  // namespace

/// XML of all filters of a plugin, with their parameters as in a filter script; empty where the
/// file is no such plugin. The text belongs to the library and lasts until the next call.
extern "C" __attribute__((visibility("default"))) const char* filter_descriptions(
    const char* file) {
  static std::string text;
  text.clear();
  QPluginLoader loader(QString::fromUtf8(file));
  auto* plugin = dynamic_cast<FilterPlugin*>(loader.instance());
  if (plugin == nullptr) return text.c_str();

  QDomDocument xml;
  QDomElement root = xml.createElement("filters");
  xml.appendChild(root);
  const MeshDocument document;
  for (const QAction* action : plugin->actions()) {
    QDomElement filter = describe(*plugin, action, xml);
    const RichParameterList parameters = plugin->initParameterList(action, document);
    for (const RichParameter& parameter : parameters) {
      QDomElement element = parameter.fillToXMLDocument(xml);
      element.setAttribute("advanced", parameter.isAdvanced() ? "true" : "false");
      filter.appendChild(element);
    }
    root.appendChild(filter);
  }
  text = xml.toString().toStdString();
  return text.c_str();
}
