// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/volume/volume_surface.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/volume/gaussian_smoothing.h"
#include "vcg_ext/volume/marching_cubes.h"

namespace sphere_propagation {
namespace {

// In working voxels.
constexpr float band =
    3;  // distances count up to here: what is farther says nothing about the surface
constexpr float corrected = 0.5F;  // the distance of a voxel that changed sides
constexpr float held =
    0.25F;  // and of one that smoothing would have changed, but topology does not let
constexpr float least = 0.02F;  // no vertex closer to a voxel: its faces would be slivers
constexpr double maxShift = 0.25;
constexpr int relaxations = 10;

/// The volume of the cells, those at the border counted by the share that lies inside as far as the
/// distance tells.
double volumeOf(const std::vector<float>& distance, double h) {
  double sum = 0;
  for (const float d : distance) sum += std::clamp(static_cast<double>(d) / h + 0.5, 0.0, 1.0);
  return sum * h * h * h;
}

/// The value that has so many above it, but not farther from 0 than `limit`.
float levelWith(const std::vector<float>& values, long above, float limit) {
  std::vector<float> near;
  for (const float v : values) {
    if (v > limit)
      --above;
    else if (v >= -limit)
      near.push_back(v);
  }
  if (above <= 0) return limit;
  if (above >= static_cast<long>(near.size())) return -limit;
  const auto middle = near.begin() + above;
  std::nth_element(near.begin(), middle, near.end(), std::greater<>());
  return *middle;
}

/// Spreads the vertices within the surface.
void relax(Points& vertices, const Triangles& faces) {
  Points sums(vertices.rows(), 3);
  Eigen::VectorXd valence = Eigen::VectorXd::Zero(vertices.rows());
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) valence[faces(f, k)] += 1;
  for (int i = 0; i < relaxations; ++i) {
    sums.setZero();
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
      for (int k = 0; k < 3; ++k) sums.row(faces(f, k)) += vertices.row(faces(f, (k + 1) % 3));
    const Points normals = vertexNormals(vertices, faces);
    for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
      const Eigen::RowVector3d step = sums.row(v) / valence[v] - vertices.row(v),
                               normal = normals.row(v);
      vertices.row(v) += 0.5 * (step - step.dot(normal) * normal);
    }
  }
}

/// Moves the surface along its normals until it encloses this volume, or by `limit` at most.
void restoreVolume(Points& vertices, const Triangles& faces, double volume, double limit) {
  for (int i = 0; i < 3; ++i) {
    const double area = faceAreas(vertices, faces).sum();
    if (!(area > 0)) return;
    const double step =
        std::clamp((volume - enclosedVolume(vertices, faces)) / area, -limit, limit);
    vertices += step * vertexNormals(vertices, faces);
  }
}

/// The field of which marching cubes takes the surface: smooth, and with the sign of the mask,
/// which follows it as far as its topology lets.
void smoothField(ScalarGrid& grid, Mask& mask, double h, double standardDeviation) {
  const auto unit = static_cast<float>(h);
  for (size_t i = 0; i < grid.values.size(); ++i) {
    const bool in = mask.values[i] != 0;
    float& d = grid.values[i];
    if ((d > 0) != in) d = in ? corrected * unit : -corrected * unit;
    d = std::clamp(d, -band * unit, band * unit);
  }
  if (standardDeviation > 0) {
    const long inside = std::count(mask.values.begin(), mask.values.end(), std::uint8_t{1});
    smoothGaussian(grid, standardDeviation);
    const float level = levelWith(grid.values, inside, static_cast<float>(maxShift) * unit);
    for (float& d : grid.values) d -= level;
    moveBySimplePoints(mask, grid.values);
  }
  for (size_t i = 0; i < grid.values.size(); ++i) {
    const bool in = mask.values[i] != 0;
    float& d = grid.values[i];
    if ((d > 0) != in)
      d = in ? held * unit : -held * unit;
    else
      d = in ? std::max(d, least * unit) : std::min(d, -least * unit);
  }
}

/// Slices of which hardly anything is inside any more. Of two bodies side by side, one of which
/// goes, no slice is lost.
std::vector<int> lostSlicesOf(const WorkingVolume& volume) {
  const LabelStack& stack = volume.field.stack;
  const ScalarGrid& grid = volume.field.grid;
  std::vector<int> lost;
  for (int k = 0; k < stack.mask.size[2]; ++k) {
    long before = 0, after = 0;
    for (int j = 0; j < stack.mask.size[1]; ++j)
      for (int i = 0; i < stack.mask.size[0]; ++i) {
        if (stack.mask(i, j, k) == 0) continue;
        const Vector3 x = Vector3(i, j, k).cwiseProduct(stack.spacing) - grid.origin;
        const Eigen::Vector3i at =
            (x / grid.spacing[0]).array().round().cast<int>().max(0).min(grid.size.array() - 1);
        const size_t sample = grid.index(at[0], at[1], at[2]);
        before += grid.values[sample] > 0;
        after += volume.mask.values[sample];
      }
    if (after < before && 10 * after <= before) lost.push_back(k + stack.firstSlice);
  }
  return lost;
}

std::vector<int> labelledSlices(const LabelStack& stack) {
  std::vector<int> slices;
  const auto size = static_cast<std::ptrdiff_t>(stack.mask.index(0, 0, 1));
  for (int k = 0; k < stack.mask.size[2]; ++k) {
    const auto begin = stack.mask.values.begin() + k * size;
    if (std::any_of(begin, begin + size, [](std::uint8_t in) { return in != 0; }))
      slices.push_back(k + stack.firstSlice);
  }
  return slices;
}

WorkingVolume workingVolumeOf(InterpolatedLabels field, const VolumeSurfaceParameters& parameters) {
  WorkingVolume volume;
  volume.field = std::move(field);
  const ScalarGrid& grid = volume.field.grid;
  VolumeSurface& result = volume.surface;
  result.labelVolume = volume.field.labelVolume;
  result.voxelSize = grid.spacing[0];
  result.interpolatedSlices = volume.field.interpolatedSlices;
  Mask& mask = volume.mask = Mask(grid.size);
  for (size_t i = 0; i < mask.values.size(); ++i) mask.values[i] = grid.values[i] > 0;
  result.workingVoxels = std::count(mask.values.begin(), mask.values.end(), std::uint8_t{1});
  if (result.workingVoxels == 0) throw VolumeError(Finding(Fault::TooThin).at(result.voxelSize));
  result.unevenSlices = volume.field.unevenSlices;
  result.farEnds = volume.field.farEnds;
  result.borders = volume.field.borders;
  result.slices = labelledSlices(volume.field.stack);
  if (parameters.keepLargestComponent) {
    result.dropped = keepLargestPart(mask);
    if (result.dropped.parts > 0) result.lostSlices = lostSlicesOf(volume);
  }
  if (parameters.fillHoles) result.filledVoxels = fillCavities(mask);
  return volume;
}

}  // namespace

void requireSmoothing(const VolumeSurfaceParameters& parameters) {
  requireRange("smoothing in working voxels", parameters.smoothing,
               Range::between(0, VolumeSurfaceParameters::maxSmoothing));
}

WorkingVolume workingVolume(const LabelGrid& labels, const VolumeSurfaceParameters& parameters,
                            const Progress& progress) {
  requireSmoothing(parameters);
  WorkingVolume volume =
      workingVolumeOf(interpolateSlices(labels, parameters.interpolation), parameters);
  report(progress, 1);
  return volume;
}

WorkingVolume workingVolume(SliceStack stack, const std::vector<UnevenSlice>& uneven,
                            const VolumeSurfaceParameters& parameters) {
  requireSmoothing(parameters);
  return workingVolumeOf(interpolateSlices(std::move(stack), uneven, parameters.interpolation),
                         parameters);
}

void removeHandles(WorkingVolume& volume, const HandleRemoval& removal, HandleRepair repair) {
  const ScalarGrid& grid = volume.field.grid;
  volume.surface.handles = removal.apply(volume.mask, repair);
  volume.surface.handlePlaces.clear();
  if (!removal.needed) return;
  for (const auto& group :
       groupsOf(grid.size,
                removal.chosen(repair) == HandleRepair::Fill ? removal.filled : removal.cut)) {
    Vector3 sum = Vector3::Zero();
    const auto row = static_cast<size_t>(grid.size[0]), slice = grid.index(0, 0, 1);
    for (const size_t i : group)
      sum += Vector3(static_cast<double>(i % row), static_cast<double>(i % slice / row),
                     static_cast<double>(i / slice));
    const Vector3 centre =
        grid.origin + (sum / static_cast<double>(group.size())).cwiseProduct(grid.spacing);
    volume.surface.handlePlaces.push_back(
        {volume.field.worldOf(centre), static_cast<long>(group.size())});
  }
}

VolumeSurface surfaceOf(WorkingVolume volume, double smoothing, const Progress& progress) {
  ScalarGrid& grid = volume.field.grid;
  const double h = grid.spacing[0];
  std::vector<float> signedDistances = grid.values;
  for (size_t i = 0; i < signedDistances.size(); ++i)
    if ((signedDistances[i] > 0) != (volume.mask.values[i] != 0))
      signedDistances[i] = static_cast<float>(volume.mask.values[i] != 0 ? h : -h);
  const double enclosed = volumeOf(signedDistances, h);
  signedDistances = {};
  smoothField(grid, volume.mask, h, smoothing);
  report(progress, 0.5);

  IsoSurface surface = marchingCubes(grid, 0, FaceRule::SeparateInside);
  relax(surface.vertices, surface.faces);
  restoreVolume(surface.vertices, surface.faces, enclosed, maxShift * h);
  const Eigen::Matrix3d linear = volume.field.toWorld.topLeftCorner<3, 3>();
  VolumeSurface result = std::move(volume.surface);
  result.vertices = (surface.vertices * linear.transpose()).rowwise() +
                    volume.field.toWorld.topRightCorner<3, 1>().transpose();
  result.faces = std::move(surface.faces);
  if (linear.determinant() < 0) result.faces.col(1).swap(result.faces.col(2));
  result.volume = enclosedVolume(result.vertices, result.faces);
  report(progress, 1);
  return result;
}

VolumeSurface volumeSurface(const LabelGrid& labels, const VolumeSurfaceParameters& parameters,
                            const Progress& progress) {
  WorkingVolume volume = workingVolume(labels, parameters, part(progress, 0, 0.2));
  if (parameters.cutHandles) {
    const HandleRemoval removal = findHandleRemoval(
        volume.mask, volume.field.grid.values, parameters.handleRepair, part(progress, 0.2, 0.8));
    removeHandles(volume, removal, removal.chosen(parameters.handleRepair));
  }
  return surfaceOf(std::move(volume), parameters.smoothing, part(progress, 0.8, 1));
}

}  // namespace sphere_propagation
