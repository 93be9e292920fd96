// SPDX-License-Identifier: GPL-3.0-only
// "Beating ventricle phantom": layers to try everything on, with known truth.

#include <algorithm>

#include "filter_sphere_propagation/filters.h"
#include "filter_sphere_propagation/reporting.h"
#include "host/help.h"
#include "vcg_ext/volume/ventricle_phantom.h"

namespace sphere_propagation {
namespace {

constexpr host::Named<PhantomParameters::Part> parts[]{{"Cavity", PhantomParameters::Part::Cavity},
                                                       {"Wall", PhantomParameters::Part::Wall}};

class PhantomFilter : public host::Filter {
 public:
  host::FilterDescription describe() const override {
    return help_.describe(host::Menu::MeshCreation | host::Menu::Layer, host::Arity::None);
  }

  std::vector<host::Parameter> parameters(const host::Layers&) const override {
    const PhantomParameters defaults;
    return {help_.parameter("part", host::choiceOf(parts, defaults.part)),
            help_.parameter("phases", defaults.phases),
            help_.parameter("voxel_size", defaults.voxelSize),
            help_.parameter("twist", defaults.twist), help_.parameter("seed", 0)};
  }

  host::Outputs run(host::Task& task) const override {
    const Stopwatch stopwatch;
    PhantomParameters parameters;
    parameters.part = task.values.choice("part", parts);
    const bool wall = parameters.part == PhantomParameters::Part::Wall;
    parameters.phases = task.values.integer("phases");
    parameters.voxelSize = task.values.real("voxel_size");
    parameters.twist = task.values.real("twist");
    const int seed = task.values.integer("seed");
    requireRange("seed", seed, Range::atLeast(0));
    parameters.seed = static_cast<unsigned>(seed);
    const VentriclePhantom phantom(parameters);

    const std::string name = wall ? "phantom wall " : "phantom cavity ";
    const size_t digits = std::max<size_t>(2, std::to_string(parameters.phases - 1).size());
    Eigen::VectorXd vertices(parameters.phases);
    for (int phase = 0; phase < parameters.phases; ++phase) {
      PhantomMesh mesh = phantom.mesh(phase);
      std::string number = std::to_string(phase);
      number.insert(0, digits - number.size(), '0');
      host::NewLayer layer;
      layer.label = name + number;
      layer.vertices = std::move(mesh.vertices);
      layer.faces = std::move(mesh.faces);
      layer.pointAttributes["material_coordinate"] = std::move(mesh.materialCoordinates);
      task.changes.addLayer(layer);
      vertices[phase] = static_cast<double>(layer.vertices.rows());
      report(task.progress, (phase + 1.0) / parameters.phases);
    }
    task.changes.makeFirstNewLayerCurrent();
    task.log(counted(parameters.phases, "phase", "phases") + " of the phantom's " +
             (wall ? "wall" : "cavity") + ", " + shortNumber(vertices.mean()) +
             " vertices on average, " + shortNumber(stopwatch.seconds()) + " s");
    task.say(messages::phantomMade, parameters.phases);
    return {
        {"layers", parameters.phases}, {"vertices", vertices}, {"seconds", stopwatch.seconds()}};
  }

 private:
  const host::Help help_{"create_ventricle_phantom",
                         {{"max_phases", std::to_string(PhantomParameters::maxPhases)},
                          {"min_voxel_size", shortNumber(PhantomParameters::minVoxelSize)},
                          {"max_voxel_size", shortNumber(PhantomParameters::maxVoxelSize)},
                          {"max_twist", shortNumber(PhantomParameters::maxTwist)}}};
};

}  // namespace

std::unique_ptr<host::Filter> makePhantomFilter() { return std::make_unique<PhantomFilter>(); }

}  // namespace sphere_propagation
