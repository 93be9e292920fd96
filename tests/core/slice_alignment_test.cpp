// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/volume/slice_alignment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "tests/core/label_shapes.h"
#include "vcg_ext/volume/volume_surface.h"

namespace sphere_propagation {
namespace {

using Shifts = std::vector<Eigen::Vector2i>;

constexpr double thickness = 10;
const Vector3 spacing(1.4, 1.4, thickness);

/// A cup, as a ventricle's cavity, whose axis bends as told (mm off, of the height in mm).
LabelGrid cup(const std::function<Eigen::Vector2d(double)>& axis, bool wall = false) {
  return test::labelsOf(
      [=](const Vector3& x) {
        const double height = (x[2] + 45) / 95;  // 0 at the apex, 1 at the base
        if (height < 0 || height > 1) return false;
        const double outer = 24 * std::sqrt(std::max(0.0, 1 - std::pow(1 - height, 1.6))) + 4;
        const double r = (x.head<2>() - axis(x[2])).norm();
        return r < outer && !(wall && height > 0.15 && r < outer - 9);
      },
      {80, 76, 13}, spacing);
}

LabelGrid straightCup(bool wall = false) {
  return cup([](double) { return Eigen::Vector2d::Zero().eval(); }, wall);
}

/// Its slices moved, all of them as told.
LabelGrid moved(const LabelGrid& labels, const Shifts& shifts) {
  LabelGrid result = labels;
  std::fill(result.values.begin(), result.values.end(), 0);
  for (int k = 0; k < labels.size[2]; ++k)
    for (int j = 0; j < labels.size[1]; ++j)
      for (int i = 0; i < labels.size[0]; ++i)
        if (labels(i, j, k) != 0)
          result(i + shifts[static_cast<size_t>(k)][0], j + shifts[static_cast<size_t>(k)][1], k) =
              1;
  return result;
}

std::map<int, Eigen::Vector2i> found(const LabelGrid& labels) {
  std::map<int, Eigen::Vector2i> shifts;
  for (const SliceShift& shift : findSliceShifts(test::maskOf(labels), spacing))
    shifts[shift.slice] = shift.voxels;
  return shifts;
}

Shifts breathing(unsigned seed, int slices, double deviation) {
  test::Random random(seed);
  Shifts shifts;
  for (int k = 0; k < slices; ++k)
    shifts.emplace_back(std::lround(random.normal() * deviation / spacing[0]),
                        std::lround(random.normal() * deviation / spacing[1]));
  return shifts;
}

/// How rough shifts are: the root mean square second difference, mm.
double roughness(const Shifts& shifts, int first, int last) {
  double sum = 0;
  for (int k = first + 1; k < last; ++k) {
    const auto i = static_cast<size_t>(k);
    sum += (shifts[i - 1] - 2 * shifts[i] + shifts[i + 1]).cast<double>().squaredNorm();
  }
  return spacing[0] * std::sqrt(sum / (last - first - 1));
}

TEST(SliceAlignment, LeavesSmoothStacksAlone) {
  EXPECT_TRUE(found(straightCup()).empty());
  EXPECT_TRUE(found(straightCup(true)).empty());
  for (const double bend : {60.0, 120.0}) {  // mm: the radius of a bent axis
    const auto bent = [=](double z) { return Eigen::Vector2d(z * z / bend / 2, -0.3 * z); };
    EXPECT_TRUE(found(cup(bent)).empty()) << bend;
  }
  const auto crooked = [](double z) {  // at its upper end
    return Eigen::Vector2d(z > 30 ? 0.06 * (z - 30) * (z - 30) : 0, 0);
  };
  EXPECT_TRUE(found(cup(crooked)).empty());
  const auto tube = [](const Vector3& x) {  // a quarter of a ring
    return std::hypot(std::hypot(x[0] + 50, x[2] + 50) - 60, x[1]) < 12;
  };
  EXPECT_TRUE(found(test::labelsOf(tube, {80, 30, 9}, spacing)).empty());
}

TEST(SliceAlignment, LeavesSlicesAloneWhereOutlinesFitNowhere) {
  // A vertebra: its body, and an arch that begins and ends at once.
  for (const double apart : {1.0, 4.0, 6.0}) {
    const LabelGrid vertebra = test::labelsOf(
        [](const Vector3& x) {
          const double arch = std::hypot(x[0], x[1] - 9);
          const bool body = std::pow(x[0] / 14, 2) + std::pow((x[1] + 11) / 11, 2) < 1;
          return (body && std::fabs(x[2]) < 9) || (std::fabs(arch - 12) < 3 && std::fabs(x[2]) < 5);
        },
        {50, 70, static_cast<int>(30 / apart)}, Vector3(1, 1, apart));
    EXPECT_TRUE(findSliceShifts(test::maskOf(vertebra), Vector3(1, 1, apart)).empty()) << apart;
  }
}

TEST(SliceAlignment, FindsASliceThatStandsOut) {
  for (const bool wall : {false, true})
    for (const int slice : {4, 5, 6, 8, 10}) {
      Shifts shifts(13, Eigen::Vector2i::Zero());
      shifts[static_cast<size_t>(slice)] = Eigen::Vector2i(6, -4);
      const auto back = found(moved(straightCup(wall), shifts));
      ASSERT_EQ(back.count(slice), 1U) << slice;
      EXPECT_LE((back.at(slice) + shifts[static_cast<size_t>(slice)]).norm(), 1.5) << slice;
      EXPECT_EQ(back.size(), 1U) << slice;
    }
}

TEST(SliceAlignment, BringsAnApexBack) {
  Shifts shifts(13, Eigen::Vector2i::Zero());
  shifts[2] = Eigen::Vector2i(-11, 9);
  const LabelGrid labels = moved(straightCup(), shifts);
  const auto back = findSliceShifts(test::maskOf(labels), spacing);
  ASSERT_EQ(back.size(), 1U);
  EXPECT_EQ(back[0].slice, 2);
  EXPECT_TRUE(back[0].alone);
  EXPECT_LE((back[0].voxels + shifts[2]).norm(), 2);
}

TEST(SliceAlignment, SmoothsAStackOfManyBreaths) {
  const auto bent = [](double z) { return Eigen::Vector2d(z * z / 160, 0.2 * z); };
  for (unsigned seed = 1; seed < 6; ++seed) {
    const Shifts shifts = breathing(seed, 13, 3);
    Shifts left = shifts;
    for (const auto& shift : found(moved(cup(bent), shifts)))
      left[static_cast<size_t>(shift.first)] += shift.second;
    EXPECT_LT(roughness(left, 2, 11), 0.6 * roughness(shifts, 2, 11)) << "seed " << seed;
  }
}

TEST(SliceAlignment, IsTheSameInAMirrorAndWithAxesSwapped) {
  const LabelGrid labels = moved(straightCup(), breathing(7, 13, 3));
  const Eigen::Vector3i n = labels.size;
  LabelGrid mirrored = labels, swapped = labels;
  swapped.size = {n[1], n[0], n[2]};
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i) {
        mirrored(n[0] - 1 - i, j, n[2] - 1 - k) = labels(i, j, k);
        swapped(j, i, k) = labels(i, j, k);
      }
  const auto as = found(labels), inMirror = found(mirrored), turned = found(swapped);
  ASSERT_FALSE(as.empty());
  for (const auto& shift : as) {
    ASSERT_EQ(turned.count(shift.first), 1U);
    EXPECT_LE((turned.at(shift.first) - shift.second.reverse()).cwiseAbs().maxCoeff(), 1);
    const int opposite = n[2] - 1 - shift.first;
    if (shift.second.norm() < 2) continue;  // a voxel more or less, by which a tie is broken
    ASSERT_EQ(inMirror.count(opposite), 1U);
    EXPECT_LE((inMirror.at(opposite) - Eigen::Vector2i(-shift.second[0], shift.second[1]))
                  .cwiseAbs()
                  .maxCoeff(),
              2);
  }
}

std::vector<PhaseAlignment> aligned(const std::vector<LabelGrid>& phases) {
  std::vector<std::vector<SlicePlace>> places;
  for (const LabelGrid& labels : phases) places.push_back(slicePlaces(test::maskOf(labels)));
  return alignSlices(places, spacing);
}

/// A bent cup that shrinks by so much, its base coming down.
LabelGrid beating(double share) {
  return test::labelsOf(
      [=](const Vector3& x) {
        const double height = (x[2] + 45) / (95 - 22 * share);
        if (height < 0 || height > 1) return false;
        const double outer =
            (24 * std::sqrt(1 - std::pow(1 - height, 1.6)) + 4) * (1 - 0.3 * share);
        return (x.head<2>() - Eigen::Vector2d(x[2] * x[2] / 180, 0.2 * x[2])).norm() < outer;
      },
      {80, 76, 13}, spacing);
}

TEST(SliceAlignment, MovesASliceAlikeInAllPhases) {
  Shifts shifts(13, Eigen::Vector2i::Zero());
  shifts[6] = {3, -2};
  std::vector<LabelGrid> straight, phases;
  for (const double share : {0.0, 0.4, 0.8, 1.0, 0.7, 0.2}) {
    straight.push_back(beating(share));
    phases.push_back(moved(straight.back(), shifts));
  }
  for (const PhaseAlignment& phase : aligned(straight)) EXPECT_TRUE(phase.shifts.empty());
  for (const PhaseAlignment& phase : aligned(phases)) {
    EXPECT_TRUE(phase.apart.empty());
    EXPECT_EQ(phase.sequence, 0);
    ASSERT_EQ(phase.shifts.size(), 1U);
    EXPECT_EQ(phase.shifts[0].slice, 6);
    EXPECT_LE((phase.shifts[0].voxels + shifts[6]).norm(), 1.5);
    EXPECT_EQ(phase.shifts[0].voxels, aligned(phases)[0].shifts[0].voxels);
  }
  phases[3] = straight[3];  // which contradicts the others
  const auto found = aligned(phases);
  for (size_t p = 0; p < phases.size(); ++p)
    EXPECT_EQ(found[p].shifts.size(), p == 3 ? 0U : 1U) << p;
}

TEST(SliceAlignment, KeepsSequencesApart) {
  std::vector<LabelGrid> phases;
  for (const unsigned seed : {4U, 9U})
    for (const double share : {0.0, 0.5}) {
      Shifts shifts = breathing(seed, 13, 4);
      for (auto& shift : shifts) shift = shift.cwiseMin(9).cwiseMax(-9);
      phases.push_back(moved(beating(share), shifts));
    }
  const auto together = aligned(phases), own = aligned({phases[2], phases[3]});
  for (size_t p = 0; p < phases.size(); ++p) EXPECT_EQ(together[p].sequence, p < 2 ? 0 : 1);
  for (size_t p = 0; p < 2; ++p) {
    ASSERT_EQ(together[2 + p].shifts.size(), own[p].shifts.size());
    for (size_t i = 0; i < own[p].shifts.size(); ++i)
      EXPECT_EQ(together[2 + p].shifts[i].voxels, own[p].shifts[i].voxels);
  }
}

TEST(SliceAlignment, SaysThatOpenRingsMeet) {
  LabelGrid rings = test::labelsOf(
      [](const Vector3& x) {  // a wall that opens to one side and widens
        const double r = x.head<2>().norm(), inner = 14 + 0.4 * (x[2] + 45);
        return r > inner && r < inner + 5 && std::atan2(x[1], x[0]) < 2.4;
      },
      {120, 120, 9}, spacing);
  for (const SlicePlace& place : slicePlaces(test::maskOf(rings))) EXPECT_TRUE(place.meets);
  EXPECT_TRUE(found(rings).empty());
}

TEST(SliceAlignment, SaysNothingOfFewSlices) {
  const auto two = [](const Vector3& x) { return x.norm() < 12; };
  EXPECT_TRUE(found(test::labelsOf(two, {30, 30, 4}, spacing)).empty());
  EXPECT_TRUE(findSliceShifts(Mask({5, 5, 5}), spacing).empty());
}

TEST(SliceAlignment, MovesSlicesAndKeepsTheirVoxels) {
  Mask mask({6, 5, 3});
  for (int k = 0; k < 3; ++k) mask(2, 2, k) = mask(3, 2, k) = 1;
  const Eigen::Vector2i grown = moveSlices(mask, {{0, {-3, 0}}, {2, {1, 4}}});
  EXPECT_EQ(grown, Eigen::Vector2i(3, 0));
  EXPECT_EQ(mask.size, Eigen::Vector3i(10, 9, 3));
  EXPECT_EQ(std::count(mask.values.begin(), mask.values.end(), 1), 6);
  EXPECT_EQ(mask(2, 2, 0), 1);
  EXPECT_EQ(mask(5, 2, 1), 1);
  EXPECT_EQ(mask(6, 6, 2), 1);
}

}  // namespace
}  // namespace sphere_propagation
