// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/morphing/morph_path.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace sphere_propagation {
namespace {

/// Second derivatives of the cardinal splines at the shapes: entry (i, k) at time i of that of k.
/// C. de Boor, A practical guide to splines, 1978, chapter 4.
Eigen::MatrixXd bends(bool closed, int count) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(count, count), differences = matrix;
  for (int i = 0; i < count; ++i) {
    if (!closed && (i == 0 || i + 1 == count)) {
      matrix(i, i) = 1;
      continue;
    }
    const int before = (i + count - 1) % count, after = (i + 1) % count;
    matrix(i, i) += 4;
    matrix(i, before) += 1;
    matrix(i, after) += 1;
    differences(i, i) -= 12;
    differences(i, before) += 6;
    differences(i, after) += 6;
  }
  return matrix.partialPivLu().solve(differences);
}

}  // namespace

Eigen::VectorXd pathWeights(MorphPath path, bool closed, int count, double time) {
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(count);
  const int intervals = closed ? count : count - 1;
  const int from = std::clamp(static_cast<int>(std::floor(time)), 0, std::max(0, intervals - 1)),
            to = (from + 1) % count;
  const double right = time - from, left = 1 - right;
  weights[from] += left;
  weights[to] += right;
  if (path == MorphPath::ShapeModel && count > 2) {
    const Eigen::MatrixXd bend = bends(closed, count);
    weights += (((left * left * left - left) * bend.row(from) +
                 (right * right * right - right) * bend.row(to)) /
                6)
                   .transpose();
  }
  return weights;
}

}  // namespace sphere_propagation
