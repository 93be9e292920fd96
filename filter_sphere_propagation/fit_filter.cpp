// SPDX-License-Identifier: GPL-3.0-only
// "Fit shape model": a model meets a surface that it was not built from.

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "filter_sphere_propagation/filters.h"
#include "filter_sphere_propagation/messages.h"
#include "filter_sphere_propagation/reporting.h"
#include "filter_sphere_propagation/summaries.h"
#include "host/help.h"
#include "host/window.h"
#include "vcg_ext/anchors/anchor_file.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/base/fingerprint.h"
#include "vcg_ext/display/side_by_side.h"
#include "vcg_ext/fitting/fit_calibration.h"
#include "vcg_ext/fitting/fit_file.h"
#include "vcg_ext/fitting/fitted_map.h"
#include "vcg_ext/fitting/mirrored_fit.h"
#include "vcg_ext/fitting/model_fit.h"
#include "vcg_ext/fitting/sized_fit.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/model/model_file.h"
#include "vcg_ext/model/shape_deviation.h"

namespace sphere_propagation {
namespace {

enum class FitPose { Search, AsItLies, Anchors };
constexpr host::Named<FitPose> fitPoses[]{
    {"Search", FitPose::Search}, {"As it lies", FitPose::AsItLies}, {"Anchors", FitPose::Anchors}};

enum class FitSizes { AsTheModel, Rigid, Similarity };
constexpr host::Named<FitSizes> fitSizes[]{{"As the model", FitSizes::AsTheModel},
                                           {"Rigid", FitSizes::Rigid},
                                           {"Similarity", FitSizes::Similarity}};

Eigen::VectorXd byRow(const Eigen::MatrixXd& matrix) {
  const Eigen::MatrixXd turned = matrix.transpose();
  return Eigen::Map<const Eigen::VectorXd>(turned.data(), turned.size());
}

std::string landmarkNamesOf(const ShapeModel& shapes) {
  std::string names;
  for (const auto& [name, landmark] : shapes.landmarkNames)
    names.append(names.empty() ? "" : ", ").append(name);
  return names.empty() ? "none" : names;
}

/// Anchors that are called by a name that the model knows, or by the numbers of their landmarks.
std::vector<FittingAnchor> anchorsOf(const std::string& file, const ShapeModel& shapes,
                                     double deviation) {
  const Eigen::Index landmarks = shapes.mean.rows();
  std::vector<FittingAnchor> anchors;
  for (const auto& [name, point] : readAnchors(file).anchors) {
    const bool isNumber = !name.empty() && name.size() < 10 &&
                          name.find_first_not_of("0123456789") == std::string::npos;
    long landmark = isNumber ? std::stol(name) : -1;
    const auto known = shapes.landmarkNames.find(name);
    if (known != shapes.landmarkNames.end()) landmark = static_cast<long>(known->second);
    if (landmark < 0 || landmark >= landmarks)
      throw host::Refusal(messages::anchorIsNoLandmark, name, file, landmarks - 1,
                          landmarkNamesOf(shapes));
    anchors.push_back({landmark, point, deviation});
  }
  return anchors;
}

/// What a model is fitted to unless something else is chosen: the current layer, or where that was
/// made by a filter, as the mean shape is, the first visible surface.
int targetOf(const host::Layers& layers) {
  const std::optional<host::Layer> current = layers.find(layers.currentId());
  if (!current || current->kind() == host::LayerKind::Surface) return layers.currentId();
  const std::vector<host::Layer> surfaces = layers.visible(host::LayerKind::Surface);
  return surfaces.empty() ? current->id() : surfaces.front().id();
}

class FitFilter : public host::Filter {
 public:
  host::FilterDescription describe() const override {
    return help_.describe(host::Menu::Layer, host::Arity::CurrentLayer);
  }

  std::vector<host::Parameter> parameters(const host::Layers& layers) const override {
    return {
        help_.parameter("model_file", host::Parameter::File{"NumPy (*.npz)"}),
        help_.parameter("target_layer", host::Parameter::LayerId{targetOf(layers)}),
        help_.parameter("pose", host::choiceOf(fitPoses, FitPose::Search)),
        help_.parameter("alignment", host::choiceOf(fitSizes, FitSizes::AsTheModel)),
        help_.parameter("modes", 0),
        help_.parameter("local_deviation", true),
        help_.parameter("anchor_file",
                        host::Parameter::File{"Anchors (*.pp *.json *.fcsv *.csv *.tsv *.txt)"}),
        help_.parameter("anchor_sd", 0.0),
        help_.parameter("export_file", host::Parameter::NewFile{"NumPy (*.npz)"}),
        help_.parameter("threads", 0).asAdvanced()};
  }

  host::Outputs run(host::Task& task) const override {
    const Stopwatch stopwatch;
    const int modesWanted = task.values.integer("modes");
    requireRange("number of modes", modesWanted, Range::atLeast(0));
    const int threads = task.values.integer("threads");
    requireRange("number of threads", threads, Range::atLeast(0));
    double anchorSd = task.values.real("anchor_sd");
    requireRange("standard deviation of anchors", anchorSd, Range::atLeast(0));
    const FitPose pose = task.values.choice("pose", fitPoses);
    const FitSizes size = task.values.choice("alignment", fitSizes);
    const std::string exportName = task.values.newFile("export_file"),
                      modelName = task.values.file("model_file"),
                      anchorName = task.values.file("anchor_file");
    if (modelName.empty()) throw host::Refusal(messages::noModelFile);
    if (!exportName.empty()) requireFitFile(exportName);
    const std::optional<host::Layer> layer = task.layers.find(task.values.layerId("target_layer"));
    if (!layer) throw host::Refusal(messages::noTargetLayer);

    const ShapeModel shapes = readModel(modelName);
    const MeshContent content = layer->content();
    const FittingTarget target(content.vertices, content.faces, layer->label());
    report(task.progress, 0.1);
    ThreadPool pool(threads);
    FittingModelParameters ofModel;
    if (modesWanted > 0) ofModel.modes = modesWanted;
    if (!task.values.flag("local_deviation")) ofModel.localDeviation = 0;
    const FittingModel model(shapes, pool, ofModel);
    if (modesWanted > model.modeCount()) task.say(messages::fewerModes, model.modeCount());
    if (model.localDeviation() > 0 && shapes.noiseVariance == 0 &&
        shapes.scores.rows() < minShapesToLearnFrom)
      task.say(messages::localDeviationAssumed, model.localDeviation());

    ModelFitParameters parameters;
    if (pose != FitPose::AsItLies) parameters.pose = std::nullopt;
    parameters.scales =
        size == FitSizes::Similarity || (size == FitSizes::AsTheModel && isWithoutSize(shapes));
    if (anchorSd == 0) anchorSd = target.meanEdge();
    if (!anchorName.empty()) parameters.anchors = anchorsOf(anchorName, shapes, anchorSd);
    if (pose == FitPose::Anchors && parameters.anchors.size() < minPoseAnchors)
      throw host::Refusal(messages::tooFewAnchors, parameters.anchors.size());
    if (pose == FitPose::Search && parameters.anchors.size() >= minPoseAnchors)
      task.say(messages::poseOfAnchors, parameters.anchors.size());

    FitCalibrationParameters asked;
    asked.model = ofModel;
    asked.scales = parameters.scales;
    asked.meanEdge = target.meanEdge();
    if (parameters.scales) asked.meanEdge *= model.radius() / radiusOfSphere(target.area());
    parameters.calibration = fitCalibration(shapes, pool, asked);

    const ModelFit fit = [&] {
      try {
        return fitModel(model, target, pool, parameters, part(task.progress, 0.1, 0.7));
      } catch (const SurfaceError&) {  // the surface itself passed every check
        throw host::Refusal(messages::modelIsNotNear, layer->label());
      }
    }();
    const ShapeDeviation deviation = shapeDeviation(fit.scores, shapes.scores, shapes.eigenvalues);
    tellOf(task, *layer, model, target, fit, deviation);
    if (fit.starts > 1) {  // else the pose is known, and with it the side
      const double advantage = advantageOfMirrorImage(model, target, fit, parameters.scales, pool);
      if (advantage > clearAdvantage)
        task.sayOf(*layer, messages::mirrorImageFitsBetter, advantage);
    }
    if (!parameters.scales && isWithoutSize(shapes)) {
      const SizedFit own = fitOfOwnSize(model, target, fit, parameters, pool);
      if (own.advantage > clearAdvantage)
        task.sayOf(*layer, messages::sizeIsHeld, own.scale, own.advantage);
    }
    addLayer(task, *layer, model, fit);
    host::Outputs outputs = outputsOf(model, fit, deviation, target);
    outputs["calibration"] = parameters.calibration;
    setMap(task, *layer, model, fit, target, pool, outputs);
    if (!exportName.empty()) {  // last of what can fail
      exportFit(exportName, model, fit);
      task.log("written: " + exportName);
    } else {
      task.say(messages::fitNotExported);
    }
    task.say(messages::modelFitted, layer->label(), fit.surfaceDistance,
             host::said(outputs.count("flipped_faces") > 0 ? messages::nextIsRemeshing
                                                           : messages::lookAtTheFit));
    outputs["seconds"] = stopwatch.seconds();
    return outputs;
  }

 private:
  static void tellOf(const host::Task& task, const host::Layer& layer, const FittingModel& model,
                     const FittingTarget& target, const ModelFit& fit,
                     const ShapeDeviation& deviation) {
    task.log(layer.label() + ": " + shortNumber(fit.surfaceDistance) +
             " from the surface on average, noise " + shortNumber(fit.noise) +
             ", standard deviation of landmarks " + shortNumber(fit.deviations().mean()) +
             ", deviation " + shortNumber(deviation.deviation) +
             (deviation.training.size() > 0
                  ? " (more than " + shortNumber(100 * deviation.percentile) +
                        " % of the training shapes)"
                  : std::string()) +
             ", " + counted(fit.starts, "start", "starts"));
    if (fit.unseen > 0) task.say(messages::landmarksUnseen, layer.label(), 100 * fit.unseen);
    // What the training shapes leave of each other, three times, and what a mesh's edges do; within
    // what nobody would see and what anybody would.
    constexpr double much = 0.1, play = 3, ofEdge = 0.25, least = 0.02, most = 0.05;
    const double size = fit.scale * model.radius();
    const double far =
        std::clamp(play * fit.scale * model.localDeviation() + ofEdge * target.meanEdge(),
                   least * size, most * size);
    if (fit.unexplained > much)
      task.sayOf(layer, messages::surfaceUnexplained, 100 * fit.unexplained);
    else if (fit.surfaceDistance > far)
      task.sayOf(layer, messages::fitIsFarOff, fit.surfaceDistance);
    constexpr double otherUnit =
        1.8;  // about what names a layer beside another (surface_sizes.cpp)
    if (fit.scale > otherUnit)
      task.sayOf(layer, messages::fitOfOtherSize, fit.scale, "larger");
    else if (fit.scale < 1 / otherUnit)
      task.sayOf(layer, messages::fitOfOtherSize, 1 / fit.scale, "smaller");
    constexpr double unusual = 1.5;
    if (deviation.training.size() > 0 &&
        deviation.deviation > unusual * deviation.training.maxCoeff())
      task.sayOf(layer, messages::shapeIsUnusual, deviation.deviation,
                 deviation.training.maxCoeff());
  }

  static void addLayer(host::Task& task, const host::Layer& layer, const FittingModel& model,
                       const ModelFit& fit) {
    host::NewLayer made;
    made.label = layer.derivedLabel("fit");
    made.kind = host::LayerKind::Fit;
    made.marks[host::fitMark] = 1;
    made.vertices = fit.landmarks;
    made.faces = model.faces();
    made.quality = fit.deviations();
    // On its surface, also where that is laid beside others.
    if (layer.isShownAside())
      made.aside = layer.shownBox().center() - boxOf(layer.content().vertices).center();
    task.changes.addLayer(made);
    if (host::hasWindow()) task.changes.makeFirstNewLayerCurrent();
  }

  static host::Outputs outputsOf(const FittingModel& model, const ModelFit& fit,
                                 const ShapeDeviation& deviation, const FittingTarget& target) {
    Eigen::VectorXd covariance(9 * fit.landmarks.rows());
    for (size_t j = 0; j < fit.covariance.size(); ++j)
      covariance.segment<9>(9 * static_cast<Eigen::Index>(j)) =
          Eigen::Map<const Eigen::Matrix<double, 9, 1>>(fit.covariance[j].data());  // symmetric
    return {{"scores", fit.scores},
            {"score_sd", fit.scoreDeviations},
            {"pose", byRow(fit.pose())},
            {"landmark_sd", fit.deviations()},
            {"covariance", covariance},
            {"surface_distance", fit.surfaceDistance},
            {"noise", fit.noise},
            {"deviation", deviation.deviation},
            {"percentile", 100 * deviation.percentile},
            {"local_deviation", model.localDeviation()},
            {"unseen", fit.unseen},
            {"unexplained", fit.unexplained},
            {"starts", fit.starts},
            {"closed", target.closed()}};
  }

  /// Where it can be had.
  static void setMap(host::Task& task, const host::Layer& layer, const FittingModel& model,
                     const ModelFit& fit, const FittingTarget& target, ThreadPool& pool,
                     host::Outputs& outputs) {
    if (!target.closed() || !hasMap(model)) {
      task.say(target.closed() ? messages::noMapWithoutLids : messages::noMapOfOpenSurface,
               layer.label());
      return;
    }
    try {
      const MeshSurface mesh = layer.surface();
      const PropagatedLayer mapped =
          mapOfFit(model, fit, mesh.surface, pool, part(task.progress, 0.7, 0.95));
      Fingerprint print;  // all that one model is fitted to belongs together
      print.add(static_cast<int>(model.mean().rows()));
      print.add(model.mean().sum());
      if (const auto note = task.changes.setMap(layer, mesh, mapped.map(), print.short24()))
        task.tell(*note);
      const MapMeasures measures = measureMap(mesh.surface, mapped.map().positions());
      task.log(describeMap(layer.label(), mesh.surface, measures) + ", residual " +
               shortNumber(mapped.transferred.residual.mean));
      outputs["flipped_faces"] = static_cast<int>(measures.certificate.flippedFaces);
      outputs["area_ratio_sd"] = measures.areaRatioSd;
      outputs["area_log_mean"] = measures.areaLogMean;
      outputs["angle_error_mean"] = measures.angleErrorMean;
      outputs["residual_mean"] = mapped.transferred.residual.mean;
      outputs["residual_p95"] = mapped.transferred.residual.p95;
      outputs["repaired_faces"] = mapped.transferred.repairedFaces;
    } catch (const Error& error) {
      // The fit stands, whatever the surface is like.
      task.sayOf(layer, messages::fitGivesNoMap, error.what());
    }
  }

  const host::Help help_{"compute_shape_model_fit"};
};

}  // namespace

std::unique_ptr<host::Filter> makeFitFilter() { return std::make_unique<FitFilter>(); }

}  // namespace sphere_propagation
