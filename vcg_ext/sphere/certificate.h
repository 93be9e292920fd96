// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The proof that positions on the unit sphere are a valid spherical parameterisation, or the
/// reason why not.
///
/// It is what the word "valid" and the count "flipped faces" mean everywhere in this project. It
/// shares no code with the algorithms that make maps: its geometry is its own, and the orientation
/// of a face is decided exactly (a floating-point filter, then wide integers).
///
/// Why this suffices: if all faces of a closed surface of genus 0 are positively oriented, the map
/// that sends each face to its spherical triangle is a branched covering of the sphere; degree 1
/// leaves no branch and one sheet, so it is one to one.

#include <string>

#include "vcg_ext/base/matrices.h"

namespace sphere_propagation {

struct Certificate {
  /// How far from 1 the length of a stored position may be: that of unit vectors stored as float,
  /// and some.
  static constexpr double unitTolerance = 1e-6;
  /// The smallest solid angle (steradian) of a face of a valid map. Below it a face cannot be told
  /// from a point.
  static constexpr double minSolidAngle = 1e-14;

  long notOnSphere = 0;        ///< positions that are not finite or not of unit length
  long firstNotOnSphere = -1;  ///< vertex index
  long flippedFaces =
      0;  ///< faces not positively oriented, or of a solid angle below minSolidAngle
  long firstFlippedFace = -1;  ///< face index
  double degree =
      0;  ///< sum of the signed solid angles / 4 pi: how often the map covers the sphere

  bool valid() const;
  /// Why the map is not valid, for the user; empty if it is.
  std::string reason() const;
};

/// Certifies the map that sends vertex v of the closed surface with these faces to
/// positions.row(v). faces: #F by 3; positions: #V by 3, as they are stored (a host that stores
/// float passes the floats).
Certificate certify(const Triangles& faces, const Points& positions);

}  // namespace sphere_propagation
