// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Slices that do not meet, as after another breath, and how far each has to be moved back.

#include <vector>

#include "vcg_ext/volume/grid.h"
#include "vcg_ext/volume/slice_places.h"

namespace sphere_propagation {

/// A slice that is to be moved in its plane.
struct SliceShift {
  int slice = 0;                                     ///< z
  Eigen::Vector2i voxels = Eigen::Vector2i::Zero();  ///< along x, y; to be added to what is there
  bool alone = false;  ///< whether the slice hardly meets the slices beside it
};

/// What is to be done with the slices of a phase.
struct PhaseAlignment {
  std::vector<SliceShift> shifts;  ///< those that stay left out
  std::vector<int>
      apart;         ///< z of slices that lie otherwise here than in the other phases, against
                     ///< those beside them; what shifts say of them is this phase's alone
  int sequence = 0;  ///< phases of different numbers do not belong together
};

/// How the slices of phases are to be moved so that their stacks are smooth: a slice was acquired
/// once for all phases, and so it is moved alike in all of them. Phases share the grid's axes and
/// spacing, and count slices and voxels alike.
///
/// **What belongs together**: a phase joins those before whose slices it overlaps (by two fifths)
/// and whose steps from slice to slice it has but for a bend (by the median slice they differ by
/// less than 3.5 mm or 2.5 voxels from those beside it). Others, as another patient's, are a
/// sequence of their own.
///
/// **Where slices lie**: the step from each to the next is the mean of the phases that have both,
/// wild ones left out; how the phases vary is its deviation, which is large where outlines change
/// (as the end of an organ comes and goes) and a step says little. It says nothing where the
/// outlines fit nowhere (a misfit of more than a tenth), as where the arch of a vertebra begins.
///
/// **Where they should lie**: on a line c whose third differences are small, so that a bend costs
/// nothing (P. H. C. Eilers, A perfect smoother, Analytical Chemistry 75, 2003; those at the ends,
/// where organs bend most, count a third). Slice s lies u_s off it: normal with a common deviation,
/// but for few slices with a large one. The common deviation and these slices are those of most
/// evidence (the likelihood with c and u integrated out; slices taken one by one), so what a bend
/// may explain is none. If the common deviation is small (below `roughness`) and few slices stand
/// out (a fifth), these alone are moved, by at least `least` or 1.5 voxels. Else the whole stack is
/// rough, as when every slice has its own breath: then each is moved towards a trend, which is c
/// by Tukey's weights with a smoothness that follows from the noise of third differences, by no
/// more than to the middle of the slices beside it. Slices that hardly meet those beside them in
/// most phases have no weight in either.
///
/// The first and the last slice (of most phases) are moved only where they hardly meet the next:
/// nothing else tells a shift from a bend. Slices next to them stand out only by more than the
/// first or last one lies off the straight line through the third and fourth: else that one may be
/// what bends away. A slow drift over the stack is a bend, too, and stays.
///
/// spacing: along x, y, z, mm. Fewer than three slices with a label, or slices close to each other,
/// tell nothing.
std::vector<PhaseAlignment> alignSlices(const std::vector<std::vector<SlicePlace>>& phases,
                                        const Vector3& spacing);

/// Of one phase. Wants slices whose border is outside.
std::vector<SliceShift> findSliceShifts(const Mask& mask, const Vector3& spacing);

/// In mm, for alignSlices.
struct SliceAlignmentLimits {
  static constexpr double roughness = 1.4;
  static constexpr double least = 2;
};

/// Moves slices; the mask grows by what it takes for its border to stay as wide as it was. Returns
/// by how many voxels it grew at the low end of x and y.
Eigen::Vector2i moveSlices(Mask& mask, const std::vector<SliceShift>& shifts);

}  // namespace sphere_propagation
