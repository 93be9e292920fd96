// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// From the labels of one phase to a surface with nothing left to repair.

#include "vcg_ext/base/progress.h"
#include "vcg_ext/volume/digital_topology.h"
#include "vcg_ext/volume/slice_interpolation.h"

namespace sphere_propagation {

struct VolumeSurfaceParameters {
  static constexpr double maxSmoothing = 5;

  SliceInterpolationParameters interpolation;  ///< labels, size of the working voxels, gaps
  double smoothing = 1;   ///< Gaussian, standard deviation in working voxels, 0 to maxSmoothing
  bool fillHoles = true;  ///< cavities that the labels enclose completely
  bool keepLargestComponent = true;  ///< drop all parts but the one with the most working voxels
  bool cutHandles = true;            ///< every part comes out of genus 0, without cavities
  HandleRepair handleRepair = HandleRepair::LessChange;  ///< how, where there is one part
};

/// Voxels that were changed to remove a handle, or a part of what it took.
struct HandlePlace {
  Vector3 centre = Vector3::Zero();  ///< the mean of the voxels, mm, in the world
  long voxels = 0;                   ///< of the working grid
};

struct VolumeSurface {
  Points vertices;  ///< #V by 3, mm, in the world
  Triangles faces;  ///< #F by 3; closed, manifold, outward, also where the labels' matrix mirrors
  double labelVolume = 0;  ///< of the voxels with the labels, mm^3
  double volume = 0;       ///< that the surface encloses, mm^3
  double voxelSize = 0;    ///< of the working grid, mm
  int interpolatedSlices = 0;
  long workingVoxels = 0;       ///< inside, before anything was filled, dropped or cut
  long filledVoxels = 0;        ///< of the working grid, in cavities
  DroppedParts dropped;         ///< of the working grid
  std::vector<int> lostSlices;  ///< indices of slices at least nine tenths of which were dropped
  std::vector<UnevenSlice> unevenSlices;
  std::vector<UnevenSlice> farEnds;  ///< as of InterpolatedLabels
  std::vector<BorderContact> borders;
  std::vector<int> apartSlices;  ///< indices of those that lie otherwise than in the other phases
                                 ///< of the sequence (PhaseAlignment)
  int sliceSequence = 0;         ///< as PhaseAlignment::sequence
  double seconds = 0;            ///< that VolumeSequence spent on it, apart from `add`
  std::vector<int> slices;       ///< indices of those with a label
  RemovedHandles handles;        ///< of the working grid
  bool handlesAlone = true;      ///< where they were removed was decided without other phases
  std::vector<HandlePlace> handlePlaces;  ///< groups of changed voxels, the largest first
};

/// A phase on its way to a surface: where it is inside, before handles are removed.
struct WorkingVolume {
  InterpolatedLabels field;
  Mask mask;              ///< of field.grid: without what was dropped, with what was filled
  VolumeSurface surface;  ///< what is known of it so far; no vertices
};

/// Steps 1 and 2 of volumeSurface. Throws what that throws.
WorkingVolume workingVolume(const LabelGrid& labels, const VolumeSurfaceParameters& parameters = {},
                            const Progress& progress = {});

/// Throws ParameterError when smoothing is out of range.
void requireSmoothing(const VolumeSurfaceParameters& parameters);

/// Steps 1 and 2 of slices that were cut out, these of them out of line.
WorkingVolume workingVolume(SliceStack stack, const std::vector<UnevenSlice>& uneven,
                            const VolumeSurfaceParameters& parameters);

/// Removes handles from a phase and notes it.
void removeHandles(WorkingVolume& volume, const HandleRemoval& removal, HandleRepair repair);

/// Steps 3 to 5 of volumeSurface, of a phase whose handles have been removed as asked for.
VolumeSurface surfaceOf(WorkingVolume volume, double smoothing, const Progress& progress = {});

/// 1. interpolateSlices; inside is where it is positive. 2. keepLargestPart, fillCavities,
/// removeHandles, as asked for.
/// 3. The distances, where they agree with that, smoothed by a Gaussian and shifted to keep the
/// number of inside voxels; the mask follows by simple points (moveBySimplePoints), and where it
/// cannot, its own side holds. 4. marchingCubes with the face rule that realises the mask's
/// topology. 5. The vertices are spread within the surface (steps towards the mean of the
/// neighbours, tangential part only), so that triangles get a decent shape, and the whole is moved
/// along its normals by the little that brings back the volume that the voxels have.
///
/// With cutHandles and keepLargestComponent the result is a sphere topologically, whatever the
/// labels. Throws what interpolateSlices throws; ParameterError when smoothing is out of range.
VolumeSurface volumeSurface(const LabelGrid& labels, const VolumeSurfaceParameters& parameters = {},
                            const Progress& progress = {});

}  // namespace sphere_propagation
