// SPDX-License-Identifier: GPL-3.0-only
// "Prepare surface": meshes as they come become closed surfaces, in their layers.

#include <algorithm>
#include <numeric>
#include <utility>

#include "filter_sphere_propagation/filters.h"
#include "filter_sphere_propagation/messages.h"
#include "filter_sphere_propagation/reporting.h"
#include "filter_sphere_propagation/summaries.h"
#include "host/help.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/preparation/surface_preparation.h"

namespace sphere_propagation {
namespace {

constexpr host::Named<LidShape> lidShapes[]{{"Curved", LidShape::Curved}, {"Flat", LidShape::Flat}};

PreparationParameters preparationOf(const host::ParameterValues& values) {
  PreparationParameters parameters;
  parameters.weld = values.flag("weld");
  parameters.removeDuplicateFaces = values.flag("remove_duplicate_faces");
  parameters.removeFins = values.flag("remove_fins");
  parameters.joinShells = values.flag("join_shells");
  parameters.keepLargestComponent = values.flag("keep_largest_component");
  parameters.closeOpenings = values.flag("close_openings");
  parameters.lid = values.choice("lid", lidShapes);
  parameters.orient = values.flag("orient");
  parameters.removeHandles = values.flag("remove_handles");
  return parameters;
}

long lidVerticesOf(const PreparedMesh& mesh) {
  return std::count_if(mesh.lid.begin(), mesh.lid.end(), [](int number) { return number > 0; });
}

double lidShareOf(const PreparedMesh& mesh) {
  const Eigen::VectorXd areas = faceAreas(mesh.vertices, mesh.faces);
  double lids = 0;
  for (Eigen::Index f = 0; f < areas.size(); ++f)
    if (mesh.faceLid[static_cast<size_t>(f)] > 0) lids += areas[f];
  return lids > 0 ? lids / areas.sum() : 0;
}

/// "3 vertices welded; 1 opening closed".
std::string stepsOf(const PreparedMesh& mesh) {
  std::string text;
  const auto add = [&text](long count, const std::string& words) {
    if (count > 0) text += (text.empty() ? "" : "; ") + words;
  };
  const auto step = [&add](long count, const host::Message& message) {
    add(count, host::said(message, count));
  };
  step(mesh.nonFiniteVertices, messages::droppedNonFinite);
  step(mesh.weldedVertices, messages::welded);
  step(mesh.unusedVertices, messages::droppedUnused);
  step(mesh.duplicateFaces, messages::droppedDuplicates);
  step(mesh.flatFaces, messages::mendedFlat);
  add(mesh.sheets.edges, host::said(messages::separatedSheets, mesh.sheets.edges,
                                    mesh.sheets.droppedFaces, mesh.sheets.splitVertices));
  step(mesh.sheets.vertices, messages::separatedVertices);
  step(mesh.dropped.parts, messages::droppedParts);
  step(static_cast<long>(mesh.openings.size()), messages::closedOpenings);
  step(mesh.turnedFaces, messages::turnedFaces);
  add(mesh.handles, host::said(messages::removedHandles, mesh.handles, mesh.voxelSize));
  return text;
}

std::string closureOf(const Opening& opening, bool isRing) {
  if (isRing)
    return "a ring between the shells, of " +
           counted(opening.newVertices, "new vertex", "new vertices");
  if (opening.newFaces == 0) return "laying them on each other";
  if (opening.newVertices == 0) return counted(opening.newFaces, "face", "faces");
  return std::string(opening.shape == LidShape::Flat ? "a flat lid" : "a curved lid") + " of " +
         counted(opening.newVertices, "new vertex", "new vertices");
}

void tellOfOpenings(const host::Task& task, const std::string& label, const PreparedMesh& mesh) {
  constexpr size_t most = 10;
  std::vector<size_t> order(mesh.openings.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return mesh.openings[a].perimeter > mesh.openings[b].perimeter;
  });
  int rest = 0;
  for (size_t i = 0; i < order.size(); ++i) {
    const Opening& opening = mesh.openings[order[i]];
    if (i < most)
      task.say(messages::opening, label, order[i] + 1, opening.edges, opening.perimeter,
               closureOf(opening, static_cast<int>(order[i]) < mesh.rings));
    else
      rest += opening.edges;
  }
  if (order.size() > most) task.say(messages::moreOpenings, label, order.size() - most, rest);
  if (const long count = lidVerticesOf(mesh); count > 0)
    task.say(messages::lidsMarked, label, count);
}

/// What is stated of a surface, without its name.
std::string withoutName(const Finding& finding) {
  const std::string text = statement(finding, "layer");
  const size_t at = text.find("\": ");
  return at == std::string::npos ? text : text.substr(at + 3);
}

/// What is said of a surface that is not ready; it advises no step that was done.
const host::Message& messageOfLeft(const PreparedMesh& mesh,
                                   const PreparationParameters& parameters) {
  const bool allSteps = parameters.weld && parameters.removeDuplicateFaces &&
                        parameters.removeFins && parameters.keepLargestComponent &&
                        parameters.closeOpenings && parameters.orient;
  switch (mesh.left->fault) {
    case Fault::Empty:
    case Fault::NoFaces:
    case Fault::TooFewVertices:
      return messages::tooLittleLeft;
    case Fault::Handles:
      return parameters.removeHandles ? messages::notMended : messages::handlesLeft;
    default:
      if (mesh.oneSided) return messages::oneSided;
      return allSteps ? messages::notMended : messages::notClosedYet;
  }
}

/// A face or two that are missing are no opening.
bool isOpening(const Opening& opening) {
  constexpr int fewEdges = 4;
  return opening.edges > fewEdges || opening.newVertices > 0;
}

/// How many openings of a wall whose sides were joined got lids.
long openingsBesideRings(const PreparedMesh& mesh) {
  if (mesh.rings == 0) return 0;
  return std::count_if(mesh.openings.begin() + mesh.rings, mesh.openings.end(), isOpening);
}

void tellOf(const host::Task& task, const host::Layer& layer, const MeshContent& before,
            const PreparedMesh& mesh, const PreparationParameters& parameters) {
  const std::string label = layer.label();
  if (mesh.changed)
    task.say(messages::prepared, label, mesh.vertices.rows(), mesh.faces.rows(),
             before.vertices.rows(), before.faces.rows(), stepsOf(mesh));
  else
    task.say(mesh.left ? messages::notPrepared : messages::nothingToPrepare, label);
  tellOfOpenings(task, label, mesh);
  for (size_t i = static_cast<size_t>(mesh.rings); i < mesh.openings.size(); ++i)
    if (const Opening& opening = mesh.openings[i]; isRagged(opening))
      task.sayOf(layer, messages::raggedRim, i + 1, opening.perimeter / opening.outline);
  constexpr double large = 0.05, largeOfSheets = 0.01, largeOfLids = 0.25;
  if (const double share = lidShareOf(mesh); share > largeOfLids)
    task.sayOf(layer, messages::mostlyLids, 100 * share);
  if (mesh.sheets.droppedShare > largeOfSheets)
    task.sayOf(layer, messages::largeSheetsDropped, 100 * mesh.sheets.droppedShare);
  if (const long others = openingsBesideRings(mesh); others > 0)
    task.sayOf(layer, messages::wallClosed, mesh.rings, others);
  if (mesh.shells)
    task.sayOf(layer, messages::shellsNotJoined);
  else if (mesh.dropped.largestShare > large)
    task.sayOf(layer, parameters.joinShells ? messages::partNotJoined : messages::largePartDropped,
               100 * mesh.dropped.largestShare);
  if (mesh.left) task.sayOf(layer, messageOfLeft(mesh, parameters), withoutName(*mesh.left));
}

/// Where the job stands, once these layers are prepared.
class PreparationSummary {
 public:
  void add(const host::Layer& layer, const PreparedMesh& mesh) {
    ids_.push_back(layer.id());
    changed_ += mesh.changed;
    closed_ += !mesh.left;
    // A map does not outlive the mesh that it is of.
    if (mesh.changed) remade_.push_back(layer.id());
  }

  void tell(const host::Task& task, bool allVisible) const {
    const auto has = [](const std::vector<int>& ids, const host::Layer& layer) {
      return std::find(ids.begin(), ids.end(), layer.id()) != ids.end();
    };
    size_t mapped = 0, others = 0;
    for (const host::Layer& layer : task.layers.visible(host::LayerKind::Surface)) {
      mapped += !has(remade_, layer) && layer.hasMap();
      others += !has(ids_, layer);
    }
    std::string leftOut;
    if (allVisible)
      leftOut = hiddenLeftOut(task.layers, host::LayerKind::Surface);
    else if (others > 0)
      leftOut = host::said(messages::othersNotPrepared, others);
    task.say(messages::surfacesPrepared, ids_.size(), changed_, closed_, leftOut,
             closed_ < ids_.size() ? host::said(messages::nextIsInWarnings)
                                   : nextFilter(task.layers, mapped));
  }

 private:
  std::vector<int> ids_, remade_;
  size_t changed_ = 0, closed_ = 0;
};

/// Perimeters of what was open: now, or in an earlier run, whose lids tell.
std::vector<double> openingSizes(const PreparedMesh& mesh, const host::Layer& layer,
                                 const MeshContent& before) {
  std::vector<double> sizes =
      lidSizes(before.vertices, before.faces, layer.lids(before.meshVertex));
  for (const Opening& opening : mesh.openings)
    if (isOpening(opening)) sizes.push_back(opening.perimeter);
  return sizes;
}

/// One number per layer, by the names that scripts read.
class PreparationFigures {
 public:
  explicit PreparationFigures(size_t layers) : layers_(static_cast<Eigen::Index>(layers)) {}

  void set(size_t layer, const PreparedMesh& mesh, const MeshContent& before, double seconds) {
    const auto put = [&](const char* name, double value) {
      Eigen::VectorXd& row = figures_[name];
      if (row.size() == 0) row = Eigen::VectorXd::Zero(layers_);
      row[static_cast<Eigen::Index>(layer)] = value;
    };
    put("weld", mesh.weldedVertices + mesh.unusedVertices + mesh.nonFiniteVertices);
    put("remove_duplicate_faces", mesh.duplicateFaces + mesh.flatFaces);
    put("remove_fins", static_cast<double>(mesh.sheets.edges + mesh.sheets.vertices));
    put("join_shells", mesh.joinedShells);
    put("keep_largest_component", static_cast<double>(mesh.dropped.parts));
    put("close_openings", static_cast<double>(mesh.openings.size()));
    put("lid", static_cast<double>(lidVerticesOf(mesh)));
    put("orient", mesh.turnedFaces);
    put("remove_handles", mesh.handles);
    put("closed", mesh.left ? 0 : 1);
    put("vertices", static_cast<double>(mesh.vertices.rows()));
    put("vertices_before", static_cast<double>(before.vertices.rows()));
    put("seconds", seconds);
    for (const Opening& opening : mesh.openings) {
      openingLayer_.push_back(static_cast<double>(layer));
      openingEdges_.push_back(opening.edges);
      openingPerimeter_.push_back(opening.perimeter);
    }
  }

  host::Outputs outputs() const {
    host::Outputs outputs;
    for (const auto& [name, row] : figures_) outputs[name] = row;
    const auto list = [](const std::vector<double>& values) -> Eigen::VectorXd {
      return Eigen::Map<const Eigen::VectorXd>(values.data(),
                                               static_cast<Eigen::Index>(values.size()));
    };
    outputs["opening_layer"] = list(openingLayer_);
    outputs["opening_edges"] = list(openingEdges_);
    outputs["opening_perimeter"] = list(openingPerimeter_);
    return outputs;
  }

 private:
  Eigen::Index layers_;
  std::map<std::string, Eigen::VectorXd> figures_;
  std::vector<double> openingLayer_, openingEdges_, openingPerimeter_;
};

host::RemadeMesh remadeMesh(const PreparedMesh& mesh) {
  host::RemadeMesh remade{mesh.vertices, mesh.faces, mesh.source, {}, {}, {}};
  Eigen::VectorXd lid(static_cast<Eigen::Index>(mesh.lid.size()));
  for (size_t v = 0; v < mesh.lid.size(); ++v) lid[static_cast<Eigen::Index>(v)] = mesh.lid[v];
  remade.scalarAttributes[host::lidAttribute] = lid;
  for (const int number : mesh.lid) remade.selectedVertices.push_back(number > 0);
  for (const int number : mesh.faceLid) remade.selectedFaces.push_back(number > 0);
  return remade;
}

class PreparationFilter : public host::Filter {
 public:
  host::FilterDescription describe() const override {
    return help_.describe(host::Menu::Cleaning | host::Menu::Layer, host::Arity::VisibleLayers);
  }

  std::vector<host::Parameter> parameters(const host::Layers&) const override {
    const PreparationParameters defaults;
    return {
        help_.parameter("all_visible", false),
        help_.parameter("weld", defaults.weld),
        help_.parameter("remove_duplicate_faces", defaults.removeDuplicateFaces),
        help_.parameter("remove_fins", defaults.removeFins),
        help_.parameter("join_shells", defaults.joinShells),
        help_.parameter("keep_largest_component", defaults.keepLargestComponent),
        help_.parameter("close_openings", defaults.closeOpenings),
        help_.parameter("lid", host::choiceOf(lidShapes, defaults.lid)),
        help_.parameter("orient", defaults.orient),
        help_.parameter("remove_handles", defaults.removeHandles),
    };
  }

  host::Outputs run(host::Task& task) const override {
    const PreparationParameters parameters = preparationOf(task.values);
    const bool allVisible = task.values.flag("all_visible");
    const std::vector<host::Layer> layers = allVisible
                                                ? task.layers.visibleSurfaces()
                                                : std::vector<host::Layer>{task.layers.current()};
    PreparationFigures figures(layers.size());
    PreparationSummary summary;
    std::vector<std::string> names;
    std::vector<std::vector<double>> openings;  // perimeters
    for (size_t i = 0; i < layers.size(); ++i) {
      const Stopwatch clock;
      const MeshContent before = layers[i].content();
      const auto share = [&](size_t done) {
        return static_cast<double>(done) / static_cast<double>(layers.size());
      };
      const PreparedMesh mesh =
          preparedMesh(before.vertices, before.faces, parameters, layers[i].label(),
                       part(task.progress, share(i), share(i + 1)));
      tellOf(task, layers[i], before, mesh, parameters);
      figures.set(i, mesh, before, clock.seconds());
      summary.add(layers[i], mesh);
      names.push_back(layers[i].label());
      openings.push_back(openingSizes(mesh, layers[i], before));
      if (mesh.changed) task.changes.remakeMesh(layers[i], before, remadeMesh(mesh));
    }
    if (parameters.closeOpenings) warnOfOpenings(task, names, openings);
    summary.tell(task, allVisible);
    return figures.outputs();
  }

 private:
  const host::Help help_{"apply_surface_preparation"};
};

}  // namespace

std::unique_ptr<host::Filter> makePreparationFilter() {
  return std::make_unique<PreparationFilter>();
}

}  // namespace sphere_propagation
