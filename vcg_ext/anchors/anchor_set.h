// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The user's own landmarks on one surface: points with names. Those of one name, on several
/// surfaces, are to correspond.

#include <Eigen/Geometry>
#include <map>
#include <string>
#include <vector>

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

/// By name, in the order of the names' bytes, which every surface has in common; in the unit of the
/// surface's vertices, finite.
using AnchorSet = std::map<std::string, Vector3>;

/// The same in another frame. matrix: affine.
AnchorSet transformed(const AnchorSet& anchors, const Eigen::Matrix4d& matrix);

/// What a file says.
struct AnchorList {
  AnchorSet anchors;
  std::vector<std::string> undefined;  ///< names without a place, as files of templates have them
  /// Names that stand there twice, with different places: no anchors, as nobody knows which is
  /// meant.
  std::vector<std::string> ambiguous;
  bool fromLps = false;  ///< x and y were turned round, as the file is in LPS

  /// Takes a point in; one that stands there already makes its name ambiguous, unless it is the
  /// same.
  void add(const std::string& name, const Vector3& point);
};

}  // namespace sphere_propagation
