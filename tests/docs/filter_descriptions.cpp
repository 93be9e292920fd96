// SPDX-License-Identifier: GPL-3.0-only
// What a plugin says of its filters, read through MeshLab's own interface, and what users read of
// errors. catalogue.py loads this library into a Python that has imported pymeshlab, whose MeshLab
// it then uses: PyMeshLab itself passes neither the description of a filter on, nor its menus.

#include <QDomDocument>
#include <QJsonArray>
#include <QJsonDocument>
#include <QJsonObject>
#include <QPluginLoader>
#include <QStringList>
#include <string>

#include "common/ml_document/mesh_document.h"
#include "common/plugins/interfaces/filter_plugin.h"
#include "host/remedies.h"

namespace {

QDomElement describe(const FilterPlugin& plugin, const QAction* action, QDomDocument& xml) {
  QDomElement filter = xml.createElement("filter");
  filter.setAttribute("name", plugin.filterName(action));
  filter.setAttribute("python_name", plugin.pythonFilterName(action));
  filter.setAttribute("classes", static_cast<int>(plugin.getClass(action)));
  filter.setAttribute("info", plugin.filterInfo(action));
  return filter;
}

QString qt(std::string_view text) {
  return QString::fromUtf8(text.data(), static_cast<int>(text.size()));
}

}  // namespace

/// JSON of all errors as each host words them, what varies as "…", and of the menu entries that
/// they name:
///   {"faults": [{"name": ..., "hosts": {HOST: {"sentence": ..., "remedy": ...}}}],
///    "entries": [{"name": ..., "python": ..., "2020.09": ...}]}
extern "C" __attribute__((visibility("default"))) const char* error_sentences() {
  namespace host = sphere_propagation::host;
  using sphere_propagation::Fault;
  static std::string text;
  QJsonArray faults, entries;
  for (int i = 1; i < sphere_propagation::faultCount; ++i) {  // the first has no words of its own
    const auto fault = static_cast<Fault>(i);
    QJsonObject hosts;
    for (const host::Host each : host::allHosts)
      hosts[qt(host::nameOf(each))] = QJsonObject{{"sentence", qt(host::outline(fault, each))},
                                                  {"remedy", qt(host::remedyOf(fault, each))}};
    faults.append(QJsonObject{{"name", qt(sphere_propagation::nameOf(fault))}, {"hosts", hosts}});
  }
  for (const host::MenuEntry& entry : host::menuEntries)
    entries.append(
        QJsonObject{{"name", entry.name},
                    {"python", entry.pythonName},
                    {"2020.09", entry.name2020 != nullptr ? entry.name2020 : entry.name}});
  text =
      QJsonDocument(QJsonObject{{"faults", faults}, {"entries", entries}}).toJson().toStdString();
  return text.c_str();
}

/// What the filters of a plugin say, a message a line, what varies as "…"; empty where the file is
/// no such plugin.
extern "C" __attribute__((visibility("default"))) const char* plugin_messages(const char* file) {
  static std::string text;
  text.clear();
  QPluginLoader loader(QString::fromUtf8(file));
  if (const QObject* plugin = loader.instance())
    text = plugin->property("messages").toStringList().join('\n').toStdString();
  return text.c_str();
}

/// Of all filters of a plugin, a line each, the name in Python, a tab, and the name in MeshLab's
/// menus; empty where the file is no such plugin.
extern "C" __attribute__((visibility("default"))) const char* filter_names(const char* file) {
  static std::string text;
  text.clear();
  QPluginLoader loader(QString::fromUtf8(file));
  auto* plugin = dynamic_cast<FilterPlugin*>(loader.instance());
  if (plugin == nullptr) return text.c_str();
  for (const QAction* action : plugin->actions())
    text +=
        (plugin->pythonFilterName(action) + "\t" + plugin->filterName(action) + "\n").toStdString();
  return text.c_str();
}

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
