// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Landmarks that move along a surface by flows of the sphere, and the map that follows them.

#include <memory>
#include <vector>

#include "vcg_ext/groupwise/sphere_fields.h"
#include "vcg_ext/groupwise/surface_landmarks.h"
#include "vcg_ext/mesh/icosphere.h"

namespace sphere_propagation {

struct FollowedMap {
  MappedSurface map;
  int repairedFaces = 0;  ///< faces that were flipped before the repair
  double share = 1;       ///< of the flows that the map could follow: 1, 0.75, 0.5, 0.25 or 0
};

/// Where else than at the landmarks a field is asked for a displacement.
struct Pulls {
  Points directions = Points(0, 3);     ///< #A by 3: phi(u)
  Points displacements = Points(0, 3);  ///< #A by 3, as the landmarks' are
  Eigen::VectorXd weights;
};

/// One surface with a map P, and phi, a composition of flows on the sphere: landmark j is the point
/// that P sends to phi(u_j), u_j a vertex of an icosphere. phi is a diffeomorphism, so the map
/// phi^-1 after P is one that sends landmark j to u_j.
class MovingLandmarks {
 public:
  /// sphere: the u_j, shared by all surfaces of a population.
  MovingLandmarks(const MappedSurface& surface, std::shared_ptr<const Icosphere> sphere);

  const MappedSurface& surface() const { return surface_; }  ///< with P
  const SurfaceLandmarks& landmarks() const { return landmarks_; }
  const Points& directions() const { return directions_; }  ///< phi(u_j)

  /// The field that moves landmarks along the surface as near to these displacements as it can:
  /// least squares with weights, plus `damping` times the field's norm (both by their traces).
  /// turn: what displacements are seen through, that of the shape's alignment; displacements: #N by
  /// 3; weights: #N; pulls: elsewhere.
  Eigen::VectorXd fieldFor(const SphereFields& fields, const Eigen::Matrix3d& turn,
                           const Points& displacements, const Eigen::VectorXd& weights,
                           double damping, const Pulls& pulls = {});

  /// phi of points on the sphere, #P by 3, and phi^-1 of them, or the inverse of this share of
  /// each of its flows.
  Points followed(Points points) const;
  Points undone(Points points, double share = 1) const;
  /// The points of the surface that P sends to these directions.
  Points read(const Points& directions) { return reader_.read(directions).points; }

  /// phi becomes the flow of the field after phi, or a part of it where the icosphere's faces would
  /// not stay oriented. The field is scaled so that no landmark moves farther than `longest`
  /// (radian) at first. The fields must live as long as this object is asked for maps.
  void move(std::shared_ptr<const SphereFields> fields, Eigen::VectorXd theta, double longest);

  /// phi^-1 after P, at the surface's vertices; what flips is relocated (relocation.h), or else
  /// untangled locally (untangling.h), which lays more of the surface anew. Where that does
  /// not end in a valid map, because faces are too large to follow, only a part of each flow is
  /// gone; with none of it the map is P.
  FollowedMap map() const;

 private:
  struct Step {
    std::shared_ptr<const SphereFields> fields;
    Eigen::VectorXd theta;
  };

  std::shared_ptr<const Icosphere> sphere_;
  MappedSurface surface_;
  LandmarkReader reader_;
  Points directions_;
  SurfaceLandmarks landmarks_;
  std::vector<Step> steps_;
};

}  // namespace sphere_propagation
