// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// What a surface must be, beyond a sphere topologically, so that figures mean something: neither
/// flat nor so large or so small that products of lengths leave the range of numbers. A root map
/// can be made of either; lengths, areas and alignment of several surfaces cannot be computed.

#include <string>

#include "vcg_ext/mesh/closed_surface.h"

namespace sphere_propagation {

/// The largest coordinate and the smallest extent. Squares of areas are fourth powers of lengths:
/// these are numbers from 1e-77 to 1e77, and details a good deal smaller than the extent must be,
/// too.
constexpr double maxCoordinate = 1e50, minExtent = 1e-50;

/// The smallest share of the largest extent, both along principal axes, that makes a surface solid:
/// float matrices that flatten leave about 1e-7.
constexpr double minThickness = 1e-6;

/// The smallest share of the mean area that makes the area of a face something to aim at: below it
/// are slivers, whose areas are rounding. Where areas must be reached or are divided by, such faces
/// count as that large or not at all.
constexpr double minFaceShare = 1e-5;

/// Throws SurfaceError: Flat, CoordinateTooLarge or ExtentTooSmall.
void requireUsableExtent(const ClosedSurface& surface);

/// The same of points that are finite, at least one. name: what errors call them.
void requireUsableExtent(const Points& vertices, const std::string& name);

}  // namespace sphere_propagation
