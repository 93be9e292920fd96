// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// What a filter is, in no host's words. A filter reads layers and parameters, calls vcg_ext, and
/// says what to change; it never touches the document itself.

#include <Eigen/Core>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "host/changes.h"
#include "host/layers.h"
#include "host/message.h"
#include "host/parameter.h"
#include "vcg_ext/base/progress.h"

namespace sphere_propagation::host {

/// Where MeshLab's menu shows a filter; several at once. What is in MeshCreation makes the first
/// layers: the plugins keep it enabled in an empty project (host/window.h).
enum class Menu {
  Remeshing = 1,
  Layer = 2,
  Measure = 4,
  MeshCreation = 8,
  VertexColoring = 16,
  Quality = 32,
  Cleaning = 64
};
inline int operator|(Menu a, Menu b) { return static_cast<int>(a) | static_cast<int>(b); }
inline int operator|(int a, Menu b) { return a | static_cast<int>(b); }

/// How many layers a filter works on.
enum class Arity { None, CurrentLayer, VisibleLayers };

struct FilterDescription {
  std::string name;        ///< the menu entry
  std::string pythonName;  ///< its name in PyMeshLab
  std::string info;        ///< HTML: all that there is to know
  std::string brief;       ///< HTML: what a dialog shows, of four to six lines
  int menus = 0;           ///< Menu values, or-ed
  Arity arity = Arity::CurrentLayer;
};

/// What a filter returns to scripts, beside the key of warnings.h.
using Outputs = std::map<std::string, std::variant<int, double, bool, Eigen::VectorXd>>;

/// One run of a filter.
struct Task {
  const Layers& layers;
  const ParameterValues& values;
  Changes& changes;
  std::function<void(const Remark&)> tell;  ///< what MeshLab's log and scripts are to know
  Progress progress;

  /// News that have no message of their own, as figures.
  void log(const std::string& line) const { tell({Message::Kind::News, "", "", line}); }
  /// What a message says of the result.
  template <class... Values>
  void say(const Message& message, const Values&... values) const {
    tell(remarkOn("", message, values...));
  }
  /// What it says of a layer.
  template <class... Values>
  void sayOf(const Layer& layer, const Message& message, const Values&... values) const {
    tell(remarkOn(layer.label(), message, values...));
  }
  /// The same of one that is yet to be made, by its label.
  template <class... Values>
  void sayOf(const std::string& layer, const Message& message, const Values&... values) const {
    tell(remarkOn(layer, message, values...));
  }
  /// What it says of layers that its text names.
  template <class... Values>
  void sayNaming(std::vector<std::string> layers, const Message& message,
                 const Values&... values) const {
    Remark remark = remarkOn("", message, values...);
    remark.layers = std::move(layers);
    tell(remark);
  }
};

class Filter {
 public:
  virtual ~Filter() = default;
  virtual FilterDescription describe() const = 0;
  /// Called when the dialog opens (not when the filter runs) and once when the plugin is loaded, on
  /// a document with one cube: quick, assumes nothing.
  virtual std::vector<Parameter> parameters(const Layers& layers) const = 0;
  /// Throws Error (vcg_ext/base/error.h) with a text for the user.
  virtual Outputs run(Task& task) const = 0;
};

}  // namespace sphere_propagation::host
