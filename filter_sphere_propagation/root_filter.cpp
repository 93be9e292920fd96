// SPDX-License-Identifier: GPL-3.0-only
// "Spherical parameterise root": the current layer gets an area-preserving map to the unit sphere.

#include "filter_sphere_propagation/filters.h"
#include "filter_sphere_propagation/largest_layer.h"
#include "filter_sphere_propagation/reporting.h"
#include "vcg_ext/mesh/sphere_fit.h"
#include "vcg_ext/root_map/root_map.h"

namespace sphere_propagation {
namespace {

class RootFilter : public host::Filter {
 public:
  host::FilterDescription describe() const override {
    return {
        "Spherical parameterise root", "compute_spherical_parameterisation_root",
        "Maps the current layer, a closed surface without handles, to the unit sphere so that "
        "areas are preserved: every part of the surface gets its share of the sphere. The map is "
        "<b>certified valid</b>: no face is flipped, and the sphere is covered once. It is stored "
        "on the layer as the per-vertex attribute <i>sphere_position</i> (unit vectors) and as "
        "per-vertex texture coordinates (u = longitude / 2 pi, v = colatitude / pi), which PLY "
        "files keep.<br><br>This is the first of three steps; \"Propagate parameterisation to "
        "layers\" and \"Remesh by icosphere\" follow. For a heart cycle, end-diastole (the layer "
        "of largest volume) is a good root.<br><br>Returned: " +
            mapFiguresInfo() + "<br><br>" + paperReference() +
            "From coarse to fine:<br><i>Emil Praun and Hugues Hoppe</i><br><b>\"Spherical "
            "parametrization and remeshing\"</b><br>ACM Transactions on Graphics 22(3), "
            "2003.<br><i>Xin Hu, Xiao-Ming Fu and Ligang Liu</i><br><b>\"Advanced hierarchical "
            "spherical parameterizations\"</b><br>IEEE Transactions on Visualization and Computer "
            "Graphics 24(6), 2018.<br>Other initial maps:<br><i>Christian Brechb&uuml;hler, Guido "
            "Gerig and Olaf K&uuml;bler</i><br><b>\"Parametrization of closed surfaces for 3-D "
            "shape description\"</b><br>Computer Vision and Image Understanding 61(2), "
            "1995.<br><i>Steven Haker, Sigurd Angenent, Allen Tannenbaum, Ron Kikinis, Guillermo "
            "Sapiro and Michael Halle</i><br><b>\"Conformal surface parameterization for texture "
            "mapping\"</b><br>IEEE Transactions on Visualization and Computer Graphics 6(2), 2000.",
        host::Menu::Remeshing | host::Menu::Layer, host::Arity::CurrentLayer};
  }

  std::vector<host::Parameter> parameters(const host::Layers& layers) const override {
    return {
        host::Parameter{"initial_map", "Initial map",
                        "Where the minimisation of area distortion starts. Automatic: from coarse "
                        "to fine, which works for every shape. Brechbuehler: colatitude and "
                        "longitude by diffusion between two poles, the ends of the shape's first "
                        "principal axis, as in the paper. Harmonic: the harmonic map (cotangent "
                        "Laplace). The result is much the same. Where the one chosen cannot be "
                        "made valid, the map is made from coarse to fine, and the log says so.",
                        host::Parameter::Choice{{"Automatic", "Brechbuehler", "Harmonic"}, 0}}
            .withNote(sizeNote(layers)),
        {"area_weight", "Area weight",
         "0 to 1. 1 asks for equal areas alone, as far as validity allows; 0 for angles alone. The "
         "default all but preserves areas and spends the freedom that is left on angles.",
         RootMapParameters{}.areaWeight},
        host::Parameter{"threads", "Threads",
                        "How many threads work on large meshes; 0: as many as the machine runs at "
                        "once. The map is the same with any number.",
                        RootMapParameters{}.threads}
            .asAdvanced()};
  }

  host::Outputs run(host::Task& task) const override {
    const Stopwatch stopwatch;
    RootMapParameters parameters;
    parameters.initialMap = static_cast<InitialMap>(task.values.choice("initial_map"));
    parameters.areaWeight = task.values.real("area_weight");
    parameters.threads = task.values.integer("threads");
    const host::Layer layer = task.layers.current();
    const MeshSurface mesh = layer.surface();
    const RootMapResult result =
        makeRootMap(mesh.surface, parameters, part(task.progress, 0, 0.95));
    const std::string storageNote = task.changes.setMap(layer, mesh, result.map);
    const MapMeasures measures = measureMap(mesh.surface, result.map.positions());
    if (!result.note.empty()) task.log(result.note);
    if (!storageNote.empty()) task.log(storageNote);
    const double seconds = stopwatch.seconds();
    if (const std::string note = sizeNote(task.layers); !note.empty())
      task.log("Note: " + note + ".");
    if (const std::string note = sphereNote(layer, mesh.surface); !note.empty()) task.log(note);
    task.log(describeMap(layer.label(), mesh.surface, measures) + ", " + shortNumber(seconds) +
             " s (" + nameOf(result.used) + " start, " + counted(result.levels, "level", "levels") +
             ", " + counted(result.steps, "step", "steps") + ")");
    return {{"flipped_faces", static_cast<int>(measures.certificate.flippedFaces)},
            {"area_ratio_sd", measures.areaRatioSd},
            {"area_log_mean", measures.areaLogMean},
            {"angle_error_mean", measures.angleErrorMean},
            {"seconds", seconds}};
  }

 private:
  /// A sphere looks the same from all sides.
  static std::string sphereNote(const host::Layer& layer, const ClosedSurface& surface) {
    constexpr double round = 1e-4;
    if (layer.kind() == host::LayerKind::Sphere)
      return "Note: layer \"" + layer.label() +
             "\" lies on the unit sphere, so the other filters take it for one that \"Show "
             "parameterisation as sphere layers\" made, and leave it out. Where it is a surface, "
             "scale it.";
    if (deviationFromSphere(surface.vertices()) > round) return {};
    return "Note: layer \"" + layer.label() +
           "\" is itself a sphere: any rotation of its map is as good, and nothing tells how other "
           "spheres are to be turned to match it.";
  }

  static std::string sizeNote(const host::Layers& layers) {
    const int current = layers.currentId();
    const std::string note = LargestLayer(layers.visible(host::LayerKind::Surface)).note(current);
    return note.empty()
               ? note
               : "the current layer is " + std::to_string(current) + "; for a heart cycle, " + note;
  }
};

}  // namespace

std::unique_ptr<host::Filter> makeRootFilter() { return std::make_unique<RootFilter>(); }

}  // namespace sphere_propagation
