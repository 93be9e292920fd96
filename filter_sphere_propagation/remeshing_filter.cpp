// SPDX-License-Identifier: GPL-3.0-only
// "Remesh by icosphere": every surface that has a map is sampled at the same points of the sphere.

#include <algorithm>
#include <atomic>
#include <thread>
#include <utility>

#include "filter_sphere_propagation/filters.h"
#include "filter_sphere_propagation/landmark_sources.h"
#include "filter_sphere_propagation/map_roots.h"
#include "filter_sphere_propagation/mapped_layers.h"
#include "filter_sphere_propagation/messages.h"
#include "filter_sphere_propagation/reporting.h"
#include "filter_sphere_propagation/summaries.h"
#include "host/help.h"
#include "host/window.h"
#include "vcg_ext/display/colors.h"
#include "vcg_ext/display/side_by_side.h"
#include "vcg_ext/display/sphere_pattern.h"
#include "vcg_ext/mesh/icosphere.h"
#include "vcg_ext/remeshing/icosphere_remesher.h"

namespace sphere_propagation {
namespace {

enum class LandmarkColors { Place, Index };
constexpr host::Named<LandmarkColors> schemes[]{{"Place on the sphere", LandmarkColors::Place},
                                                {"Index as hue", LandmarkColors::Index}};

Colors colorsOf(LandmarkColors scheme, const Points& places) {
  if (scheme == LandmarkColors::Index) return landmarkColors(places.rows());
  return sphereColors(places, Eigen::VectorXd::Zero(places.rows()), {SpherePattern::Direction});
}

/// Landmarks of all layers together, at most: about 6 GB of layers in MeshLab.
constexpr long maxLandmarks = 20'000'000;

/// For each layer the landmark layer that an earlier run made of it, whatever it is called by now.
std::vector<std::optional<int>> earlierLandmarks(const host::Task& task,
                                                 const std::vector<MappedLayer>& layers) {
  std::vector<host::Layer> surfaces;
  surfaces.reserve(layers.size());
  for (const MappedLayer& layer : layers) surfaces.push_back(layer.layer);
  const std::vector<host::Layer> landmarks = task.layers.all(host::LayerKind::Landmarks);
  const std::vector<std::optional<size_t>> sources = landmarkSources(landmarks, surfaces);
  std::vector<std::optional<int>> found(layers.size());
  for (size_t i = 0; i < landmarks.size(); ++i) {
    if (!sources[i]) continue;
    if (!found[*sources[i]])
      found[*sources[i]] = landmarks[i].id();
    else
      task.sayOf(landmarks[i], messages::landmarksTwice, surfaces[*sources[i]].label());
  }
  return found;
}

/// How the lids of the layers agree, in words. lids: of each layer those of its landmarks; empty:
/// it has none.
void tellOfLids(const host::Task& task, const std::vector<MappedLayer>& layers,
                const std::vector<std::vector<int>>& lids, long landmarks) {
  std::vector<std::string> without;
  std::vector<size_t> layersWith(static_cast<size_t>(landmarks), 0);
  for (size_t i = 0; i < lids.size(); ++i) {
    if (lids[i].empty()) without.push_back(layers[i].layer.label());
    for (size_t j = 0; j < lids[i].size(); ++j) layersWith[j] += lids[i][j] > 0;
  }
  const size_t with = lids.size() - without.size();
  if (with == 0) return;
  const auto onAll = std::count(layersWith.begin(), layersWith.end(), with);
  const auto onNone = std::count(layersWith.begin(), layersWith.end(), size_t{0});
  task.say(messages::landmarksOnLids, landmarks - onNone, with, onAll, landmarks - onNone - onAll);
  std::vector<std::string> names;
  std::vector<std::vector<double>> sizes;
  for (const MappedLayer& layer : layers) {
    const std::vector<int> numbers = layer.layer.lids(layer.mesh.meshVertex);
    if (numbers.empty()) continue;
    names.push_back(layer.layer.label());
    const ClosedSurface& surface = layer.map.surface();
    sizes.push_back(lidSizes(surface.vertices(), surface.faces(), numbers));
  }
  warnOfOpenings(task, names, sizes);
  if (!without.empty()) task.sayNaming(without, messages::layersWithoutLids, namesIn(without));
}

class RemeshingFilter : public host::Filter {
 public:
  host::FilterDescription describe() const override {
    return help_.describe(host::Menu::Remeshing | host::Menu::Layer, host::Arity::VisibleLayers);
  }

  std::vector<host::Parameter> parameters(const host::Layers&) const override {
    return {help_.parameter("frequency", 10), help_.parameter("color_landmarks", true),
            help_.parameter("landmark_colors", host::choiceOf(schemes, LandmarkColors::Place)),
            help_.parameter("beside_surfaces", host::hasWindow()),
            help_.parameter("threads", 0).asAdvanced()};
  }

  host::Outputs run(host::Task& task) const override {
    const int frequency = task.values.integer("frequency");
    requireIcosphereFrequency(frequency);
    const int threads = task.values.integer("threads");
    requireRange("number of threads", threads, Range::atLeast(0));
    ThreadPool pool(threads);
    const std::vector<MappedLayer> layers = mappedLayers(task, &pool);
    const long landmarks = 10L * frequency * frequency + 2;
    const long affordable = maxLandmarks / static_cast<long>(layers.size());
    if (landmarks > affordable)
      throw host::Refusal(messages::tooManyLandmarks, frequency, layers.size(),
                          landmarks * static_cast<long>(layers.size()), maxLandmarks);
    const IcosphereRemesher remesher(frequency);
    std::optional<Colors> colors;
    if (task.values.flag("color_landmarks"))
      colors = colorsOf(task.values.choice("landmark_colors", schemes), remesher.sphere().vertices);

    const std::vector<std::optional<int>> earlier = earlierLandmarks(task, layers);
    const auto count = static_cast<int>(layers.size());
    const std::vector<Made> all = makeAll(remesher, layers, pool, task.progress);
    const bool beside = task.values.flag("beside_surfaces");
    std::vector<Eigen::AlignedBox3d> boxes;
    for (const Made& made : all) boxes.push_back(boxOf(made.landmarks));
    const std::vector<Vector3> moves =
        sideBySide(boxes, shownBeside(task.layers, host::LayerKind::Landmarks));
    Eigen::VectorXd mean(count), max(count), seconds(count), lid(count);
    std::vector<std::vector<int>> lids;
    for (int i = 0; i < count; ++i) {
      const auto k = static_cast<size_t>(i);
      host::NewLayer made;
      made.label = layers[k].layer.derivedLabel("landmarks");
      made.kind = host::LayerKind::Landmarks;
      made.vertices = all[k].landmarks;
      made.faces = remesher.sphere().faces;
      made.colors = colors;
      made.marks = landmarkMarks(layers[k].layer);
      markLids(made, all[k].lids);
      made.replacedId = earlier[k];
      if (beside) made.aside = moves[k];
      task.changes.addLayer(made);
      mean[i] = all[k].distance.mean;
      max[i] = all[k].distance.max;
      seconds[i] = all[k].seconds;
      lid[i] = static_cast<double>(std::count_if(all[k].lids.begin(), all[k].lids.end(),
                                                 [](int number) { return number > 0; }));
      lids.push_back(all[k].lids);
      task.say(messages::landmarksMade, layers[k].layer.label(), landmarks, mean[i], max[i],
               seconds[i]);
    }
    tellOfLids(task, layers, lids, landmarks);
    if (host::hasWindow()) task.changes.makeFirstNewLayerCurrent();
    if (beside) task.say(messages::shownAside);
    task.say(messages::landmarksSampled, task.layers.visible(host::LayerKind::Surface).size(),
             count, hiddenLeftOut(task.layers, host::LayerKind::Surface));
    return {{"surface_distance_mean", mean},
            {"surface_distance_max", max},
            {"lid", lid},
            {"seconds", seconds}};
  }

 private:
  struct Made {
    Points landmarks;
    std::vector<int> lids;  // of each landmark; empty: the surface has none
    SurfaceDistance distance;
    double seconds;
  };

  static void markLids(host::NewLayer& layer, const std::vector<int>& lids) {
    if (lids.empty()) return;
    Eigen::VectorXd numbers(static_cast<Eigen::Index>(lids.size()));
    for (size_t j = 0; j < lids.size(); ++j) {
      numbers[static_cast<Eigen::Index>(j)] = lids[j];
      layer.selectedVertices.push_back(lids[j] > 0);
    }
    for (Eigen::Index f = 0; f < layer.faces.rows(); ++f) {
      const auto isOnLid = [&](int k) { return lids[static_cast<size_t>(layer.faces(f, k))] > 0; };
      layer.selectedFaces.push_back(isOnLid(0) && isOnLid(1) && isOnLid(2));
    }
    layer.scalarAttributes[host::lidAttribute] = numbers;
  }

  static std::vector<Made> makeAll(const IcosphereRemesher& remesher,
                                   const std::vector<MappedLayer>& layers, ThreadPool& pool,
                                   const Progress& progress) {
    const auto caller = std::this_thread::get_id();
    std::atomic<int> finished{0};
    return pool.makeEach(static_cast<int>(layers.size()), [&](int i) {
      const MappedLayer& layer = layers[static_cast<size_t>(i)];
      const Stopwatch stopwatch;
      Remeshed remeshed = remesher.remesh(layer.map);
      const SurfaceDistance distance = remesher.distance(remeshed, layer.map);
      const std::vector<int> lids = layer.layer.lids(layer.mesh.meshVertex);
      std::vector<int> ofLandmarks;
      if (!lids.empty()) ofLandmarks = lidsOfLandmarks(remeshed, layer.map.surface().faces(), lids);
      const double share = static_cast<double>(++finished) / static_cast<double>(layers.size());
      if (std::this_thread::get_id() == caller) report(progress, share);
      return Made{std::move(remeshed.landmarks), std::move(ofLandmarks), distance,
                  stopwatch.seconds()};
    });
  }

  const host::Help help_{"generate_icosphere_remeshing",
                         {{"max_frequency", std::to_string(maxIcosphereFrequency)}}};
};

}  // namespace

std::unique_ptr<host::Filter> makeRemeshingFilter() { return std::make_unique<RemeshingFilter>(); }

}  // namespace sphere_propagation
