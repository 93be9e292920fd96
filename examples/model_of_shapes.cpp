// SPDX-License-Identifier: GPL-3.0-only
/// Corresponding landmarks to a statistical shape model: model_of_shapes MODEL LANDMARKS...
///
/// LANDMARKS are meshes with one face list, as landmarks_of_sequence writes them. The ending of
/// MODEL chooses the format: .npz, .h5, .json, .particles, .ply or .csv.

#include <cstdlib>
#include <exception>
#include <iostream>

#include "mesh_file.h"
#include "vcg_ext/model/export/model_export.h"
#include "vcg_ext/model/procrustes.h"
#include "vcg_ext/model/shape_model.h"

using namespace sphere_propagation;

int main(int count, char** argument) try {
  if (count < 4) {
    std::cerr << "usage: model_of_shapes MODEL LANDMARKS LANDMARKS...\n";
    return 2;
  }
  std::vector<TrainingSet::Shape> shapes;
  Triangles faces;
  for (int i = 2; i < count; ++i) {
    const ClosedSurface surface = example::readSurface(argument[i]);
    shapes.push_back({surface.name(), surface.vertices()});
    faces = surface.faces();
  }
  const Aligned aligned = alignShapes(TrainingSet(shapes, faces));
  const ShapeModel model = buildShapeModel(aligned.shapes);

  for (Eigen::Index mode = 0; mode < model.modeCount(); ++mode)
    std::cout << "mode " << mode + 1 << ": " << 100 * model.eigenvalues[mode] / model.totalVariance
              << " % of the variance\n";
  exportModel(argument[1], model, aligned.shapes);
  return EXIT_SUCCESS;
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return EXIT_FAILURE;
}
