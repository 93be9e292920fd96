// SPDX-License-Identifier: GPL-3.0-only
// "Show parameterisation as sphere layers": the maps, to be looked at.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "filter_sphere_propagation/filters.h"
#include "filter_sphere_propagation/mapped_layers.h"
#include "filter_sphere_propagation/messages.h"
#include "filter_sphere_propagation/reporting.h"
#include "filter_sphere_propagation/summaries.h"
#include "host/help.h"
#include "host/window.h"
#include "vcg_ext/base/rotation.h"
#include "vcg_ext/mesh/surface_geometry.h"

namespace sphere_propagation {
namespace {

/// The rotation of the sphere that shows the same side as the surface: the best one from the map to
/// directions from the centre.
Eigen::Matrix3d sameSide(const MappedLayer& mapped) {
  const Points& vertices = mapped.mesh.surface.vertices();
  const Points directions = vertices.rowwise() - vertices.colwise().mean();
  return bestRotation(directions.transpose() * mapped.map.positions());
}

/// Where the spheres are shown beside what is visible: in rows to the right of all of it (MeshLab
/// looks along -z, y upwards), in layer order, each of its surface's area.
std::vector<Eigen::Matrix4d> placesBeside(const std::vector<MappedLayer>& layers,
                                          const Eigen::AlignedBox3d& all) {
  std::vector<double> radii;
  for (const MappedLayer& mapped : layers) {
    const ClosedSurface& surface = mapped.mesh.surface;
    radii.push_back(std::sqrt(faceAreas(surface.vertices(), surface.faces()).sum() / (4 * pi)));
  }
  const double radius = *std::max_element(radii.begin(), radii.end()), step = 2.25 * radius;
  const auto columns =
      static_cast<size_t>(std::ceil(std::sqrt(static_cast<double>(layers.size()))));
  const size_t rows = (layers.size() + columns - 1) / columns;
  std::vector<Eigen::Matrix4d> places;
  for (size_t i = 0; i < layers.size(); ++i) {
    const auto column = static_cast<double>(i % columns), row = static_cast<double>(i / columns);
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    matrix.topLeftCorner<3, 3>() = radii[i] * sameSide(layers[i]);
    matrix.topRightCorner<3, 1>() << all.max().x() + (column + 0.5) * step + 0.25 * radius,
        all.center().y() + (0.5 * static_cast<double>(rows - 1) - row) * step, all.center().z();
    places.push_back(matrix);
  }
  return places;
}

class SphereLayersFilter : public host::Filter {
 public:
  host::FilterDescription describe() const override {
    return help_.describe(host::Menu::Layer, host::Arity::VisibleLayers);
  }

  std::vector<host::Parameter> parameters(const host::Layers&) const override {
    return {help_.parameter("beside_surfaces", host::hasWindow())};
  }

  host::Outputs run(host::Task& task) const override {
    const std::vector<MappedLayer> layers = mappedLayers(task);
    const bool beside = task.values.flag("beside_surfaces");
    const std::vector<Eigen::Matrix4d> places =
        placesBeside(layers, shownBeside(task.layers, host::LayerKind::Sphere));
    for (size_t i = 0; i < layers.size(); ++i) {
      const auto& [layer, mesh, map] = layers[i];
      host::NewLayer sphere;
      sphere.label = layer.derivedLabel("sphere");
      sphere.kind = host::LayerKind::Sphere;
      sphere.vertices = map.positions();
      sphere.faces = mesh.surface.faces();
      sphere.colors = layer.colors(mesh);
      if (beside) sphere.matrix = places[i];
      task.changes.addLayer(sphere);
      report(task.progress, static_cast<double>(i + 1) / static_cast<double>(layers.size()));
    }
    const int made = static_cast<int>(layers.size());
    task.log(counted(made, "sphere layer", "sphere layers") +
             (beside ? ", beside the surfaces"
                     : ", radius 1 at the origin: hide the surfaces to see them, or ask for them "
                       "beside the surfaces"));
    task.say(messages::spheresMade, task.layers.visible(host::LayerKind::Surface).size(), made,
             hiddenLeftOut(task.layers, host::LayerKind::Surface));
    return {{"layers", made}};
  }

 private:
  const host::Help help_{"generate_sphere_layers"};
};

}  // namespace

std::unique_ptr<host::Filter> makeSphereLayersFilter() {
  return std::make_unique<SphereLayersFilter>();
}

}  // namespace sphere_propagation
