// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// How far a map is from area-preserving and from angle-preserving, in figures that can be
/// published.

#include "vcg_ext/mesh/closed_surface.h"
#include "vcg_ext/sphere/certificate.h"

namespace sphere_propagation {

/// With s_f the share of face f in the sphere and a_f its share in the surface, the area ratio of f
/// is s_f / a_f. Faces smaller than minFaceShare of the mean area count for the certificate only:
/// no ratio or angle means anything there.
struct MapMeasures {
  Certificate certificate;
  double areaRatioSd = 0;  ///< standard deviation of the area ratio; 0 = area-preserving
  double areaLogMean = 0;  ///< mean |ln(area ratio)|, ratios below 1e-12 taken as 1e-12
  double angleErrorMean =
      0;  ///< mean |corner angle on the sphere (flat triangle) - corner angle on the mesh|, degrees
};

/// Measures any positions, valid or not. positions: #V by 3 unit vectors.
MapMeasures measureMap(const ClosedSurface& surface, const Points& positions);

/// The area ratio of each face, #F; 1 for faces too small for one.
Eigen::VectorXd areaRatios(const ClosedSurface& surface, const Points& positions);

/// The area ratio of the faces around each vertex taken together, #V; 1 where they are too small
/// for one.
Eigen::VectorXd vertexAreaRatios(const ClosedSurface& surface, const Points& positions);

}  // namespace sphere_propagation
