// SPDX-License-Identifier: GPL-3.0-only
/// A mesh file to its map: map_of_mesh SURFACE SPHERE.off
///
/// Gives a closed surface an area-preserving map to the unit sphere, says how good it is, and
/// writes the sphere: vertex v of it is where the map sends vertex v of the surface.

#include <cstdlib>
#include <exception>
#include <iostream>

#include "mesh_file.h"
#include "vcg_ext/root_map/root_map.h"
#include "vcg_ext/sphere/map_measures.h"

using namespace sphere_propagation;

int main(int count, char** argument) try {
  if (count != 3) {
    std::cerr << "usage: map_of_mesh SURFACE SPHERE.off\n";
    return 2;
  }
  const ClosedSurface surface = example::readSurface(argument[1]);
  const MappedSurface mapped = makeRootMap(surface).map;

  const MapMeasures measures = measureMap(surface, mapped.positions());
  std::cout << surface.vertexCount() << " vertices, standard deviation of the area ratio "
            << measures.areaRatioSd << ", mean angle error " << measures.angleErrorMean
            << " degrees\n";
  example::writeOff(argument[2], mapped.positions(), mapped.faces());
  return EXIT_SUCCESS;
} catch (const std::exception& error) {  // whatever the library throws names the surface
  std::cerr << error.what() << '\n';
  return EXIT_FAILURE;
}
