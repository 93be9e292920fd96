// SPDX-License-Identifier: GPL-3.0-only
// "Optimise parameterisations groupwise": the maps of a population are moved until one model of
// shape explains all surfaces together.

#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <utility>

#include "filter_sphere_propagation/anchor_sources.h"
#include "filter_sphere_propagation/filters.h"
#include "filter_sphere_propagation/mapped_layers.h"
#include "filter_sphere_propagation/messages.h"
#include "filter_sphere_propagation/reporting.h"
#include "filter_sphere_propagation/summaries.h"
#include "host/help.h"
#include "vcg_ext/base/fingerprint.h"
#include "vcg_ext/groupwise/groupwise.h"

namespace sphere_propagation {
namespace {

constexpr host::Named<Alignment> poses[]{
    {"Rigid", Alignment::Rigid}, {"Similarity", Alignment::Similarity}, {"None", Alignment::None}};
constexpr host::Named<GroupwiseObjective> objectives[]{
    {"Population model", GroupwiseObjective::PopulationModel},
    {"Description length", GroupwiseObjective::DescriptionLength}};

enum class GroupwiseAnchors { Off, Soft };
constexpr host::Named<GroupwiseAnchors> groupwiseAnchors[]{{"Off", GroupwiseAnchors::Off},
                                                           {"Soft", GroupwiseAnchors::Soft}};

/// Those that layers carry, of all layers, or none at all. Names those that one layer alone has.
std::vector<AnchorSet> anchorsOf(const host::Task& task, const std::vector<MappedLayer>& layers) {
  std::vector<AnchorSet> sets;
  std::map<std::string, int> shared;
  for (const MappedLayer& layer : layers) {
    sets.push_back(layer.layer.anchors());
    for (const auto& [name, place] : sets.back()) ++shared[name];
    if (!sets.back().empty()) warnOfFarAnchors(task, layer.layer, sets.back());
  }
  std::vector<std::string> lonely;
  for (const auto& [name, count] : shared)
    if (count < 2) lonely.push_back(name);
  if (!lonely.empty()) task.say(messages::anchorsOnOneLayer, namesIn(lonely));
  return shared.size() > lonely.size() ? sets : std::vector<AnchorSet>{};
}

Eigen::VectorXd vectorOf(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

constexpr double trusted = 0.5;         // below this, a shape is named
constexpr double squeezedToSay = 0.01;  // of a surface

/// The maps that are optimised together belong together, and to no others any more.
int markOf(const Groupwise& optimised) {
  Fingerprint print;
  for (const GroupwiseShape& shape : optimised.shapes) {
    print.add(shape.map.vertexCount());
    print.add(shape.map.positions().sum());
  }
  return print.short24();
}

class GroupwiseFilter : public host::Filter {
 public:
  host::FilterDescription describe() const override {
    return help_.describe(host::Menu::Remeshing | host::Menu::Layer, host::Arity::VisibleLayers);
  }

  std::vector<host::Parameter> parameters(const host::Layers&) const override {
    const GroupwiseParameters defaults;
    return {help_.parameter("alignment", host::choiceOf(poses, defaults.alignment)),
            help_.parameter("iterations", defaults.iterations),
            help_.parameter("surface_precision", defaults.surfacePrecision),
            help_.parameter("objective", host::choiceOf(objectives, defaults.objective)),
            help_.parameter("anchors", host::choiceOf(groupwiseAnchors, GroupwiseAnchors::Soft)),
            help_.parameter("anchor_sd", defaults.anchorDeviation),
            help_.parameter("prior_shapes", defaults.priorShapes).asAdvanced(),
            help_.parameter("frequency", defaults.frequency).asAdvanced(),
            help_.parameter("threads", 0).asAdvanced()};
  }

  host::Outputs run(host::Task& task) const override {
    GroupwiseParameters parameters;
    parameters.alignment = task.values.choice("alignment", poses);
    parameters.iterations = task.values.integer("iterations");
    parameters.surfacePrecision = task.values.real("surface_precision");
    parameters.objective = task.values.choice("objective", objectives);
    parameters.priorShapes = task.values.real("prior_shapes");
    parameters.frequency = task.values.integer("frequency");
    parameters.anchorDeviation = task.values.real("anchor_sd");
    const GroupwiseAnchors use = task.values.choice("anchors", groupwiseAnchors);
    requireValid(parameters);
    const int threads = task.values.integer("threads");
    requireRange("number of threads", threads, Range::atLeast(0));
    ThreadPool pool(threads);
    const Stopwatch stopwatch;
    const std::vector<MappedLayer> layers = mappedLayers(task, &pool);
    if (layers.size() < minGroupwiseShapes)
      throw host::Refusal(messages::onlyMappedLayer, layers.front().layer.label());
    std::vector<MappedSurface> maps;
    maps.reserve(layers.size());
    for (const MappedLayer& layer : layers) maps.push_back(layer.map);
    if (use == GroupwiseAnchors::Soft) parameters.anchors = anchorsOf(task, layers);
    if (!parameters.anchors.empty() && parameters.objective != GroupwiseObjective::PopulationModel)
      task.say(messages::groupwiseLeavesAnchors);
    const Groupwise optimised =
        optimiseGroupwise(maps, pool, parameters, part(task.progress, 0.05, 0.95));
    return write(task, layers, optimised, stopwatch);
  }

 private:
  static host::Outputs write(host::Task& task, const std::vector<MappedLayer>& layers,
                             const Groupwise& optimised, const Stopwatch& stopwatch) {
    const size_t count = layers.size();
    const auto entries = static_cast<Eigen::Index>(count);
    const int mark = markOf(optimised);
    MapFigures figures(count);
    Eigen::VectorXd move(entries), residual(entries), repaired(entries), trust(entries),
        anchors(entries);
    for (size_t i = 0; i < count; ++i) {
      const host::Layer& layer = layers[i].layer;
      const GroupwiseShape& shape = optimised.shapes[i];
      const auto row = static_cast<Eigen::Index>(i);
      move[row] = shape.tangentialMove;
      residual[row] = shape.modelResidual;
      repaired[row] = shape.repairedFaces;
      trust[row] = shape.trust;
      anchors[row] = shape.anchorDistance;
      const MapMeasures measures = measureMap(layers[i].mesh.surface, shape.map.positions());
      if (const auto note = task.changes.setMap(layer, layers[i].mesh, shape.map, mark))
        task.tell(*note);
      task.log(describeMap(layer.label(), layers[i].mesh.surface, measures) + ", moved by " +
               shortNumber(shape.tangentialMove) + " along the surface, " +
               counted(shape.repairedFaces, "face", "faces") + " repaired, " +
               shortNumber(shape.modelResidual) + " from the model");
      if (shape.followedShare < 1)
        task.sayOf(layer, messages::mapNotFollowed, 100 * shape.followedShare);
      if (shape.trust < trusted) task.sayOf(layer, messages::shapeNotCommon, 100 * shape.trust);
      figures.set(i, measures, stopwatch.seconds() / static_cast<double>(count));
    }
    std::string opened;
    for (size_t i = 0; i < count; ++i)
      if (const double squeezed = optimised.shapes[i].squeezed; squeezed > squeezedToSay)
        opened += (opened.empty() ? "\"" : ", \"") + layers[i].layer.label() + "\" (" +
                  shortNumber(100 * squeezed) + " %)";
    if (!opened.empty()) task.say(messages::groupwiseOpened, opened);
    std::string moves;
    for (const double far : optimised.moves)
      moves += (moves.empty() ? "" : ", ") + shortNumber(far);
    if (!moves.empty()) task.say(messages::groupwiseMoves, moves);
    task.say(messages::groupwiseVariance, optimised.varianceBefore, optimised.varianceAfter);
    if (optimised.surfacePrecision > 0)
      task.say(messages::groupwisePrecision, optimised.surfacePrecision);
    std::vector<double> anchored;
    for (const double distance : anchors)
      if (std::isfinite(distance)) anchored.push_back(distance);
    if (!anchored.empty())
      task.say(messages::groupwiseAnchored, anchored.size(),
               std::accumulate(anchored.begin(), anchored.end(), 0.0) /
                   static_cast<double>(anchored.size()));
    std::vector<std::string> held;
    for (const MappedLayer& layer : layers) {
      if (!holdsAnchors(layer.layer)) continue;
      held.push_back(layer.layer.label());
      task.changes.setMark(layer.layer, anchorsHeldMark, anchorsNotHeld);
    }
    if (!held.empty()) task.sayNaming(held, messages::groupwiseMovesAnchors, namesIn(held));
    task.say(messages::groupwiseIsFor);
    task.say(messages::mapsOptimised, count, hiddenLeftOut(task.layers, host::LayerKind::Surface));
    host::Outputs outputs = {
        {"tangential_move", move},
        {"model_residual", residual},
        {"repaired_faces", repaired},
        {"trust", trust},
        {"move_by_iteration", vectorOf(optimised.moves)},
        {"total_variance",
         Eigen::VectorXd(Eigen::Vector2d(optimised.varianceBefore, optimised.varianceAfter))},
        {"surface_precision", optimised.surfacePrecision}};
    if (!anchored.empty()) outputs["anchor_distance_mean"] = anchors;
    figures.addTo(outputs);
    return outputs;
  }

  const host::Help help_{"compute_spherical_parameterisation_groupwise"};
};

}  // namespace

std::unique_ptr<host::Filter> makeGroupwiseFilter() { return std::make_unique<GroupwiseFilter>(); }

}  // namespace sphere_propagation
