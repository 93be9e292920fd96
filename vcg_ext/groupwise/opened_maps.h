// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Maps that landmarks can follow: what lies squeezed on the sphere is opened before a population
/// is optimised together.

#include <vector>

#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/sphere/mapped_surface.h"

namespace sphere_propagation {

struct OpenedMap {
  MappedSurface map;
  MappedSurface pockets;  ///< opened no further than where pockets alone are lost
  double squeezed = 0;    ///< share of the surface that was, on the map that came
};

/// Propagation loses parts of surfaces: a pocket that the parent shows otherwise ends as a crack of
/// the sphere, where a hundredth of the surface has a ten-thousandth of the solid angle. A landmark
/// that is to move by a width of the crack crosses all of the pocket, and ends centimetres from
/// where it is expected, since no field of a width that others have is so fine. So faces get,
/// within bounds, what is their share of the sphere (boundAreas of area_restoration.h).
///
/// Squeezed is what has less than a third of its share. Up to a twentieth of the surface, faces are
/// brought within a factor of three of theirs; maps that squeeze more have lost more than pockets,
/// and their bound falls, until at 15 % all areas are restored. Maps that squeeze up to half a
/// percent come back bit for bit, and from there to a percent the bound comes down from infinity,
/// so that nothing begins with a jump. Where even the best map of the population squeezes more than
/// a hundredth, as all do whose root had no even areas, the factor is what that map needs in place
/// of three: what all have in common is no loss. Whether a map is better for it, the others tell
/// (groupwise.cpp).
std::vector<OpenedMap> openedMaps(const std::vector<MappedSurface>& maps, ThreadPool& pool);

}  // namespace sphere_propagation
