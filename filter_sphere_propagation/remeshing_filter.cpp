// SPDX-License-Identifier: GPL-3.0-only
// "Remesh by icosphere": every surface that has a map is sampled at the same points of the sphere.

#include <atomic>
#include <thread>
#include <utility>

#include "filter_sphere_propagation/filters.h"
#include "filter_sphere_propagation/landmark_sources.h"
#include "filter_sphere_propagation/map_roots.h"
#include "filter_sphere_propagation/mapped_layers.h"
#include "filter_sphere_propagation/messages.h"
#include "filter_sphere_propagation/reporting.h"
#include "host/help.h"
#include "vcg_ext/display/colors.h"
#include "vcg_ext/mesh/icosphere.h"
#include "vcg_ext/remeshing/icosphere_remesher.h"

namespace sphere_propagation {
namespace {

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

class RemeshingFilter : public host::Filter {
 public:
  host::FilterDescription describe() const override {
    return help_.describe(host::Menu::Remeshing, host::Arity::VisibleLayers);
  }

  std::vector<host::Parameter> parameters(const host::Layers&) const override {
    return {help_.parameter("frequency", 10), help_.parameter("color_landmarks", true),
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
    if (task.values.flag("color_landmarks")) colors = landmarkColors(landmarks);

    const std::vector<std::optional<int>> earlier = earlierLandmarks(task, layers);
    const auto count = static_cast<int>(layers.size());
    const std::vector<Made> all = makeAll(remesher, layers, pool, task.progress);
    Eigen::VectorXd mean(count), max(count), seconds(count);
    for (int i = 0; i < count; ++i) {
      const auto k = static_cast<size_t>(i);
      host::NewLayer made;
      made.label = layers[k].layer.derivedLabel("landmarks");
      made.kind = host::LayerKind::Landmarks;
      made.vertices = all[k].landmarks;
      made.faces = remesher.sphere().faces;
      made.colors = colors;
      made.marks = landmarkMarks(layers[k].layer);
      made.replacedId = earlier[k];
      task.changes.addLayer(made);
      mean[i] = all[k].distance.mean;
      max[i] = all[k].distance.max;
      seconds[i] = all[k].seconds;
      task.say(messages::landmarksMade, layers[k].layer.label(), landmarks, mean[i], max[i],
               seconds[i]);
    }
    return {{"surface_distance_mean", mean}, {"surface_distance_max", max}, {"seconds", seconds}};
  }

 private:
  struct Made {
    Points landmarks;
    SurfaceDistance distance;
    double seconds;
  };

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
      const double share = static_cast<double>(++finished) / static_cast<double>(layers.size());
      if (std::this_thread::get_id() == caller) report(progress, share);
      return Made{std::move(remeshed.landmarks), distance, stopwatch.seconds()};
    });
  }

  const host::Help help_{"generate_icosphere_remeshing",
                         {{"max_frequency", std::to_string(maxIcosphereFrequency)}}};
};

}  // namespace

std::unique_ptr<host::Filter> makeRemeshingFilter() { return std::make_unique<RemeshingFilter>(); }

}  // namespace sphere_propagation
