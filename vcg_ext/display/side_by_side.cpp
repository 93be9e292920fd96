// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/display/side_by_side.h"

#include <algorithm>
#include <cmath>

namespace sphere_propagation {
namespace {

constexpr double margin = 0.12;  // of a box's size

/// In reading order, the grid about as wide as it is high; `tall`: a cell's height over its width.
std::vector<GridCell> cellsInOrder(const std::vector<Eigen::AlignedBox3d>& boxes, double tall) {
  size_t count = 0;
  for (const Eigen::AlignedBox3d& box : boxes) count += box.isEmpty() ? 0 : 1;
  const double square = std::sqrt(static_cast<double>(count) * tall);
  const auto columns =
      static_cast<size_t>(std::clamp(std::ceil(square), 1.0, static_cast<double>(count)));
  std::vector<GridCell> cells;
  size_t cell = 0;
  for (const Eigen::AlignedBox3d& box : boxes) {
    cells.push_back({static_cast<double>(cell % columns), static_cast<double>(cell / columns)});
    if (!box.isEmpty()) ++cell;
  }
  return cells;
}

}  // namespace

Eigen::AlignedBox3d boxOf(const Points& points) {
  Eigen::AlignedBox3d box;
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    if (points.row(i).allFinite()) box.extend(Vector3(points.row(i).transpose()));
  return box;
}

std::vector<Vector3> sideBySide(const std::vector<Eigen::AlignedBox3d>& boxes,
                                const Eigen::AlignedBox3d& beside,
                                const std::vector<GridCell>& cells) {
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
  const std::vector<GridCell> taken = cells.empty() ? cellsInOrder(boxes, high / wide) : cells;
  double columns = 0, rows = 0;
  for (size_t i = 0; i < boxes.size(); ++i) {
    if (boxes[i].isEmpty()) continue;
    columns = std::max(columns, taken[i].column + 1);
    rows = std::max(rows, taken[i].row + 1);
  }
  const Eigen::AlignedBox3d& around = beside.isEmpty() ? all : beside;
  const double left = beside.isEmpty() ? around.center().x() - 0.5 * wide * columns
                                       : around.max().x() + margin * std::max(largest.x(), least);
  const double top = around.center().y() + 0.5 * high * rows;
  for (size_t i = 0; i < boxes.size(); ++i) {
    if (boxes[i].isEmpty()) continue;
    const Vector3 place(left + wide * (taken[i].column + 0.5), top - high * (taken[i].row + 0.5),
                        around.center().z());
    moves[i] = place - boxes[i].center();
  }
  return moves;
}

}  // namespace sphere_propagation
