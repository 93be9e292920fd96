// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// What the benchmarks measure time by.

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation::benchmark {

/// Of the whole process, all threads.
double cpuSeconds();

/// The unit u: one Eigen SimplicialLDLT, analyse and factorise, of the mesh's cotangent Laplacian.
/// Best of five.
double unitSeconds(const Points& vertices, const Triangles& faces);

}  // namespace sphere_propagation::benchmark
