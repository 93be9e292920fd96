// SPDX-License-Identifier: GPL-3.0-only
// "Propagate parameterisation to layers": the root's map is handed along a tree to all other
// surfaces.

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <utility>

#include "filter_sphere_propagation/anchor_sources.h"
#include "filter_sphere_propagation/filters.h"
#include "filter_sphere_propagation/largest_layer.h"
#include "filter_sphere_propagation/messages.h"
#include "filter_sphere_propagation/reporting.h"
#include "filter_sphere_propagation/summaries.h"
#include "host/help.h"
#include "vcg_ext/anchors/anchor_places.h"
#include "vcg_ext/anchors/snapped_map.h"
#include "vcg_ext/base/rotation.h"
#include "vcg_ext/base/statistics.h"
#include "vcg_ext/mesh/icosphere.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/propagation/motion/motion_fit.h"
#include "vcg_ext/propagation/propagation.h"
#include "vcg_ext/sequence/mirroring.h"
#include "vcg_ext/sequence/propagation_order.h"
#include "vcg_ext/sequence/repeated_surfaces.h"
#include "vcg_ext/sphere/certificate.h"

namespace sphere_propagation {
namespace {

constexpr host::Named<PropagationMethod> methods[]{
    {"Robust", PropagationMethod::Robust}, {"As published", PropagationMethod::AsPublished}};

using Order = PropagationOrder::Kind;
constexpr host::Named<Order> orders[]{{"Time", Order::Time},
                                      {"Cyclic time", Order::CyclicTime},
                                      {"Similarity tree", Order::SimilarityTree},
                                      {"Star", Order::Star},
                                      {"Given", Order::Given}};

constexpr host::Named<AnchorUse> anchorUses[]{
    {"Off", AnchorUse::Off}, {"Soft", AnchorUse::Soft}, {"Exact", AnchorUse::Exact}};

/// Beyond that an anchor contradicts the others.
constexpr double maxStandardised = 3;

/// "1, 2; -1 2": whole numbers between commas, semicolons and blanks.
std::vector<int> parseNumbers(const std::string& text) {
  std::string spaced = text;
  std::replace_if(
      spaced.begin(), spaced.end(),
      [](unsigned char c) { return c == ',' || c == ';' || std::isspace(c) != 0; }, ' ');
  std::istringstream stream(spaced);
  std::vector<int> numbers;
  for (std::string word; stream >> word;) {
    size_t used = 0;
    int number = 0;
    try {
      number = std::stoi(word, &used);
    } catch (const std::exception&) {
      used = 0;
    }
    if (used != word.size()) throw host::Refusal(messages::noLayerNumber, word);
    numbers.push_back(number);
  }
  return numbers;
}

/// The layers that take part, and which of them is the root.
struct Participants {
  std::vector<host::Layer> layers;
  std::vector<MeshSurface> meshes;
  int root = -1;

  std::vector<ClosedSurface> surfaces() const {
    std::vector<ClosedSurface> list;
    for (const MeshSurface& mesh : meshes) list.push_back(mesh.surface);
    return list;
  }

  int indexOf(int layerId) const {
    for (size_t i = 0; i < layers.size(); ++i)
      if (layers[i].id() == layerId) return static_cast<int>(i);
    return -1;
  }
};

/// The user's list of layer numbers as places among the participants.
std::vector<int> placesOfParents(const Participants& participants, const std::string& text) {
  std::vector<int> parents = parseNumbers(text);
  const std::vector<host::Layer>& layers = participants.layers;
  if (parents.size() != layers.size())
    throw host::Refusal(messages::numberOfParents, parents.size(), layers.size());
  for (size_t i = 0; i < parents.size(); ++i) {
    if (parents[i] < 0) continue;
    const int index = participants.indexOf(parents[i]);
    if (index < 0) throw host::Refusal(messages::parentNotVisible, layers[i].label(), parents[i]);
    parents[i] = index;
  }
  // Where there is no root, or there are several, the core says so.
  const auto root = static_cast<size_t>(
      std::find_if(parents.begin(), parents.end(), [](int parent) { return parent < 0; }) -
      parents.begin());
  const auto chosen = static_cast<size_t>(participants.root);
  if (root < parents.size() && parents[chosen] >= 0)
    throw host::Refusal(messages::twoRoots, layers[root].label(), layers[chosen].label());
  return parents;
}

class PropagationFilter : public host::Filter {
 public:
  host::FilterDescription describe() const override {
    return help_.describe(host::Menu::Remeshing | host::Menu::Layer, host::Arity::VisibleLayers);
  }

  std::vector<host::Parameter> parameters(const host::Layers& layers) const override {
    const PublishedParameters published;
    const LargestLayer largest(layers.visible(host::LayerKind::Surface));
    const int rootId = defaultRootId(layers);
    host::Parameter root = help_.parameter("root_layer", host::Parameter::LayerId{rootId});
    root.help += " " + largest.help();
    return {std::move(root).withNote(largest.note(rootId)),
            help_.parameter("method", host::choiceOf(methods, PropagationParameters{}.method)),
            help_.parameter("order", host::choiceOf(orders, PropagationOrder{}.kind)),
            help_.parameter("parents", std::string()),
            help_.parameter("area_restoration", 0.0),
            help_.parameter("residual_quality", false),
            help_.parameter("uncertainty_quality", false).asAdvanced(),
            help_.parameter("root_error_quality", false).asAdvanced(),
            help_.parameter("mirror_layers", false),
            help_.parameter("anchors", host::choiceOf(anchorUses, AnchorUse::Soft)),
            help_.parameter("anchor_files", std::string()),
            help_.parameter("anchor_sd", AnchorParameters{}.deviation),
            help_.parameter("anchor_snap", false),
            help_.parameter("anchor_pose", AnchorParameters{}.layPoses),
            help_.parameter("anisotropic_scaling", published.anisotropicScaling).asAdvanced(),
            help_.parameter("icp_iterations", published.icpIterations).asAdvanced(),
            help_.parameter("smoothing_sweeps", published.smoothingSweeps).asAdvanced(),
            help_.parameter("threads", PropagationParameters{}.threads).asAdvanced()};
  }

  host::Outputs run(host::Task& task) const override {
    const PropagationParameters asked = readParameters(task.values);
    requireOneQuality(task.values, asked.method);
    Participants participants = readParticipants(task);
    MappedSurface rootMap = readRoot(participants);
    PropagationOrder order{task.values.choice("order", orders)};
    if (order.kind == Order::Given)
      order.parents = placesOfParents(participants, task.values.text("parents"));
    else if (!task.values.text("parents").empty())
      task.say(messages::parentsNotLookedAt);

    PropagationParameters parameters = asked;
    parameters.anchors.layers = readAnchors(task, participants, asked.anchors.use);
    Sequence sequence(participants.surfaces());
    warnOfRepetitions(task, participants, sequence);
    PropagationTree tree;
    const bool mirrors = task.values.flag("mirror_layers");
    std::vector<std::optional<double>> mirrorPlanes;
    SurfaceSides sides;
    {
      ThreadPool pool(asked.threads);
      ReflectedSequence reflected =
          reflectMirrorImages(sequence, order, participants.root, pool, mirrors);
      sequence = std::move(reflected.sequence);
      tree = std::move(reflected.tree);
      mirrorPlanes = std::move(reflected.planes);
      sides = std::move(reflected.sides);
      for (size_t i = 0; i < mirrorPlanes.size(); ++i)
        if (mirrorPlanes[i]) participants.meshes[i].surface = sequence.surface(static_cast<int>(i));
    }
    for (size_t i = 0; i < parameters.anchors.layers.size(); ++i)
      if (mirrorPlanes[i])
        for (auto& [name, place] : parameters.anchors.layers[i])
          place[0] = 2 * *mirrorPlanes[i] - place[0];
    const std::vector<int> landmarks =
        task.values.flag("anchor_snap") ? snap(task, parameters.anchors, participants.root, rootMap)
                                        : std::vector<int>{};
    if (order.kind == Order::CyclicTime) parameters.closing = closingArc(tree.size(), tree.root());
    logNotes(task, participants, tree);
    const Propagation propagated =
        propagate(sequence, rootMap, tree, parameters, part(task.progress, 0.05, 0.9));
    if (parameters.anchors.layPoses) reportPoses(task, participants, propagated.layers);
    const Eigen::VectorXd mirrored = mirror(task, participants, mirrorPlanes);
    if (propagated.learnt)
      task.say(messages::learnt, propagated.learnt->translation, propagated.learnt->strain,
               propagated.learnt->rotation);
    if (propagated.smoothed > 0)
      task.say(messages::allAtOnce, propagated.smoothed, tree.size() - 1);
    const double rootError = rootMeanSquare(propagated.rootError);
    if (propagated.rootError.size() > 0) task.say(messages::rootOff, rootError);
    if (parameters.closing && parameters.method == PropagationMethod::Robust &&
        (propagated.averaged > 0 || propagated.smoothed == 0))
      task.say(messages::bothWays, propagated.averaged, tree.size() - 1);
    warnOfSides(task, participants, sides, mirrors);
    host::Outputs outputs = write(task, participants, propagated.layers, !landmarks.empty());
    outputs["mirrored"] = mirrored;
    if (propagated.rootError.size() > 0) outputs["root_error_sd"] = rootError;
    if (asked.motion.uncertainty) writeUncertainty(task, participants, propagated.layers, outputs);
    if (task.values.flag("root_error_quality"))
      writeRootError(task, participants, propagated.rootError);
    const bool held = !parameters.anchors.layers.empty() && asked.anchors.use == AnchorUse::Exact;
    for (const host::Layer& layer : participants.layers)
      if (held || holdsAnchors(layer))
        task.changes.setMark(layer, anchorsHeldMark, held ? anchorsHeld : anchorsNotHeld);
    reportAnchors(task, participants, parameters.anchors, propagated.layers, outputs);
    if (!landmarks.empty())
      outputs["anchor_landmark"] =
          Eigen::Map<const Eigen::VectorXi>(landmarks.data(),
                                            static_cast<Eigen::Index>(landmarks.size()))
              .cast<double>();
    if (propagated.closing) {
      const MapDifference& difference = *propagated.closing;
      const auto label = [&](int i) { return participants.layers[static_cast<size_t>(i)].label(); };
      task.say(messages::branchesMeet, label(parameters.closing->from),
               label(parameters.closing->to), difference.distance.mean, difference.distance.p95,
               difference.angle.mean);
      outputs["branch_distance"] = difference.distance.mean;
      outputs["branch_angle"] = difference.angle.mean;
    }
    return outputs;
  }

 private:
  static void requireOneQuality(const host::ParameterValues& values, PropagationMethod method) {
    const bool uncertainty = values.flag("uncertainty_quality");
    if (uncertainty && values.flag("residual_quality")) throw host::Refusal(messages::oneQuality);
    if (method == PropagationMethod::AsPublished &&
        (uncertainty || values.flag("root_error_quality")))
      throw host::Refusal(messages::onlyRobustKnows);
  }

  static double rootMeanSquare(const Eigen::VectorXd& values) {
    return values.size() == 0 ? 0 : std::sqrt(values.squaredNorm() / values.size());
  }

  /// As quality and figures; where nobody knows, a layer keeps the quality that it has.
  static void writeUncertainty(host::Task& task, const Participants& participants,
                               const std::vector<PropagatedLayer>& propagated,
                               host::Outputs& outputs) {
    const auto layers = static_cast<Eigen::Index>(propagated.size());
    Eigen::VectorXd mean = Eigen::VectorXd::Constant(layers, std::nan("")), p95 = mean;
    double sum = 0, most = 0;
    int known = 0;
    for (Eigen::Index i = 0; i < layers; ++i) {
      const auto k = static_cast<size_t>(i);
      const Eigen::VectorXd& uncertainty = propagated[k].uncertainty;
      if (uncertainty.size() == 0) {
        task.sayOf(participants.layers[k], messages::noUncertainty);
        continue;
      }
      task.changes.setQuality(participants.layers[k], participants.meshes[k], uncertainty);
      const Residual figures =
          residualOf({uncertainty.data(), uncertainty.data() + uncertainty.size()});
      mean[i] = figures.mean;
      p95[i] = figures.p95;
      if (propagated[k].parent < 0) continue;
      sum += mean[i];
      most = std::max(most, mean[i]);
      ++known;
    }
    if (known > 0) task.say(messages::uncertaintyStored, sum / known, most);
    outputs["uncertainty_mean"] = mean;
    outputs["uncertainty_p95"] = p95;
  }

  static void writeRootError(host::Task& task, const Participants& participants,
                             const Eigen::VectorXd& error) {
    const auto root = static_cast<size_t>(participants.root);
    if (error.size() == 0)
      task.sayOf(participants.layers[root], messages::noRootError);
    else
      task.changes.setQuality(participants.layers[root], participants.meshes[root], error);
  }

  static PropagationParameters readParameters(const host::ParameterValues& values) {
    PropagationParameters parameters;
    parameters.method = values.choice("method", methods);
    parameters.areaRestoration = values.real("area_restoration");
    parameters.published.anisotropicScaling = values.flag("anisotropic_scaling");
    parameters.published.icpIterations = values.integer("icp_iterations");
    parameters.published.smoothingSweeps = values.integer("smoothing_sweeps");
    parameters.threads = values.integer("threads");
    parameters.motion.uncertainty = values.flag("uncertainty_quality");
    parameters.anchors.use = values.choice("anchors", anchorUses);
    parameters.anchors.deviation = values.real("anchor_sd");
    parameters.anchors.layPoses = values.flag("anchor_pose");
    requireValid(parameters);
    return parameters;
  }

  /// Those of each layer; empty where there are none at all, or none on the root.
  static std::vector<AnchorSet> readAnchors(const host::Task& task,
                                            const Participants& participants, AnchorUse use) {
    std::vector<AnchorSet> found(participants.layers.size());
    if (use == AnchorUse::Off) return {};
    const std::string folder = task.values.text("anchor_files");
    bool any = false, inFolder = false;
    AnchorSources sources(task, AnchorFrame::World);
    for (size_t i = 0; i < found.size(); ++i) {
      const host::Layer& layer = participants.layers[i];
      const std::string file = folder.empty() ? "" : sources.fileIn(folder, layer);
      inFolder = inFolder || !file.empty();
      if (!file.empty())
        found[i] = sources.from(file, layer);
      else
        found[i] = layer.anchors();
      if (file.empty() && found[i].empty()) found[i] = sources.beside(layer);
      any = any || !found[i].empty();
    }
    sources.sayWhichAsWritten();
    if (!folder.empty() && !inFolder) throw host::Refusal(messages::noAnchorsInFolder, folder);
    if (!any) return {};
    for (size_t i = 0; i < found.size(); ++i)
      warnOfFarAnchors(task, participants.layers[i], found[i]);
    const auto root = static_cast<size_t>(participants.root);
    warnOfForeign(task, participants.layers, found, root);
    if (found[root].empty()) return {};
    return found;
  }

  /// Names the anchors that the root lacks, and whose they are.
  static void warnOfForeign(const host::Task& task, const std::vector<host::Layer>& layers,
                            const std::vector<AnchorSet>& found, size_t root) {
    std::set<std::string> missing;
    std::vector<std::string> whose;
    for (size_t i = 0; i < found.size(); ++i) {
      const size_t before = whose.size();
      for (const auto& [name, place] : found[i]) {
        if (found[root].count(name) > 0) continue;
        missing.insert(name);
        if (whose.size() == before) whose.push_back(layers[i].label());
      }
    }
    if (missing.empty()) return;
    host::Remark remark = host::remarkOn(layers[root].label(), messages::anchorsNotOnRoot,
                                         namesIn({missing.begin(), missing.end()}), namesIn(whose));
    remark.layers.insert(remark.layers.end(), whose.begin(), whose.end());
    task.tell(remark);
  }

  /// Moves the root's map until its anchors are landmarks. Returns their numbers, none where there
  /// are no anchors.
  static std::vector<int> snap(const host::Task& task, const AnchorParameters& anchors, int root,
                               MappedSurface& map) {
    if (anchors.layers.empty()) return {};
    const AnchorSet& ofRoot = anchors.layers[static_cast<size_t>(root)];
    std::vector<std::string> names, told;
    for (const auto& [name, place] : ofRoot) names.push_back(name);
    const SurfaceLocator surface(map.surface().vertices(), map.faces());
    SnappedMap snapped = snapToLandmarks(map, closestPoints(surface, ofRoot, names), names);
    for (size_t k = 0; k < names.size(); ++k)
      told.push_back(names[k] + " " + std::to_string(snapped.landmarks[k]));
    task.say(messages::anchorsSnapped, icosphere(snapFrequency).vertices.rows(), snapFrequency,
             namesIn(told, told.size()));
    map = std::move(snapped.map);
    return snapped.landmarks;
  }

  /// Which layers anchors have laid onto the root. Refuses where there is none.
  static void reportPoses(const host::Task& task, const Participants& participants,
                          const std::vector<PropagatedLayer>& propagated) {
    std::vector<std::string> laid, others;
    for (size_t i = 0; i < propagated.size(); ++i)
      if (propagated[i].parent >= 0)
        (propagated[i].pose.byAnchors ? laid : others).push_back(participants.layers[i].label());
    if (laid.empty()) throw host::Refusal(messages::noPoseByAnchors, minPosePoints);
    task.say(messages::posesByAnchors, laid.size());
    if (!others.empty()) task.sayNaming(others, messages::posesNotByAnchors, namesIn(others));
  }

  /// What became of the anchors. Entries of layer i and anchor k, in the order of the names, stand
  /// at i times the number of anchors, plus k.
  static void reportAnchors(const host::Task& task, const Participants& participants,
                            const AnchorParameters& anchors,
                            const std::vector<PropagatedLayer>& propagated,
                            host::Outputs& outputs) {
    if (anchors.layers.empty()) return;
    std::vector<std::string> names;
    for (const auto& [name, place] : anchors.layers[static_cast<size_t>(participants.root)])
      names.push_back(name);
    const auto layers = static_cast<Eigen::Index>(propagated.size()),
               count = static_cast<Eigen::Index>(names.size());
    Eigen::VectorXd before(layers * count), after(layers * count), standardised(layers * count),
        widening(layers), places(3 * layers * count);
    double sumBefore = 0, sumAfter = 0;
    int compared = 0, measured = 0;
    for (Eigen::Index i = 0; i < layers; ++i) {
      const PropagatedLayer& layer = propagated[static_cast<size_t>(i)];
      const host::Layer& it = participants.layers[static_cast<size_t>(i)];
      widening[i] = layer.anchors.widening;
      std::set<size_t> named;
      std::vector<std::string> contradicting;
      double least = HUGE_VAL, most = 0;
      for (const std::vector<size_t>& turn : layer.anchors.exchanged) {
        std::vector<std::string> called;
        for (const size_t k : turn) called.push_back(names[k]);
        if (turn.size() == 2)
          task.sayOf(it, messages::anchorsExchanged, called[0], called[1]);
        else
          task.sayOf(it, messages::anchorsExchangedInTurn, namesIn(called, called.size()));
        named.insert(turn.begin(), turn.end());
      }
      for (Eigen::Index k = 0; k < count; ++k) {
        const auto place = static_cast<size_t>(k);
        const Eigen::Index entry = i * count + k;
        const AnchorSet& ofLayer = anchors.layers[static_cast<size_t>(i)];
        const auto there = ofLayer.find(names[place]);
        places.segment<3>(3 * entry) =
            there == ofLayer.end() ? Vector3::Constant(std::nan("")) : there->second;
        before[entry] = layer.anchors.before[place];
        after[entry] = layer.anchors.after[place];
        standardised[entry] = layer.anchors.standardised[place];
        if (layer.parent < 0 || !std::isfinite(after[entry])) continue;
        sumAfter += after[entry];
        ++measured;
        if (std::isfinite(before[entry])) sumBefore += before[entry], ++compared;
        // With one anchor there are no others.
        if (standardised[entry] > maxStandardised && count > 1 && named.count(place) == 0) {
          contradicting.push_back(names[place]);
          least = std::min(least, standardised[entry]);
          most = std::max(most, standardised[entry]);
        }
      }
      if (contradicting.size() == 1)
        task.sayOf(it, messages::anchorContradicts, contradicting[0], most);
      else if (!contradicting.empty())
        task.sayOf(it, messages::anchorsContradict, contradicting.size(), namesIn(contradicting),
                   least, most);
    }
    if (measured > 0)
      task.say(messages::anchorsHeeded, anchors.use == AnchorUse::Exact ? "exact" : "soft",
               namesIn(names), compared > 0 ? shortNumber(sumBefore / compared) : "?",
               sumAfter / measured);
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : "\n") + name;
    Eigen::VectorXd bytes(static_cast<Eigen::Index>(text.size()));
    for (size_t i = 0; i < text.size(); ++i)
      bytes[static_cast<Eigen::Index>(i)] = static_cast<unsigned char>(text[i]);
    outputs["anchor_names"] = bytes;
    outputs["anchor_places"] = places;
    outputs["anchor_distance"] = after;
    outputs["anchor_distance_before"] = before;
    outputs["anchor_z"] = standardised;
    outputs["prior_widening"] = widening;
  }

  static MappedSurface readRoot(const Participants& participants) {
    const auto root = static_cast<size_t>(participants.root);
    const host::Layer& layer = participants.layers[root];
    std::optional<MappedSurface> map = layer.map(participants.meshes[root]);
    if (!map) refuseRoot(layer, participants.meshes[root]);
    return *map;
  }

  /// Says whether another root would be larger, and which one would leave the farthest layer at
  /// most three quarters of the arcs away.
  static void logNotes(host::Task& task, const Participants& participants,
                       const PropagationTree& tree) {
    const host::Layer& root = participants.layers[static_cast<size_t>(participants.root)];
    if (const std::string note = LargestLayer(participants.layers).note(root.id()); !note.empty())
      task.say(messages::largerRoot, root.label(), note);
    const int centre = tree.centre(), arcs = tree.farthestFrom(tree.root()),
              least = tree.farthestFrom(centre);
    if (4 * least > 3 * arcs || arcs - least < 2) return;
    task.say(messages::centralRoot, arcs, participants.layers[static_cast<size_t>(centre)].label(),
             least);
  }

  [[noreturn]] static void refuseRoot(const host::Layer& layer, const MeshSurface& mesh) {
    if (!layer.hasAttribute()) throw host::Refusal(messages::rootWithoutMap, layer.label());
    throw host::Refusal(messages::rootMapNotValid, layer.label(),
                        certify(mesh.surface.faces(), *layer.storedPositions(mesh)).reason());
  }

  static double residualInEdges(const MeshSurface& mesh, const PropagatedLayer& propagated) {
    return propagated.transferred.residual.mean /
           meanEdgeLength(mesh.surface.vertices(), mesh.surface.faces());
  }

  /// What the user should know about how a layer got its map; usually nothing.
  static void warn(const host::Task& task, const host::Layer& layer, const MeshSurface& mesh,
                   const PropagatedLayer& propagated) {
    if (propagated.route == Route::Alignment) task.sayOf(layer, messages::fitLostLayer);
    if (propagated.route == Route::Published) task.sayOf(layer, messages::alignmentLostLayer);
    if (propagated.pose.moved)
      task.sayOf(layer, messages::anotherPose, propagated.pose.shift, propagated.pose.angle);
    const double edges = residualInEdges(mesh, propagated);
    if (edges > maxEdgesApart)
      task.sayOf(layer, messages::farOff, edges);
    else if (propagated.residualStandsOut)
      task.sayOf(layer, messages::fartherThanOthers, edges);
  }

  static void warnOfRepetitions(const host::Task& task, const Participants& participants,
                                const Sequence& sequence) {
    std::vector<std::string> names;
    for (const host::Layer& layer : participants.layers) names.push_back(layer.label());
    sphere_propagation::warnOfRepetitions(task, names, repeatedSurfaces(sequence),
                                          {messages::repeatedSurface, messages::repeatedSurfaces});
  }

  /// What was found of left and right, besides what was reflected.
  static void warnOfSides(const host::Task& task, const Participants& participants,
                          const SurfaceSides& sides, bool mirrors) {
    const auto mirrored =
        static_cast<size_t>(std::count_if(sides.surfaces.begin(), sides.surfaces.end(),
                                          [](const SurfaceSide& side) { return side.mirrored; }));
    const bool rootIsOdd = 2 * mirrored > sides.surfaces.size();
    std::vector<std::string> inDoubt, unknown;
    for (size_t i = 0; i < sides.surfaces.size(); ++i) {
      const host::Layer& layer = participants.layers[i];
      const SurfaceSide& side = sides.surfaces[i];
      if (side.mirrored && !mirrors && !rootIsOdd) task.sayOf(layer, messages::mirrorImage);
      if (side.imageOf >= 0)
        task.sayOf(layer, messages::mirrorCopy,
                   participants.layers[static_cast<size_t>(side.imageOf)].label());
      const bool isOddRoot = rootIsOdd && static_cast<int>(i) == participants.root;
      if (side.isDoubtful() && !isOddRoot)
        task.sayOf(layer, messages::mirrorDoubt, side.against, side.compared);
      if (!side.known) (side.inDoubt ? inDoubt : unknown).push_back(layer.label());
    }
    // Where none is mirrored those that are nearly their own mirror image need no look.
    if (mirrored > 0 && !unknown.empty())
      task.sayNaming(unknown, messages::sidesNotKnown, namesIn(unknown, unknown.size()));
    else if (sides.noSide)
      task.say(messages::noCommonSide, std::exp(*sides.noSide));
    else if (!unknown.empty())
      task.say(messages::noSideKnown, namesIn(unknown, unknown.size()));
    if (rootIsOdd)
      task.sayOf(participants.layers[static_cast<size_t>(participants.root)],
                 messages::mirroredRoot);
    if (!inDoubt.empty())
      task.sayNaming(inDoubt, messages::sidesDiffer, namesIn(inDoubt, inDoubt.size()));
  }

  /// Of layers that differ in one way: one by one where they are few.
  static void warnOfSizes(const host::Task& task, const Participants& participants,
                          const std::vector<PropagatedLayer>& propagated) {
    std::map<std::pair<bool, double>, std::vector<size_t>> kinds;  // larger, units
    for (size_t i = 0; i < propagated.size(); ++i)
      if (const SurfaceSize& size = propagated[i].size; size.standsOut)
        kinds[{size.relative > 1, size.units}].push_back(i);
    for (const auto& [kind, layers] : kinds) {
      const bool half = 2 * layers.size() == propagated.size() && layers.size() > 1;
      if (layers.size() <= maxNamedSingly && !half) {
        for (const size_t i : layers)
          warnOfSize(task, participants.layers[i], propagated[i].size, propagated.size() == 2);
        continue;
      }
      std::vector<std::string> names, others;
      std::vector<double> ratios;
      for (size_t i = 0; i < propagated.size(); ++i) {
        const bool isOne = std::find(layers.begin(), layers.end(), i) != layers.end();
        (isOne ? names : others).push_back(participants.layers[i].label());
        if (isOne) ratios.push_back(propagated[i].size.relative);
      }
      warnOfManySizes(task, names, others, medianOf(ratios), kind.second,
                      {messages::severalSizes, messages::halfOfLayersLarger});
    }
  }

  static void warnOfSize(const host::Task& task, const host::Layer& layer, const SurfaceSize& size,
                         bool ofTwo) {
    const bool larger = size.relative > 1;
    const double factor = larger ? size.relative : 1 / size.relative;
    const char* kind = larger ? "larger" : "smaller";
    if (size.units == 0) {
      task.sayOf(layer, ofTwo ? messages::anotherSizeThanRoot : messages::anotherSize, factor,
                 kind);
      return;
    }
    const UnitNames names = unitNames(size.relative, size.units);
    task.sayOf(layer, ofTwo ? messages::anotherUnitThanRoot : messages::anotherUnit, factor, kind,
               names.its, names.others);
  }

  /// The current layer if it has a map, else the root that the others' maps came from, else the
  /// first surface layer that has a map, else the current layer.
  static int defaultRootId(const host::Layers& layers) {
    const int current = layers.currentId();
    if (const auto layer = layers.find(current);
        layer && layer->kind() == host::LayerKind::Surface && layer->hasMap())
      return current;
    std::optional<int> first;
    for (const host::Layer& layer : layers.visible(host::LayerKind::Surface)) {
      if (!layer.hasMap()) continue;
      if (!first) first = layer.id();
      if (const auto root = layer.mark(host::rootMark); root && root == layer.mapFingerprint())
        return layer.id();
    }
    if (first) return *first;
    return current;
  }

  static Participants readParticipants(host::Task& task) {
    Participants participants;
    participants.layers = task.layers.visibleSurfaces();
    const int rootId = task.values.layerId("root_layer");
    participants.root = participants.indexOf(rootId);
    if (participants.root < 0) {
      const auto layer = task.layers.find(rootId);
      if (layer) throw host::Refusal(messages::rootNotVisible, layer->label());
      throw host::Refusal(messages::noSuchRoot, rootId);
    }
    if (participants.layers.size() == 1)
      throw host::Refusal(messages::onlySurface, participants.layers[0].label());
    const double count = static_cast<double>(participants.layers.size());
    for (size_t i = 0; i < participants.layers.size(); ++i) {
      participants.meshes.push_back(participants.layers[i].surface());
      report(task.progress, 0.05 * static_cast<double>(i + 1) / count);
    }
    return participants;
  }

  /// Reflects the layers for which there is a plane. Returns 1 for each of them, else 0.
  static Eigen::VectorXd mirror(host::Task& task, const Participants& participants,
                                const std::vector<std::optional<double>>& planes) {
    Eigen::VectorXd mirrored = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(planes.size()));
    for (size_t i = 0; i < planes.size(); ++i) {
      if (!planes[i]) continue;
      mirrored[static_cast<Eigen::Index>(i)] = 1;
      task.changes.mirror(participants.layers[i], *planes[i]);
      task.sayOf(participants.layers[i], messages::reflected, *planes[i]);
    }
    return mirrored;
  }

  /// isRootNew: whether the root's map is another one than it has.
  static host::Outputs write(host::Task& task, const Participants& participants,
                             const std::vector<PropagatedLayer>& propagated, bool isRootNew) {
    const size_t count = participants.layers.size();
    // A layer whose own map was handed to it passes on the root that this came from: they all
    // belong together.
    const host::Layer& rootLayer = participants.layers[static_cast<size_t>(participants.root)];
    const std::optional<int> known = rootLayer.mark(host::rootMark);
    std::optional<int> root = known ? known : rootLayer.mapFingerprint();
    if (isRootNew) {
      const auto place = static_cast<size_t>(participants.root);
      if (const auto note =
              task.changes.setMap(rootLayer, participants.meshes[place], propagated[place].map()))
        task.tell(*note);
      root = task.changes.rootOfMapOn(rootLayer);
    } else if (root && !known) {
      task.changes.setMark(rootLayer, host::rootMark, *root);
    }
    MapFigures figures(count);
    const auto entries = static_cast<Eigen::Index>(count);
    Eigen::VectorXd parent(entries), residualMean(entries), residualP95(entries),
        repairedFaces(entries), route(entries), distant(entries);
    for (size_t i = 0; i < count; ++i) {
      const PropagatedLayer& layer = propagated[i];
      const auto row = static_cast<Eigen::Index>(i);
      const MapMeasures measures =
          measureMap(participants.meshes[i].surface, layer.map().positions());
      figures.set(i, measures, layer.seconds);
      const bool isRoot = layer.parent < 0;
      const std::string from =
          isRoot ? "" : participants.layers[static_cast<size_t>(layer.parent)].label();
      parent[row] = isRoot ? -1 : participants.layers[static_cast<size_t>(layer.parent)].id();
      residualMean[row] = layer.transferred.residual.mean;
      residualP95[row] = layer.transferred.residual.p95;
      repairedFaces[row] = layer.transferred.repairedFaces;
      route[row] = static_cast<double>(layer.route);
      distant[row] =
          layer.residualStandsOut || residualInEdges(participants.meshes[i], layer) > maxEdgesApart
              ? 1
              : 0;
      std::string line =
          describeMap(participants.layers[i].label(), participants.meshes[i].surface, measures);
      if (isRoot) {
        line += " (root)";
      } else {
        const auto note =
            task.changes.setMap(participants.layers[i], participants.meshes[i], layer.map(), root);
        if (note) task.tell(*note);
        line += ", from " + from + " with residual " +
                shortNumber(layer.transferred.residual.mean) + " (95 % below " +
                shortNumber(layer.transferred.residual.p95) + "), " +
                counted(layer.transferred.repairedFaces, "face", "faces") + " repaired, " +
                shortNumber(layer.seconds) + " s";
      }
      if (task.values.flag("residual_quality"))
        task.changes.setQuality(participants.layers[i], participants.meshes[i],
                                Eigen::Map<const Eigen::VectorXd>(
                                    layer.transferred.distances.data(),
                                    static_cast<Eigen::Index>(layer.transferred.distances.size())));
      task.log(line);
      warn(task, participants.layers[i], participants.meshes[i], layer);
      report(task.progress, 0.9 + 0.1 * static_cast<double>(i + 1) / static_cast<double>(count));
    }
    warnOfSizes(task, participants, propagated);
    if (task.values.flag("residual_quality"))
      task.say(messages::residualsStored, residualMean.maxCoeff(), residualP95.maxCoeff());
    const Order order = task.values.choice("order", orders);
    if (count > 2 && (order == Order::SimilarityTree || order == Order::Star))
      task.say(messages::groupwiseNext);
    task.say(messages::layersMapped, count, count,
             hiddenLeftOut(task.layers, host::LayerKind::Surface));
    host::Outputs outputs = {{"parent", parent},
                             {"residual_mean", residualMean},
                             {"residual_p95", residualP95},
                             {"repaired_faces", repairedFaces},
                             {"route", route},
                             {"distant", distant}};
    figures.addTo(outputs);
    return outputs;
  }

  const host::Help help_{"transfer_spherical_parameterisation_to_layers"};
};

}  // namespace

std::unique_ptr<host::Filter> makePropagationFilter() {
  return std::make_unique<PropagationFilter>();
}

}  // namespace sphere_propagation
