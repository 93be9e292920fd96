// SPDX-License-Identifier: GPL-3.0-only
/// A sequence of surfaces to corresponding landmarks: landmarks_of_sequence FOLDER SURFACE...
///
/// The surfaces are the phases of one cycle, in order. The first gets a map, which is propagated to
/// all others; the icosphere then samples each. Vertex j of every FOLDER/landmarks_I.off is the
/// same place.

#include <cstdlib>
#include <exception>
#include <iostream>

#include "mesh_file.h"
#include "vcg_ext/propagation/propagation.h"
#include "vcg_ext/remeshing/icosphere_remesher.h"
#include "vcg_ext/root_map/root_map.h"

using namespace sphere_propagation;

int main(int count, char** argument) try {
  if (count < 4) {
    std::cerr << "usage: landmarks_of_sequence FOLDER SURFACE SURFACE...\n";
    return 2;
  }
  std::vector<ClosedSurface> surfaces;
  for (int i = 2; i < count; ++i) surfaces.push_back(example::readSurface(argument[i]));
  const Sequence sequence(surfaces);

  const int root = 0;
  const MappedSurface rootMap = makeRootMap(sequence.surface(root)).map;
  const PropagationTree tree = cyclicTimeOrder(sequence.size(), root);
  const Propagation propagation = propagate(sequence, rootMap, tree);

  const IcosphereRemesher remesher(10);  // 10 f^2 + 2 = 1002 landmarks
  for (int i = 0; i < sequence.size(); ++i) {
    const MappedSurface& mapped = propagation.layers[static_cast<size_t>(i)].map();
    const Remeshed remeshed = remesher.remesh(mapped);
    std::cout << sequence.name(i) << ": landmarks within "
              << remesher.distance(remeshed, mapped).max << " of the surface\n";
    example::writeOff(std::string(argument[1]) + "/landmarks_" + std::to_string(i) + ".off",
                      remeshed.landmarks, remesher.sphere().faces);
  }
  return EXIT_SUCCESS;
} catch (const std::exception& error) {  // whatever the library throws names the surface
  std::cerr << error.what() << '\n';
  return EXIT_FAILURE;
}
