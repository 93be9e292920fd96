// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The user's own landmarks as observations of a population: points of one name correspond.

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "vcg_ext/anchors/anchor_set.h"
#include "vcg_ext/mesh/icosphere.h"
#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

/// An anchor that a shape has, at the place that all shapes agree on.
struct PlacedAnchor {
  Vector3 direction;        ///< u, on the sphere on which the landmarks are fixed
  Eigen::Vector3i corners;  ///< the landmarks round it
  Vector3 weights;          ///< theirs, sum 1
  Vector3 point;            ///< of the surface, where the user says that it is
  double precision = 0;     ///< 1 / sd^2

  /// What landmarks have, one row each, at the anchor.
  Vector3 at(const Points& rows) const {
    return weights[0] * rows.row(corners[0]).transpose() +
           weights[1] * rows.row(corners[1]).transpose() +
           weights[2] * rows.row(corners[2]).transpose();
  }
};

/// Of each its direction, #A by 3.
Points directionsOf(const std::vector<PlacedAnchor>& anchors);

/// No shape is the root, so nobody says where on the sphere an anchor lies. Each shape that has it
/// has a place for it, phi_k^-1(P(y_k)), y_k the point of its surface; the common one is their
/// mean, which is found anew whenever landmarks have moved.
class PopulationAnchors {
 public:
  /// sets: by shape, in the frame and unit of its surface; names that one shape alone has say
  /// nothing. maps: those that begin what is optimised. deviation: of each coordinate, 0 for the
  /// mean edge length of the surface. sphere: of the landmarks. Throws ArgumentError where there
  /// are not as many sets as maps.
  PopulationAnchors(const std::vector<AnchorSet>& sets, const std::vector<MappedSurface>& maps,
                    double deviation, std::shared_ptr<const Icosphere> sphere);

  bool empty() const { return count_ == 0; }
  /// P(y_k) of the anchors that shape k has, one row each.
  const Points& directions(size_t k) const { return directions_[k]; }
  /// y_k, one row each.
  const Points& points(size_t k) const { return points_[k]; }

  /// there: phi_k^-1 of directions(k), by shape; trust: by how much a shape counts.
  std::vector<std::vector<PlacedAnchor>> placed(const std::vector<Points>& there,
                                                const Eigen::VectorXd& trust) const;

 private:
  int count_ = 0;                        // of names
  std::vector<std::vector<int>> names_;  // by shape, their numbers
  std::vector<Points> directions_, points_;
  std::vector<double> precisions_;
  std::shared_ptr<const Icosphere> sphere_;
};

}  // namespace sphere_propagation
