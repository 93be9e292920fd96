// SPDX-License-Identifier: GPL-3.0-only
#include "benchmarks/timing.h"

#include <ctime>

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <limits>
#include <tuple>
#include <vector>

namespace sphere_propagation::benchmark {

double cpuSeconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double unitSeconds(const Points& vertices, const Triangles& faces) {
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = faces(f, (k + 1) % 3), b = faces(f, (k + 2) % 3), c = faces(f, k);
      const Vector3 p = (vertices.row(a) - vertices.row(c)).transpose(),
                    q = (vertices.row(b) - vertices.row(c)).transpose();
      const double w =
          0.5 * std::clamp(p.dot(q) / std::max(1e-300, p.cross(q).norm()), -0.5, 20.0) + 1e-3;
      for (const auto& [i, j, sign] :
           {std::tuple{a, b, -1}, std::tuple{b, a, -1}, std::tuple{a, a, 1}, std::tuple{b, b, 1}})
        entries.emplace_back(i, j, sign * w);
    }
  for (int i = 0; i < static_cast<int>(vertices.rows()); ++i) entries.emplace_back(i, i, 1e-3);
  Eigen::SparseMatrix<double> laplacian(vertices.rows(), vertices.rows());
  laplacian.setFromTriplets(entries.begin(), entries.end());
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 5; ++i) {
    const double start = cpuSeconds();
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(laplacian);
    best = std::min(best, cpuSeconds() - start);
  }
  return best;
}

}  // namespace sphere_propagation::benchmark
