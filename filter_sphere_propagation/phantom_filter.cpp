// SPDX-License-Identifier: GPL-3.0-only
// "Beating ventricle phantom": layers to try everything on, with known truth.

#include <algorithm>

#include "filter_sphere_propagation/filters.h"
#include "filter_sphere_propagation/reporting.h"
#include "vcg_ext/volume/ventricle_phantom.h"

namespace sphere_propagation {
namespace {

class PhantomFilter : public host::Filter {
 public:
  host::FilterDescription describe() const override {
    return {
        "Beating ventricle phantom", "create_ventricle_phantom",
        "Makes a left ventricle over one heart cycle, one layer per phase, each meshed on its own "
        "from voxels, so that no two layers correspond: a sample to try the other filters on. "
        "Phase 0 is end-diastole and becomes the current layer. The motion of every material point "
        "is known: the per-vertex attribute <i>material_coordinate</i> = (u, theta, m) says which "
        "point of the tissue a vertex is (u: apex 0 to base 1, theta: angle round the long axis in "
        "radians, m: inner 0 to outer surface 1), so the error of a correspondence can be "
        "measured. The lid of the cavity is no tissue: there u goes on from 1 at the rim to 2 on "
        "the axis.<br><br>Returned: <b>layers</b>, <b>vertices</b> (one entry per phase), "
        "<b>seconds</b>.<br><br>Surfaces are extracted by marching cubes:<br><i>William E. "
        "Lorensen and Harvey E. Cline</i><br><b>\"Marching cubes: a high resolution 3D surface "
        "construction algorithm\"</b><br>Computer Graphics 21(4), 1987.",
        static_cast<int>(host::Menu::MeshCreation), host::Arity::None};
  }

  std::vector<host::Parameter> parameters(const host::Layers&) const override {
    const PhantomParameters defaults;
    return {{"part", "Part",
             "Cavity: the blood pool, a rounded cone. Wall: the muscle around it, a thick cup.",
             host::Parameter::Choice{{"Cavity", "Wall"}, 0}},
            {"phases", "Phases", "Layers over one cycle, 1 to 10000.", defaults.phases},
            {"voxel_size", "Voxel size",
             "mm, 0.25 to 4. Smaller voxels make finer meshes: 2 mm gives about 4000 vertices.",
             defaults.voxelSize},
            {"twist", "Twist",
             "Degrees, -360 to 360, by which the apex turns against the base at end-systole.",
             defaults.twist},
            {"seed", "Seed", "Each number makes another ventricle; 0 or more.", 0}};
  }

  host::Outputs run(host::Task& task) const override {
    const Stopwatch stopwatch;
    PhantomParameters parameters;
    const bool wall = task.values.choice("part") == 1;
    parameters.part = wall ? PhantomParameters::Part::Wall : PhantomParameters::Part::Cavity;
    parameters.phases = task.values.integer("phases");
    parameters.voxelSize = task.values.real("voxel_size");
    parameters.twist = task.values.real("twist");
    const int seed = task.values.integer("seed");
    if (seed < 0)
      throw ParameterError("The seed must be 0 or more; it is " + std::to_string(seed) + ".");
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
    return {
        {"layers", parameters.phases}, {"vertices", vertices}, {"seconds", stopwatch.seconds()}};
  }
};

}  // namespace

std::unique_ptr<host::Filter> makePhantomFilter() { return std::make_unique<PhantomFilter>(); }

}  // namespace sphere_propagation
