// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Parts, cavities and handles of binary images, and their removal.
///
/// Inside voxels are connected through faces, outside ones through faces and edges; see
/// simple_point.h. Every function wants a mask whose border is outside (one voxel suffices) and
/// throws ParameterError for another.

#include "vcg_ext/base/progress.h"
#include "vcg_ext/volume/grid.h"

namespace sphere_propagation {

/// What was dropped with the smaller parts.
struct DroppedParts {
  long parts = 0;   ///< how many
  long voxels = 0;  ///< how many they had together
};

/// Keeps the part with the most voxels (of equal ones that of the smallest index).
DroppedParts keepLargestPart(Mask& mask);

/// Fills what the mask encloses completely. Returns the number of voxels filled.
long fillCavities(Mask& mask);

/// The Euler characteristic of the surface of the mask (that of marchingCubes with
/// FaceRule::SeparateInside): the sum over its components of 2 - 2 genus.
long surfaceEulerCharacteristic(const Mask& mask);

/// How handles are removed; LessChange: whichever of the two changes fewer voxels, cutting when
/// equal.
enum class HandleRepair { LessChange, Cut, Fill };

/// What removeHandles did.
struct RemovedHandles {
  enum class By { Nothing, Cutting, Filling };
  By by = By::Nothing;
  long handles = 0;  ///< that the mask had, its cavities filled
  long changedVoxels = 0;
};

/// Ways to make every part of a mask a ball in the sense of topology.
struct HandleRemoval {
  long handles = 0;                 ///< as in RemovedHandles
  bool needed = false;              ///< whether there are handles or cavities at all
  bool canFill = false;             ///< whether there is one part only
  std::vector<size_t> cut, filled;  ///< indices of the voxels that each way changes, ascending

  /// The way that is taken where this mask is alone: Cut, where filling is not possible.
  HandleRepair chosen(HandleRepair wanted) const;
  /// Changes the mask that this was found for; wanted: Cut or Fill.
  RemovedHandles apply(Mask& mask, HandleRepair wanted) const;
};

/// Whether a mask has handles or cavities.
bool needsHandleRemoval(const Mask& mask);

/// Fronts of simple points: from the deepest voxel of each part outwards, deepest first, as far as
/// the mask goes, which cuts the handles where they are thinnest; and, for one part, from a box
/// round it inwards, farthest first, as far as the mask allows, which fills them by membranes. The
/// topology of a front never changes, so the result has that of the seed: no handles, no cavities,
/// as many parts as before. S. Bischoff and L. Kobbelt, Isosurface reconstruction with topology
/// control, Pacific Graphics 2002; X. Han, C. Xu and J. L. Prince, A topology preserving level set
/// method for geometric deformable models, 2003.
///
/// depth: one value per voxel, the larger the deeper inside (a signed distance; or one that several
/// masks have in common, so that their handles are cut and filled at the same places). wanted: only
/// the ways that this asks for are tried. cutDepth: another depth for the front that cuts; empty:
/// the same.
HandleRemoval findHandleRemoval(const Mask& mask, const std::vector<float>& depth,
                                HandleRepair wanted = HandleRepair::LessChange,
                                const Progress& progress = {},
                                const std::vector<float>& cutDepth = {});

/// Makes every part of the mask a ball by findHandleRemoval; the number of parts stays. A mask that
/// is so already is not touched. Several parts are cut, whatever is wanted.
RemovedHandles removeHandles(Mask& mask, const std::vector<float>& depth,
                             HandleRepair wanted = HandleRepair::LessChange,
                             const Progress& progress = {});

/// The voxels of a list in groups that hang together through faces, edges and corners; the largest
/// group first, of equal ones that of the smallest index.
std::vector<std::vector<size_t>> groupsOf(const Eigen::Vector3i& size,
                                          const std::vector<size_t>& voxels);

/// Moves the mask towards the voxels with a positive value, by simple points only, each voxel at
/// most once and only where it was simple to begin with: the topology stays, and what is one voxel
/// thin is not eaten up from its rim. values: one per voxel; the largest in size move first.
void moveBySimplePoints(Mask& mask, const std::vector<float>& values);

}  // namespace sphere_propagation
