// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// PLY files, as far as the benchmarks need them.

#include <string>

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation::benchmark {

struct PlyMesh {
  Points vertices;
  Triangles faces;
  Points map;  ///< properties px, py, pz (unit vectors); no rows where the file has none
};

/// A binary little-endian PLY file of triangles. Throws std::runtime_error when it is something
/// else.
PlyMesh readPly(const std::string& path);

/// Writes coordinates as float (`map`, where it has rows, as double px, py, pz).
void writePly(const std::string& path, const PlyMesh& mesh);

}  // namespace sphere_propagation::benchmark
