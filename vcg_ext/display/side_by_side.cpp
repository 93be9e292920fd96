// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/display/side_by_side.h"

#include <algorithm>
#include <cmath>

namespace sphere_propagation {
namespace {

constexpr double margin = 0.12;  // of a box's size

}  // namespace

Eigen::AlignedBox3d boxOf(const Points& points) {
  Eigen::AlignedBox3d box;
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    if (points.row(i).allFinite()) box.extend(Vector3(points.row(i).transpose()));
  return box;
}

std::vector<Vector3> sideBySide(const std::vector<Eigen::AlignedBox3d>& boxes,
                                const Eigen::AlignedBox3d& beside) {
  Eigen::AlignedBox3d all;
  Vector3 largest = Vector3::Zero();
  size_t count = 0;
  for (const Eigen::AlignedBox3d& box : boxes) {
    if (box.isEmpty()) continue;
    all.extend(box);
    largest = largest.cwiseMax(box.sizes());
    ++count;
  }
  std::vector<Vector3> moves(boxes.size(), Vector3::Zero());
  if (count == 0) return moves;
  // A flat box in one direction (a line, a point) still takes a cell.
  const double least = std::max(1e-3 * largest.maxCoeff(), 1e-300);
  const double wide = (1 + margin) * std::max(largest.x(), least),
               high = (1 + margin) * std::max(largest.y(), least);
  const double square = std::sqrt(static_cast<double>(count) * high / wide);
  const auto columns =
      static_cast<size_t>(std::clamp(std::ceil(square), 1.0, static_cast<double>(count)));
  const size_t rows = (count + columns - 1) / columns;
  const Eigen::AlignedBox3d& around = beside.isEmpty() ? all : beside;
  const double left = beside.isEmpty()
                          ? around.center().x() - 0.5 * wide * static_cast<double>(columns)
                          : around.max().x() + margin * std::max(largest.x(), least);
  const double top = around.center().y() + 0.5 * high * static_cast<double>(rows);
  size_t cell = 0;
  for (size_t i = 0; i < boxes.size(); ++i) {
    if (boxes[i].isEmpty()) continue;
    const Vector3 place(left + wide * (static_cast<double>(cell % columns) + 0.5),
                        top - high * (static_cast<double>(cell / columns) + 0.5),
                        around.center().z());
    moves[i] = place - boxes[i].center();
    ++cell;
  }
  return moves;
}

}  // namespace sphere_propagation
