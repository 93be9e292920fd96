// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Landmarks that are points with a name: the users' own.

#include <map>
#include <string>
#include <vector>

#include "vcg_ext/model/training_set.h"

namespace sphere_propagation {

/// The landmarks that lie where points with a name lie, on a shape at least, to 1e-5 of the
/// shape's diagonal; a name that would be two landmarks is none. For maps that were moved until
/// anchors are landmarks (snapMap): held exactly, they are so on every shape, else on the root's.
///
/// points: of each shape, by name; as many as there are shapes, in the frame of its landmarks.
/// Throws ArgumentError where there are more or fewer.
std::map<std::string, Eigen::Index> namedLandmarks(
    const TrainingSet& shapes, const std::vector<std::map<std::string, Vector3>>& points);

}  // namespace sphere_propagation
