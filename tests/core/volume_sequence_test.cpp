// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/volume/volume_sequence.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/label_shapes.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/mesh/closed_surface.h"

namespace sphere_propagation {
namespace {

using test::labelsOf;

/// A body with an arch, as a vertebra, that is thin on the side of this sign; 0: nowhere.
LabelGrid vertebra(int thin, const Vector3& at = Vector3::Zero(), double gap = 0) {
  return labelsOf(
      [=](const Vector3& world) {
        const Vector3 x = world - at;
        const double off = std::hypot(x[0], x[1] - 6) - 9;
        const bool body = std::hypot(x[0] / 11, (x[1] + 8) / 8) < 1 && std::fabs(x[2]) < 6;
        const bool narrow = std::fabs(x[1] - 8) < 1.5 && x[0] * thin > 0;
        return body || (std::fabs(off) < (narrow ? 1 : 2.6) && std::fabs(x[2]) < 3 &&
                        !(narrow && std::fabs(x[1] - 8) < gap));
      },
      {45, 51, 23});
}

/// The same, thin at an angle of the arch.
LabelGrid vertebraThinAt(double angle, double shift) {
  return labelsOf(
      [=](const Vector3& world) {
        const Vector3 x = world - Vector3(shift, 0, 0);
        const double off = std::hypot(x[0], x[1] - 6) - 9,
                     away = std::remainder(std::atan2(x[1] - 6, x[0]) - angle, 2 * M_PI);
        return (std::hypot(x[0] / 11, (x[1] + 8) / 8) < 1 && std::fabs(x[2]) < 6) ||
               (std::fabs(off) < (std::fabs(away) < 0.17 ? 1 : 2.6) && std::fabs(x[2]) < 3);
      },
      {45, 51, 23});
}

std::vector<VolumeSurface> together(const std::vector<LabelGrid>& phases,
                                    HandleRepair repair = HandleRepair::LessChange) {
  VolumeSurfaceParameters parameters;
  parameters.handleRepair = repair;
  VolumeSequence sequence(parameters);
  for (const LabelGrid& labels : phases) sequence.add(labels);
  std::vector<VolumeSurface> surfaces;
  for (size_t p = 0; p < sequence.phases(); ++p) {
    surfaces.push_back(sequence.surface(p));
    const ClosedSurface sphere(surfaces.back().vertices, surfaces.back().faces);
  }
  return surfaces;
}

Vector3 placeOf(const VolumeSurface& surface) {
  EXPECT_FALSE(surface.handlePlaces.empty());
  return surface.handlePlaces.at(0).centre;
}

TEST(VolumeSequence, CutsAndFillsAtOnePlaceInAllPhases) {
  for (const HandleRepair repair :
       {HandleRepair::LessChange, HandleRepair::Cut, HandleRepair::Fill}) {
    const auto found = together({vertebra(1), vertebra(-1), vertebra(0)}, repair);
    for (const VolumeSurface& surface : found) {
      EXPECT_EQ(surface.handles.handles, 1);
      EXPECT_EQ(surface.handles.by, repair == HandleRepair::Fill ? RemovedHandles::By::Filling
                                                                 : RemovedHandles::By::Cutting);
      EXPECT_LT((placeOf(surface) - placeOf(found[0])).norm(), 1.2);
    }
  }
  // By themselves the first two are cut at opposite sides.
  const Vector3 right = placeOf(together({vertebra(1)})[0]),
                left = placeOf(together({vertebra(-1)})[0]);
  EXPECT_GT(right[0], 5);
  EXPECT_LT(left[0], -5);
}

TEST(VolumeSequence, CutsAtOnePlaceHoweverManyAreThinElsewhere) {
  for (const std::vector<double>& angles :
       {std::vector<double>{0.2, 1.6, 2.9}, {1.6, 0.2, 2.9}, {0.4, 2, 1, 2.7}, {2.5, 0.6, 1.5}}) {
    std::vector<LabelGrid> phases;
    for (size_t p = 0; p < angles.size(); ++p)
      phases.push_back(vertebraThinAt(angles[p], 1.5 * static_cast<double>(p)));
    const auto found = together(phases, HandleRepair::Cut);
    for (size_t p = 1; p < found.size(); ++p) {
      const Vector3 moved(1.5 * static_cast<double>(p), 0, 0);
      EXPECT_LT((placeOf(found[p]) - moved - placeOf(found[0])).norm(), 4) << angles[0];
    }
  }
}

TEST(VolumeSequence, CutsWhereAPhaseIsOpenAlready) {
  const auto found = together({vertebra(0), vertebra(-1, Vector3::Zero(), 1.5), vertebra(0)});
  EXPECT_EQ(found[1].handles.by, RemovedHandles::By::Nothing);
  EXPECT_LT((placeOf(found[0]) - Vector3(-9, 8, 0)).norm(), 2.5);
  EXPECT_LT((placeOf(found[2]) - placeOf(found[0])).norm(), 0.1);
}

TEST(VolumeSequence, FollowsAPhaseThatLiesElsewhere) {
  const Vector3 moved(5, -4, 3);
  for (const LabelGrid& second : {vertebra(-1, moved), [&] {
                                    LabelGrid grid = vertebra(-1);  // by its matrix
                                    grid.toWorld.topRightCorner<3, 1>() += moved;
                                    return grid;
                                  }()}) {
    const auto found = together({vertebra(1), second}, HandleRepair::Cut);
    EXPECT_LT((placeOf(found[1]) - placeOf(found[0]) - moved).norm(), 1.5);
  }
}

TEST(VolumeSequence, IsOneVolumeByItself) {
  const LabelGrid labels = test::randomBlobs(3, {20, 21, 22}, 1, 0.02);
  const VolumeSurface alone = volumeSurface(labels), found = together({labels})[0];
  EXPECT_EQ(alone.vertices, found.vertices);
  EXPECT_EQ(alone.handles.changedVoxels, found.handles.changedVoxels);
  long voxels = 0;
  for (const HandlePlace& place : found.handlePlaces) voxels += place.voxels;
  EXPECT_EQ(voxels, found.handles.changedVoxels);
}

TEST(VolumeSequence, MakesSpheresOfUnlikePhases) {
  // Another grid, a phase without anything in common, noise.
  LabelGrid turned = vertebra(1);
  turned.toWorld.topLeftCorner<3, 3>() = test::randomRotation(2);
  LabelGrid away = vertebra(1);
  away.toWorld(2, 3) += 4e5;
  const auto found = together(
      {vertebra(1), turned, away, vertebra(0), test::randomBlobs(5, {30, 31, 22}, 1, 0.05)});
  EXPECT_EQ(found.size(), 5U);
}

TEST(VolumeSequence, HandsOutASurfaceOnce) {
  VolumeSequence sequence({});
  EXPECT_THROW(sequence.add(labelsOf([](const Vector3&) { return false; }, {4, 4, 4})),
               AbsentLabelError);
  EXPECT_EQ(sequence.phases(), 0U);
  sequence.add(vertebra(0));
  sequence.surface(0);
  EXPECT_THROW(sequence.surface(0), ParameterError);
}

}  // namespace
}  // namespace sphere_propagation
