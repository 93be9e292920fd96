// "Remesh by icosphere": every surface that has a map is sampled at the same points of the sphere.

#include "filter_sphere_propagation/filters.h"
#include "filter_sphere_propagation/landmark_sources.h"
#include "filter_sphere_propagation/mapped_layers.h"
#include "filter_sphere_propagation/reporting.h"
#include "vcg_ext/mesh/icosphere.h"
#include "vcg_ext/remeshing/landmark_colors.h"
#include "vcg_ext/remeshing/remeshing.h"

namespace sphere_propagation {
namespace {

/// Landmarks of all layers together, at most: about 6 GB of layers in MeshLab.
constexpr long mostLandmarks = 20'000'000;

/// For each layer the landmark layer that an earlier run made of it, whatever it is called by now.
std::vector<std::optional<int>> earlierLandmarks(const host::Task& task, const std::vector<MappedLayer>& layers) {
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
      task.log("Layer \"" + landmarks[i].label() + "\" also holds landmarks of \"" + surfaces[*sources[i]].label() +
               "\", from an earlier run: delete or hide it, or the shape model counts the shape twice.");
  }
  return found;
}

class RemeshingFilter : public host::Filter {
 public:
  host::FilterDescription describe() const override {
    return {
        "Remesh by icosphere", "generate_icosphere_remeshing",
        "Samples every visible surface layer that has a map to the sphere by one and the same icosphere. Each gets a "
        "new layer \"... landmarks\", all with one face list, so that <b>vertex j is the same landmark on every "
        "shape</b>: the input of a statistical shape model. Frequency f gives 10 f<sup>2</sup> + 2 landmarks; 10 gives "
        "the "
        "paper's 1002. New layers have the identity matrix: landmarks lie where the surfaces are seen. Run again, the "
        "filter replaces the layers that it made, also those that were saved and loaded since.<br><br>"
        "Returned, one entry per layer with a map: <b>surface_distance_mean</b>, <b>surface_distance_max</b>: distance "
        "between landmark mesh and surface, both ways, in the mesh's unit; <b>seconds</b>.<br><br>" +
            paperReference(),
        static_cast<int>(host::Menu::Remeshing), host::Arity::VisibleLayers};
  }

  std::vector<host::Parameter> parameters(const host::Layers&) const override {
    return {
        {"frequency", "Frequency",
         "Into how many parts each edge of the icosahedron is split, 1 to " +
             std::to_string(largestIcosphereFrequency) + ": 10 f^2 + 2 landmarks.",
         10},
        {"color_landmarks", "Colour landmarks",
         "Show the index of each landmark as its hue: the same colour means the same landmark on every layer.", true}};
  }

  host::Outputs run(host::Task& task) const override {
    const std::vector<MappedLayer> layers = mappedLayers(task);
    const int frequency = task.values.integer("frequency");
    const long landmarks = 10L * frequency * frequency + 2;
    const long affordable = mostLandmarks / static_cast<long>(layers.size());
    if (frequency >= 1 && frequency <= largestIcosphereFrequency && landmarks > affordable)
      throw ParameterError("Frequency " + std::to_string(frequency) + " on " +
                           counted(static_cast<long>(layers.size()), "layer", "layers") + " makes " +
                           std::to_string(landmarks * static_cast<long>(layers.size())) + " landmarks, more than " +
                           std::to_string(mostLandmarks) + ". Choose a lower frequency or hide layers.");
    const Icosphere sphere = icosphere(frequency);
    std::optional<Colors> colors;
    if (task.values.flag("color_landmarks")) colors = landmarkColors(sphere.vertices.rows());

    const std::vector<std::optional<int>> earlier = earlierLandmarks(task, layers);
    const auto count = static_cast<Eigen::Index>(layers.size());
    Eigen::VectorXd mean(count), max(count), seconds(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const auto k = static_cast<size_t>(i);
      const Stopwatch stopwatch;
      const Remeshed remeshed = remesh(layers[k].mesh.surface, layers[k].map, sphere.vertices);
      const SurfaceDistance distance = surfaceDistance(remeshed.landmarks, sphere.faces, layers[k].mesh.surface);
      host::NewLayer made;
      made.label = layers[k].layer.derivedLabel("landmarks");
      made.kind = host::LayerKind::Landmarks;
      made.vertices = remeshed.landmarks;
      made.faces = sphere.faces;
      made.colors = colors;
      made.replacedId = earlier[k];
      task.changes.addLayer(made);
      mean[i] = distance.mean;
      max[i] = distance.max;
      seconds[i] = stopwatch.seconds();
      task.log(layers[k].layer.label() + ": " + std::to_string(landmarks) + " landmarks, distance to the surface " +
               shortNumber(distance.mean) + " on average, " + shortNumber(distance.max) + " at most, " +
               shortNumber(seconds[i]) + " s");
      report(task.progress, static_cast<double>(i + 1) / static_cast<double>(count));
    }
    return {{"surface_distance_mean", mean}, {"surface_distance_max", max}, {"seconds", seconds}};
  }
};

}  // namespace

std::unique_ptr<host::Filter> makeRemeshingFilter() { return std::make_unique<RemeshingFilter>(); }

}  // namespace sphere_propagation
