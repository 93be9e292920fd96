// SPDX-License-Identifier: GPL-3.0-only
// "Build statistical shape model": from landmark layers to their mean, modes, scores and figures.

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

#include "filter_sphere_propagation/anchor_sources.h"
#include "filter_sphere_propagation/filters.h"
#include "filter_sphere_propagation/landmark_sources.h"
#include "filter_sphere_propagation/map_roots.h"
#include "filter_sphere_propagation/messages.h"
#include "filter_sphere_propagation/model_layers.h"
#include "filter_sphere_propagation/reporting.h"
#include "filter_sphere_propagation/summaries.h"
#include "host/help.h"
#include "host/window.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/base/statistics.h"
#include "vcg_ext/display/colors.h"
#include "vcg_ext/display/side_by_side.h"
#include "vcg_ext/mesh/surface_locator.h"
#include "vcg_ext/mesh/usable_extent.h"
#include "vcg_ext/model/export/model_export.h"
#include "vcg_ext/model/model_measures.h"
#include "vcg_ext/model/named_landmarks.h"
#include "vcg_ext/model/outliers.h"
#include "vcg_ext/model/procrustes.h"
#include "vcg_ext/model/shape_model.h"
#include "vcg_ext/model/surface_measures.h"

namespace sphere_propagation {
namespace {

/// What is taken out of the shapes, and by what it is told.
struct AlignmentChoice {
  Alignment alignment;
  bool byAnchors;
};
enum class AlignmentRule { Similarity, Rigid, None, Anchors, ScaledAnchors };
constexpr host::Named<AlignmentRule> alignments[]{{"Similarity", AlignmentRule::Similarity},
                                                  {"Rigid", AlignmentRule::Rigid},
                                                  {"None", AlignmentRule::None},
                                                  {"Anchors", AlignmentRule::Anchors},
                                                  {"Scaled anchors", AlignmentRule::ScaledAnchors}};
AlignmentChoice meaningOf(AlignmentRule rule) {
  switch (rule) {
    case AlignmentRule::Similarity:
      return {Alignment::Similarity, false};
    case AlignmentRule::Rigid:
      return {Alignment::Rigid, false};
    case AlignmentRule::None:
      return {Alignment::None, false};
    case AlignmentRule::Anchors:
      return {Alignment::Rigid, true};
    case AlignmentRule::ScaledAnchors:
      break;
  }
  return {Alignment::Similarity, true};
}

enum class LidRule { Most, Any, Never };
constexpr host::Named<LidRule> lidRules[]{
    {"Most shapes", LidRule::Most}, {"Any shape", LidRule::Any}, {"Never", LidRule::Never}};

/// Landmark layers, and what each was made of, where that is there.
struct Origins {
  std::vector<host::Layer> layers;
  std::vector<std::optional<host::Layer>> made;
  std::vector<char> again;  // whether it was made of what the one before it was, too
};

/// In the order of the surfaces that they were made of, which is time order, wherever they are in
/// the list themselves; those whose surface is not there come last.
Origins inOrderOfSurfaces(const host::Task& task, const std::vector<host::Layer>& layers) {
  const std::vector<host::Layer> surfaces = task.layers.all(host::LayerKind::Surface);
  const std::vector<std::optional<size_t>> sources = landmarkSources(layers, surfaces);
  logStaleLandmarks(task, layers, surfaces, sources);
  std::vector<size_t> order(layers.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return sources[a].value_or(surfaces.size()) < sources[b].value_or(surfaces.size());
  });
  Origins sorted;
  for (size_t k = 0; k < order.size(); ++k) {
    sorted.layers.push_back(layers[order[k]]);
    sorted.made.push_back(sources[order[k]] ? std::optional(surfaces[*sources[order[k]]])
                                            : std::nullopt);
    sorted.again.push_back(k > 0 && sources[order[k]] &&
                           sources[order[k]] == sources[order[k - 1]]);
    if (sorted.again.back())
      task.sayNaming({layers[order[k - 1]].label(), layers[order[k]].label()},
                     messages::shapeCountedTwice, layers[order[k - 1]].label(),
                     layers[order[k]].label(), surfaces[*sources[order[k]]].label());
  }
  if (!std::is_sorted(order.begin(), order.end())) task.say(messages::orderOfSurfaces);
  return sorted;
}

/// Points that figures can be computed of.
void requireUsable(const TrainingSet::Shape& shape) {
  const Eigen::RowVector3d extent =
      shape.landmarks.colwise().maxCoeff() - shape.landmarks.colwise().minCoeff();
  if (!(extent.maxCoeff() > 1e-12 * shape.landmarks.cwiseAbs().maxCoeff()))
    throw ParameterError(
        Finding(Fault::LandmarksInOnePlace, shape.name).of(shape.landmarks.rows()));
  requireUsableExtent(shape.landmarks, shape.name);
}

/// The set without the landmarks that lie on lids. shapesWithLid: of each landmark the number of
/// shapes on which it does.
TrainingSet withoutLids(const host::Task& task, TrainingSet set,
                        const std::vector<int>& shapesWithLid, LidRule rule) {
  const auto shapes = static_cast<int>(set.shapeCount());
  const int fewest = rule == LidRule::Any ? 1 : (shapes + 1) / 2;
  std::vector<char> leave;
  long left = 0, others = 0;
  for (const int with : shapesWithLid) {
    leave.push_back(rule != LidRule::Never && with >= fewest);
    (leave.back() ? left : others) += with > 0;
  }
  if (left == set.landmarkCount()) throw host::Refusal(messages::nothingButLids, fewest);
  if (left > 0)
    task.say(messages::lidsLeftOut, left, set.landmarkCount(), fewest, others);
  else if (others > 0 && rule != LidRule::Never)
    task.say(messages::lidsKept, others);
  return left > 0 ? set.without(leave) : set;
}

/// The faces that have no vertex on a lid.
Triangles facesWithout(const Triangles& faces, const std::vector<int>& lids) {
  Triangles kept(faces.rows(), 3);
  Eigen::Index count = 0;
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    bool isLid = false;
    for (int c = 0; c < 3; ++c) isLid = isLid || lids[static_cast<size_t>(faces(f, c))] > 0;
    if (!isLid) kept.row(count++) = faces.row(f);
  }
  kept.conservativeResize(count, 3);
  return kept;
}

struct Shapes {
  TrainingSet set;
  std::vector<AnchorSet> anchors;       // of each shape
  std::vector<SampledSurface> sampled;  // where they are asked for
  std::vector<char> again;              // see Origins
};

/// Of a landmark layer: its own, those of the surface that it was made of, or, where they are asked
/// for, in files beside either.
AnchorSet anchorsOf(AnchorSources& sources, const host::Layer& layer, const host::Layer* surface,
                    bool inFiles) {
  AnchorSet anchors = layer.anchors();
  if (anchors.empty() && surface) anchors = surface->anchors();
  if (!inFiles) return anchors;
  if (anchors.empty() && surface) anchors = sources.beside(*surface);
  if (anchors.empty()) anchors = sources.beside(layer);
  return anchors;
}

/// made: what each layer was made of, where that is there.
std::vector<AnchorSet> anchorsOf(const host::Task& task, const std::vector<host::Layer>& layers,
                                 const std::vector<std::optional<host::Layer>>& made,
                                 bool inFiles) {
  std::vector<AnchorSet> anchors;
  AnchorSources files(task, AnchorFrame::World);
  for (size_t i = 0; i < layers.size(); ++i)
    anchors.push_back(anchorsOf(files, layers[i], made[i] ? &*made[i] : nullptr, inFiles));
  files.sayWhichAsWritten();
  return anchors;
}

/// By name, as alignByAnchors takes them.
std::vector<Points> inRows(const std::vector<AnchorSet>& anchors) {
  std::map<std::string, Eigen::Index> rows;
  for (const AnchorSet& ofShape : anchors)
    for (const auto& [name, place] : ofShape)
      rows.emplace(name, static_cast<Eigen::Index>(rows.size()));
  std::vector<Points> points(
      anchors.size(), Points::Constant(static_cast<Eigen::Index>(rows.size()), 3, std::nan("")));
  for (size_t i = 0; i < anchors.size(); ++i)
    for (const auto& [name, place] : anchors[i]) points[i].row(rows[name]) = place.transpose();
  return points;
}

/// Refuses landmarks whose surface was moved or replaced since they were made.
void requireOnSurface(const host::Layer& layer, const host::Layer& source,
                      const ClosedSurface& surface) {
  constexpr double off = 1e-3;  // of the surface's extent: files of text round
  const SurfaceLocator locator(surface.vertices(), surface.faces());
  const Points landmarks = layer.content().vertices;
  double farthest = 0;
  for (Eigen::Index j = 0; j < landmarks.rows(); ++j)
    farthest = std::max(farthest, locator.closest(landmarks.row(j).transpose()).distance);
  const Eigen::RowVector3d extent =
      surface.vertices().colwise().maxCoeff() - surface.vertices().colwise().minCoeff();
  if (farthest > off * extent.norm())
    throw host::Refusal(messages::landmarksOffSurface, layer.label(), farthest, source.label());
}

/// What the landmark layers were made of. withoutLids: whether the model leaves those out.
std::vector<SampledSurface> surfacesOf(const std::vector<host::Layer>& layers,
                                       const std::vector<std::optional<host::Layer>>& made,
                                       bool withoutLids) {
  std::vector<SampledSurface> sampled;
  for (size_t i = 0; i < layers.size(); ++i) {
    if (!made[i]) throw host::Refusal(messages::noSurfaceToMeasure, layers[i].label());
    const MeshSurface mesh = made[i]->surface();
    requireOnSurface(layers[i], *made[i], mesh.surface);
    const std::vector<int> lids = withoutLids ? made[i]->lids(mesh.meshVertex) : std::vector<int>();
    sampled.push_back({mesh.surface.vertices(), mesh.surface.faces()});
    if (!lids.empty()) sampled.back().faces = facesWithout(sampled.back().faces, lids);
  }
  return sampled;
}

/// The visible landmark layers as shapes that correspond. They are taken as points: their faces are
/// the icosphere's, and which way these look tells a mirror image, which is named later, but no
/// fault of a layer.
Shapes shapesOf(const host::Task& task, LidRule rule, bool anchorsInFiles, bool withSurfaces) {
  const std::vector<host::Layer> visible = task.layers.visible(host::LayerKind::Landmarks);
  if (visible.empty()) throw host::Refusal(messages::noLandmarkLayer);
  requireOneRoot(visible);
  const auto [layers, made, again] = inOrderOfSurfaces(task, visible);
  std::vector<TrainingSet::Shape> shapes;
  std::vector<std::string> mirrored, others;
  std::optional<Triangles> faces, mirroredFaces;
  std::vector<int> shapesWithLid;
  for (const host::Layer& layer : layers) {
    MeshContent content = layer.content();
    shapes.push_back({layer.label(), std::move(content.vertices)});
    // A matrix that flattens mirrors as rounding will have it.
    if (shapes.back().landmarks.allFinite()) requireUsable(shapes.back());
    const bool isMirrored = layer.mirrors();
    (isMirrored ? mirrored : others).push_back(layer.label());
    if (std::optional<Triangles>& list = isMirrored ? mirroredFaces : faces; !list)
      list = std::move(content.faces);
    const std::vector<int> lids = layer.lids(content.meshVertex);
    shapesWithLid.resize(std::max(shapesWithLid.size(), lids.size()), 0);
    for (size_t j = 0; j < lids.size(); ++j) shapesWithLid[j] += lids[j] > 0;
  }
  const bool mostMirrored = mirrored.size() > others.size();
  TrainingSet set(std::move(shapes), std::move(*(mostMirrored ? mirroredFaces : faces)));
  if (!mirrored.empty() && !others.empty())
    task.sayNaming(mirrored, messages::matrixMirrors, namesIn(mirrored));
  shapesWithLid.resize(static_cast<size_t>(set.landmarkCount()), 0);
  TrainingSet kept = withoutLids(task, std::move(set), shapesWithLid, rule);
  const bool lidsGo = kept.leftOut().size() > 0;
  return {std::move(kept), anchorsOf(task, layers, made, anchorsInFiles),
          withSurfaces ? surfacesOf(layers, made, lidsGo) : std::vector<SampledSurface>(), again};
}

/// "3, 17, 40": numbers of landmarks as they were before any was left out.
std::string numbersOf(const std::vector<int>& landmarks, const TrainingSet& set) {
  std::vector<int> before;
  for (size_t j = 0; j < set.leftOut().size(); ++j)
    if (!set.leftOut()[j]) before.push_back(static_cast<int>(j));
  std::vector<std::string> numbers;
  for (const int j : landmarks)
    numbers.push_back(std::to_string(before.empty() ? j : before[static_cast<size_t>(j)]));
  constexpr size_t most = 10;
  std::string text;
  for (size_t k = 0; k < std::min(most, numbers.size()); ++k)
    text += (k > 0 ? ", " : "") + numbers[k];
  if (numbers.size() > most) text += " and " + std::to_string(numbers.size() - most) + " more";
  return text;
}

void nameOutlier(const host::Task& task, const TrainingSet& set, const Outlier& outlier) {
  const std::string& name = set.shapes()[outlier.shape].name;
  if (outlier.kind == Outlier::Kind::Shape)
    task.sayOf(name, messages::shapeStandsOut, outlier.distance, outlier.ratio);
  else if (outlier.kind == Outlier::Kind::Landmarks && outlier.landmarks.size() == 1)
    task.sayOf(name, messages::landmarkStrays, numbersOf(outlier.landmarks, set), outlier.distance);
  else if (outlier.kind == Outlier::Kind::Landmarks)
    task.sayOf(name, messages::landmarksStray, outlier.landmarks.size(),
               numbersOf(outlier.landmarks, set), outlier.distance);
  else if (outlier.ratio > 1)
    task.sayOf(name, messages::sizeStandsOut, outlier.ratio, "larger");
  else
    task.sayOf(name, messages::sizeStandsOut, 1 / outlier.ratio, "smaller");
}

/// All of one kind, as one warning.
void nameAll(const host::Task& task, const std::vector<Outlier>& outliers, const TrainingSet& set) {
  std::vector<std::string> names;
  std::vector<double> ratios, distances;
  for (const Outlier& outlier : outliers) {
    names.push_back(set.shapes()[outlier.shape].name);
    ratios.push_back(outlier.ratio);
    distances.push_back(outlier.distance);
  }
  const auto least = [](const std::vector<double>& values) {
    return *std::min_element(values.begin(), values.end());
  };
  if (outliers.front().kind == Outlier::Kind::Shape) {
    task.sayNaming(names, messages::shapesStandOut, names.size(), set.shapeCount(), namesIn(names),
                   least(distances), least(ratios));
    return;
  }
  if (outliers.front().kind == Outlier::Kind::Landmarks) {
    const Outlier& worst = *std::max_element(
        outliers.begin(), outliers.end(),
        [](const Outlier& a, const Outlier& b) { return a.distance < b.distance; });
    task.sayNaming(names, messages::shapesWithStrays, names.size(), set.shapeCount(),
                   namesIn(names), worst.distance, numbersOf(worst.landmarks, set),
                   set.shapes()[worst.shape].name);
    return;
  }
  std::vector<std::string> others;
  for (const TrainingSet::Shape& shape : set.shapes())
    if (std::find(names.begin(), names.end(), shape.name) == names.end())
      others.push_back(shape.name);
  warnOfManySizes(task, names, others, medianOf(ratios), outliers.front().units,
                  {messages::sizesStandOut, messages::halfOfShapesLarger});
}

void nameOutliers(const host::Task& task, const TrainingSet& given, const TrainingSet& aligned) {
  std::map<std::tuple<Outlier::Kind, bool, double>, std::vector<Outlier>> kinds;
  for (const Outlier& outlier : findOutliers(given, aligned)) {
    const bool isSize = outlier.kind == Outlier::Kind::Size;
    kinds[{outlier.kind, isSize && outlier.ratio > 1, outlier.units}].push_back(outlier);
  }
  for (const auto& [kind, outliers] : kinds)
    if (outliers.size() > maxNamedSingly ||
        (std::get<0>(kind) == Outlier::Kind::Size &&
         2 * outliers.size() == static_cast<size_t>(given.shapeCount())))
      nameAll(task, outliers, given);
    else
      for (const Outlier& outlier : outliers) nameOutlier(task, given, outlier);
}

std::vector<std::string> namesOf(const TrainingSet& set) {
  std::vector<std::string> names;
  for (const TrainingSet::Shape& shape : set.shapes()) names.push_back(shape.name);
  return names;
}

/// Without those that are named already, since their surface is the same.
std::vector<int> repeatedBesides(const std::vector<char>& named, const TrainingSet& aligned) {
  std::vector<int> firsts = repeatedShapes(aligned);
  for (size_t k = 0; k < firsts.size(); ++k)
    if (named[k]) firsts[k] = -1;
  return firsts;
}

std::string percent(double share) { return shortNumber(100 * share) + " %"; }

/// The mean, and for the first modes the shapes at both ends, coloured by their displacement along
/// the mean's normal.
void addLayers(host::Task& task, const ShapeModel& model, Eigen::Index modeLayers,
               double deviations) {
  struct Deviated {
    std::string label;
    Points shape;
    Eigen::VectorXd displacement;
  };
  std::vector<Deviated> shapes = {
      {meanLabel, model.mean, Eigen::VectorXd::Zero(model.mean.rows())}};
  for (Eigen::Index mode = 0; mode < modeLayers; ++mode)
    for (const bool plus : {false, true}) {
      Points shape = model.shape(mode, plus ? deviations : -deviations);
      Eigen::VectorXd displacement = normalDisplacements(model.mean, shape, model.faces);
      shapes.push_back(
          {modeLabel(mode + 1, plus, deviations), std::move(shape), std::move(displacement)});
    }
  double range = 0;
  for (const Deviated& d : shapes) range = std::max(range, d.displacement.cwiseAbs().maxCoeff());
  std::vector<Eigen::AlignedBox3d> boxes;
  std::vector<std::string> labels;
  for (const Deviated& d : shapes) {
    boxes.push_back(boxOf(d.shape));
    labels.push_back(d.label);
  }
  const std::vector<Vector3> moves =
      sideBySide(boxes, shownBeside(task.layers, host::LayerKind::Model), cellsOfModel(labels));
  const bool beside = task.values.flag("beside_shapes");
  for (size_t i = 0; i < shapes.size(); ++i) {
    Deviated& d = shapes[i];
    host::NewLayer layer;
    if (beside) layer.aside = moves[i];
    layer.label = d.label;
    layer.kind = host::LayerKind::Model;
    layer.vertices = std::move(d.shape);
    layer.faces = model.faces;
    layer.colors = displacementColors(d.displacement, range);
    layer.quality = std::move(d.displacement);
    task.changes.addLayer(layer);
  }
  task.changes.removeOtherLayers(host::LayerKind::Model);
  if (host::hasWindow()) task.changes.makeFirstNewLayerCurrent();
  if (beside) task.say(messages::shownAside);
  if (modeLayers > 0) task.say(messages::coloursOfModes, range);
}

class ShapeModelFilter : public host::Filter {
 public:
  host::FilterDescription describe() const override {
    return help_.describe(host::Menu::Layer | host::Menu::Measure, host::Arity::VisibleLayers);
  }

  std::vector<host::Parameter> parameters(const host::Layers&) const override {
    const ModelMeasureParameters measures;
    return {help_.parameter("alignment", host::choiceOf(alignments, AlignmentRule::Similarity)),
            help_.parameter("leave_out_lids", host::choiceOf(lidRules, LidRule::Most)),
            help_.parameter("modes", 0),
            help_.parameter("standard_deviations", 3.0),
            help_.parameter("mode_layers", 3),
            help_.parameter(
                "export_file",
                host::Parameter::NewFile{
                    "NumPy (*.npz);;statismo, scalismo (*.h5 *.json);;ShapeWorks (*.particles);;"
                    "Mean and modes (*.ply);;Table of scores (*.csv)"}),
            help_.parameter("beside_shapes", host::hasWindow()),
            help_.parameter("area_weights", false).asAdvanced(),
            help_.parameter("surface_measures", false).asAdvanced(),
            help_.parameter("specificity_samples", measures.samples).asAdvanced(),
            help_.parameter("seed", static_cast<int>(measures.seed)).asAdvanced()};
  }

  host::Outputs run(host::Task& task) const override {
    const Stopwatch stopwatch;
    const int modesWanted = task.values.integer("modes");
    requireRange("number of modes", modesWanted, Range::atLeast(0));
    const double deviations = task.values.real("standard_deviations");
    requireRange("number of standard deviations", deviations, Range::above(0));
    const int modeLayers = task.values.integer("mode_layers");
    requireRange("number of modes shown", modeLayers, Range::atLeast(0));
    ModelMeasureParameters measureParameters;
    measureParameters.samples = task.values.integer("specificity_samples");
    const int seed = task.values.integer("seed");
    requireRange("seed", seed, Range::atLeast(0));
    measureParameters.seed = static_cast<unsigned>(seed);
    ProcrustesParameters procrustes;
    const AlignmentChoice asked = meaningOf(task.values.choice("alignment", alignments));
    procrustes.alignment = asked.alignment;
    procrustes.areaWeights = task.values.flag("area_weights");
    const LidRule lidRule = task.values.choice("leave_out_lids", lidRules);
    const std::string file = task.values.newFile("export_file");
    if (!file.empty()) requireExportable(file);

    const bool bySurfaces = task.values.flag("surface_measures");

    const Shapes shapes = shapesOf(task, lidRule, asked.byAnchors, bySurfaces);
    const TrainingSet& given = shapes.set;
    report(task.progress, 0.1);
    const Aligned aligned =
        asked.byAnchors ? alignByAnchors(given, inRows(shapes.anchors),
                                         asked.alignment == Alignment::Similarity, procrustes)
                        : alignShapes(given, procrustes);
    report(task.progress, 0.3);
    const Eigen::Index most = modesWanted > 0 ? modesWanted : given.shapeCount();
    const ShapeModel all =
        buildShapeModel(aligned.shapes, host::coordinateEpsilon(),
                        bySurfaces ? given.shapeCount() : most, part(task.progress, 0.3, 0.5));
    ShapeModel model = all.truncated(most);
    model.landmarkNames = namedLandmarks(given, shapes.anchors);
    const ModelMeasures measures = measureModel(all, model.modeCount(), measureParameters,
                                                part(task.progress, 0.5, bySurfaces ? 0.6 : 0.9));
    host::Outputs outputs;
    if (bySurfaces) {
      SurfaceMeasureParameters surfaceParameters;
      surfaceParameters.modes =
          static_cast<int>(std::min<Eigen::Index>(surfaceParameters.modes, model.modeCount()));
      surfaceParameters.seed = measureParameters.seed;
      const SurfaceMeasures found =
          measureSurfaces(all, given, aligned.shapes, shapes.sampled, surfaceParameters,
                          part(task.progress, 0.6, 0.9));
      say(task, found);
      outputs["surface_generalisation"] = found.generalisation;
      outputs["surface_generalisation_error"] = found.generalisationError;
      outputs["surface_specificity"] = found.specificity;
      outputs["surface_specificity_error"] = found.specificityError;
      outputs["off_surface"] = found.offSurface;
      outputs["folded_faces"] = Eigen::VectorXd(found.foldedFaces.cast<double>());
    }

    const Eigen::Index modes = model.modeCount();
    task.log(counted(given.shapeCount(), "shape", "shapes") + " of " +
             counted(given.landmarkCount(), "landmark", "landmarks") +
             (procrustes.alignment == Alignment::None
                  ? std::string(", not aligned")
                  : std::string(asked.byAnchors ? ", aligned by anchors in " : ", aligned in ") +
                        counted(aligned.iterations, "round", "rounds")) +
             ": " + counted(modes, "mode", "modes"));
    nameOutliers(task, given, aligned.shapes);
    if (!aligned.converged) task.say(messages::stillMoving, aligned.iterations);
    if (all.modeCount() == 0)
      task.say(messages::identicalShapes);
    else
      warnOfRepetitions(task, namesOf(given), repeatedBesides(shapes.again, aligned.shapes),
                        {messages::repeatedShape, messages::repeatedShapes});
    if (modesWanted > modes) task.say(messages::fewerModes, modes);
    for (Eigen::Index m = 0; m < std::min<Eigen::Index>(modes, std::max(modeLayers, 3)); ++m)
      task.log("mode " + std::to_string(m + 1) + ": standard deviation " +
               shortNumber(
                   std::sqrt(model.eigenvalues[m] / static_cast<double>(given.landmarkCount()))) +
               " per landmark, " + percent(model.eigenvalues[m] / model.totalVariance) +
               " of the variance, " + percent(measures.compactness[m] / model.totalVariance) +
               " with those before; generalisation " + shortNumber(measures.generalisation[m]) +
               ", specificity " + shortNumber(measures.specificity[m]));
    addLayers(task, model, std::min<Eigen::Index>(modes, modeLayers), deviations);
    if (!file.empty()) {  // last of what can fail
      const std::vector<std::string> written = exportModel(file, model, aligned.shapes);
      task.log(
          "written: " + written.front() +
          (written.size() > 1 ? ", and " + written[1] + " to " + written.back() : std::string()));
      if (!model.landmarkNames.empty())
        task.log(counted(static_cast<Eigen::Index>(model.landmarkNames.size()), "landmark has",
                         "landmarks have") +
                 " the name of an anchor");
    } else {
      task.say(messages::notExported);
    }

    task.say(messages::modelBuilt, given.shapeCount(), modes,
             hiddenLeftOut(task.layers, host::LayerKind::Landmarks));

    outputs["eigenvalues"] = model.eigenvalues;
    outputs["compactness"] = measures.compactness;
    outputs["variance_share"] =
        Eigen::VectorXd(measures.compactness / std::max(model.totalVariance, 1e-300));
    outputs["generalisation"] = measures.generalisation;
    outputs["generalisation_error"] = measures.generalisationError;
    outputs["specificity"] = measures.specificity;
    outputs["specificity_error"] = measures.specificityError;
    const Eigen::MatrixXd byShape =
        model.scores.transpose();  // columns lie in memory one after the other
    outputs["scores"] =
        Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(byShape.data(), byShape.size()));
    outputs["mean"] =
        Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(model.mean.data(), model.mean.size()));
    outputs["mode_vectors"] =
        Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(model.modes.data(), model.modes.size()));
    Eigen::VectorXd lid = Eigen::VectorXd::Zero(std::max<Eigen::Index>(
        given.landmarkCount(), static_cast<Eigen::Index>(given.leftOut().size())));
    for (size_t j = 0; j < given.leftOut().size(); ++j)
      lid[static_cast<Eigen::Index>(j)] = given.leftOut()[j];
    outputs["lid"] = lid;
    outputs["total_variance"] = model.totalVariance;
    outputs["shapes"] = static_cast<int>(given.shapeCount());
    outputs["modes"] = static_cast<int>(modes);
    outputs["landmarks"] = static_cast<int>(given.landmarkCount());
    outputs["seconds"] = stopwatch.seconds();
    return outputs;
  }

 private:
  static void say(const host::Task& task, const SurfaceMeasures& found) {
    for (Eigen::Index m = 0; m < std::min<Eigen::Index>(found.generalisation.size(), 3); ++m)
      task.log("between surfaces, with " + counted(m + 1, "mode", "modes") + ": generalisation " +
               shortNumber(found.generalisation[m]) + ", specificity " +
               shortNumber(found.specificity[m]));
    task.say(messages::offSurface, found.offSurface.mean(), found.offSurface.maxCoeff(),
             found.foldedFaces.sum());
  }

  const host::Help help_{"compute_statistical_shape_model",
                         {{"file_endings", modelFileEndings()},
                          {"max_samples", std::to_string(ModelMeasureParameters::maxSamples)}}};
};

}  // namespace

std::unique_ptr<host::Filter> makeShapeModelFilter() {
  return std::make_unique<ShapeModelFilter>();
}

}  // namespace sphere_propagation
