// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// From labels on any grid to a signed distance on a grid of cubes.

#include "vcg_ext/volume/grid.h"
#include "vcg_ext/volume/label_grid.h"
#include "vcg_ext/volume/slice_alignment.h"

namespace sphere_propagation {

struct SliceInterpolationParameters {
  std::vector<std::int32_t> labels{
      1};                    ///< what counts as inside: the union of these; none of them 0
  double voxelSize = 0;      ///< edge of the cubes, mm; 0: the smallest spacing of the labels
  int longestGap = 10;       ///< so many empty slices in a row are interpolated, >= 0
  bool alignSlices = false;  ///< move slices in their plane so that the stack is smooth
};

/// A slice that does not follow from those beside it (findSliceShifts).
struct UnevenSlice {
  int slice = 0;       ///< its index in the labels, along the slices' axis
  double shift = 0;    ///< how far it was moved, or would have to be, mm
  bool alone = false;  ///< whether it hardly met the slices beside it
  Eigen::Vector2i voxels = Eigen::Vector2i::Zero();  ///< the same along the other two axes
};

/// A border of the volume that the labels run into with much of their widest section along that
/// axis (over .35; across slices far apart over .5): more than where a volume was trimmed to them,
/// so they may be cut off there.
struct BorderContact {
  int axis = 0;      ///< of the volume: 0, 1, 2 for i, j, k
  int index = 0;     ///< along it: 0 or the last one
  double share = 0;  ///< of the widest section
};

/// The voxels with the labels, cut out and turned so that slices lie along the last axis.
struct SliceStack {
  Mask mask;  ///< its border is outside
  Vector3 spacing = Vector3::Ones();
  Eigen::Vector3i first =
      Eigen::Vector3i::Zero();  ///< the index of voxel (0, 0, 0) in the labels, in the stack's axes
  Eigen::Matrix4d toWorld =
      Eigen::Matrix4d::Identity();  ///< from index in the labels times spacing, in the stack's axes
  double labelVolume = 0;           ///< of the voxels with the labels, mm^3
  double voxelSize = 0;             ///< of the working grid, mm
  bool betweenSlices = false;       ///< whether shape-based interpolation is called for
  std::vector<BorderContact> borders;

  /// These shifts of slices of the mask, as they are told.
  std::vector<UnevenSlice> uneven(const std::vector<SliceShift>& shifts) const;
};

/// The voxels with the labels, cut out, slices along the last axis, as they were interpolated.
struct LabelStack {
  Mask mask;
  Vector3 spacing = Vector3::Ones();  ///< voxel (i, j, k) lies at (i, j, k) spacing in the
                                      ///< coordinates of the working grid
  int firstSlice = 0;                 ///< the index in the labels of k = 0
};

/// Where the union of some labels is, as a signed distance on a grid of cubes.
struct InterpolatedLabels {
  ScalarGrid grid;  ///< mm, positive inside; at least three samples at each border are negative
  Eigen::Matrix4d toWorld =
      Eigen::Matrix4d::Identity();  ///< from the coordinates of `grid` (a rotation, a shear, or a
                                    ///< reflection) to mm in the world
  Vector3 worldOf(const Vector3& x) const {  ///< of a place in the coordinates of `grid`
    return toWorld.topLeftCorner<3, 3>() * x + toWorld.topRightCorner<3, 1>();
  }
  double labelVolume = 0;                 ///< of the voxels with these labels, mm^3
  int interpolatedSlices = 0;             ///< empty ones between others
  std::vector<UnevenSlice> unevenSlices;  ///< looked for between slices, and where they are aligned
  std::vector<UnevenSlice> farEnds;  ///< the first and the last slice where they lie far off the
                                     ///< line through the two next to them, by so much (over 12 mm
                                     ///< and half a radius), and by over three tenths beside the
                                     ///< next one: shifted, or the organ bends; they stay
  std::vector<BorderContact> borders;
  LabelStack stack;
  bool betweenSlices =
      false;  ///< whether the slices lie so far apart that shape-based interpolation was called for
};

/// S. P. Raya and J. K. Udupa, Shape-based interpolation of multidimensional objects, IEEE
/// Transactions on Medical Imaging 9, 1990. Where the slices lie at least 1.5 times as far apart as
/// the voxels in them: signed distances in each slice, linear interpolation in the slice and a
/// monotone cubic one across (F. N. Fritsch and J. Butland, A method for constructing local
/// monotone piecewise cubic interpolants, 1984), so that the surface has no creases at the slices;
/// flat caps half a slice beyond the first and the last slice. A wall, a ring in its slices, would
/// be torn where it slips sideways by more than its thickness from one slice to the next: where its
/// holes lead through (SliceHoles), what it fills and its holes are interpolated by themselves, and
/// the wall is the one without the other. Else: signed distances in space, linear interpolation.
/// Slices are those along the axis of the largest spacing, of equal ones the last.
///
/// With alignSlices, slices are moved first, in whole voxels, as findSliceShifts says of the labels
/// alone (slice_alignment.h).
///
/// An empty slice is interpolated between its neighbours when there are at most `longestGap` in a
/// row and the smaller of the two slices beside the gap has at least a tenth of the other's voxels
/// (half of them where slices lie close); else the one beyond is another part, and the gap stays.
///
/// Throws AbsentLabelError when no voxel has one of the labels (the text lists those that occur);
/// VolumeError when the labels are no sound grid; ParameterError when a parameter is out of range,
/// the grid would have more than 2e8 samples, or the cubes are too large for the label.
InterpolatedLabels interpolateSlices(const LabelGrid& labels,
                                     const SliceInterpolationParameters& parameters = {});

/// Its first step, with the errors but for those of the working grid.
SliceStack cutOut(const LabelGrid& labels, const SliceInterpolationParameters& parameters);

/// Its other steps, with these slices out of line.
InterpolatedLabels interpolateSlices(SliceStack stack, const std::vector<UnevenSlice>& uneven,
                                     const SliceInterpolationParameters& parameters);

}  // namespace sphere_propagation
