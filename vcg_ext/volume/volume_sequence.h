// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// From the labels of many phases to a surface each, their slices aligned and their handles removed
/// alike.

#include <exception>
#include <optional>
#include <vector>

#include "vcg_ext/volume/common_depth.h"
#include "vcg_ext/volume/volume_surface.h"

namespace sphere_propagation {

/// volumeSurface of every phase, with two differences.
///
/// Where slices are looked at (they lie far apart, or alignSlices is asked for) and phases lie on
/// the same grid (spacing and axes; their slices at the same places), how slices are to be moved is
/// decided for all phases together (alignSlices).
///
/// Where phases have handles and lie on the same grid, these are cut in all of them or filled in
/// all of them, at the same places, for the phases' surfaces are to correspond. The places are
/// chosen by what the phases have in common (CommonDepth, of all phases, those without handles
/// too), and cuts by what that cuts in the union of those with handles: a phase that is thin
/// elsewhere is cut there all the same. LessChange is decided by the sum over the phases.
///
/// Phases with slices to be looked at or with handles are kept until all were added; where they
/// take more than `maxKept` samples, those added so far are decided by themselves.
class VolumeSequence {
 public:
  static constexpr size_t maxKept = 400'000'000;

  explicit VolumeSequence(VolumeSurfaceParameters parameters);

  /// Throws what volumeSurface throws, and then the phase counts for nothing; but what is wrong
  /// with a phase whose slices are looked at may show only when its surface is asked for.
  void add(const LabelGrid& labels, const Progress& progress = {});
  size_t phases() const { return phases_.size(); }
  /// Of a phase, in the order in which they were added; once each, when all were.
  VolumeSurface surface(size_t phase, const Progress& progress = {});

 private:
  /// A phase whose slices have to be looked at yet, or its handles removed; or one with its
  /// surface.
  struct Phase {
    std::optional<SliceStack> stack;
    std::exception_ptr error;
    std::vector<int> apart;
    int sliceSequence = 0;
    double seconds = 0;
    std::optional<WorkingVolume> volume;
    std::optional<Eigen::Vector3i> place;  // in common_; none where grids do not agree
    HandleRemoval removal;
    std::optional<VolumeSurface> surface;
  };
  void alignOpenSlices(const Progress& progress);
  void goOn(Phase& phase, WorkingVolume volume, const Progress& progress);
  void removeOpenHandles(const Progress& progress);
  std::vector<Eigen::Vector3i> commonCut(const std::vector<Phase*>& phases) const;

  VolumeSurfaceParameters parameters_;
  CommonDepth common_;
  std::vector<Phase> phases_;
  size_t kept_ = 0, keptSlices_ = 0;
  int sliceSequences_ = 0;
};

}  // namespace sphere_propagation
