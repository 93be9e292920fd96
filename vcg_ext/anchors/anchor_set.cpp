// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/anchors/anchor_set.h"

#include <algorithm>

namespace sphere_propagation {

AnchorSet transformed(const AnchorSet& anchors, const Eigen::Matrix4d& matrix) {
  AnchorSet moved;
  for (const auto& [name, point] : anchors)
    moved.emplace(name, (matrix * point.homogeneous()).head<3>());
  return moved;
}

void AnchorList::add(const std::string& name, const Vector3& point) {
  if (std::find(ambiguous.begin(), ambiguous.end(), name) != ambiguous.end()) return;
  const auto [there, isNew] = anchors.emplace(name, point);
  if (isNew || there->second == point) return;
  anchors.erase(there);
  ambiguous.push_back(name);
}

}  // namespace sphere_propagation
