// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/display/side_by_side.h"

#include <gtest/gtest.h>

#include <limits>

#include "vcg_ext/display/sphere_pattern.h"

namespace sphere_propagation::test {
namespace {

using Bounds = Eigen::AlignedBox3d;

std::vector<Bounds> laidOut(const std::vector<Bounds>& boxes, const std::vector<Vector3>& moves) {
  std::vector<Bounds> result;
  for (size_t i = 0; i < boxes.size(); ++i) result.push_back(boxes[i].translated(moves[i]));
  return result;
}

bool meetAsSeen(Bounds a, Bounds b) {
  a.min().z() = b.min().z() = 0;
  a.max().z() = b.max().z() = 1;
  return a.intersects(b);
}

TEST(SideBySide, NoBoxHidesAnother) {
  for (const size_t count : {1, 2, 3, 7, 30}) {
    std::vector<Bounds> boxes;
    for (size_t i = 0; i < count; ++i) {
      const Vector3 corner(1.0 * i, -2.0 * i, 100);
      boxes.emplace_back(corner, corner + Vector3(10 + i % 3, 30, 10));
    }
    const Bounds beside(Vector3(-5, -5, -5), Vector3(5, 5, 5));
    for (const Bounds& around : {Bounds(), beside}) {
      const std::vector<Bounds> laid = laidOut(boxes, sideBySide(boxes, around));
      for (size_t i = 0; i < count; ++i) {
        EXPECT_TRUE(laid[i].sizes().isApprox(boxes[i].sizes()));
        for (size_t k = 0; k < i; ++k) EXPECT_FALSE(meetAsSeen(laid[i], laid[k])) << i << k;
        if (!around.isEmpty()) {
          EXPECT_GT(laid[i].min().x(), around.max().x());
        }
        if (i > 0) {  // reading order
          EXPECT_TRUE(laid[i].center().x() > laid[i - 1].center().x() ||
                      laid[i].center().y() < laid[i - 1].center().y());
        }
      }
    }
  }
}

TEST(SideBySide, OneBoxAloneStaysAndEmptyOnesTakeNoCell) {
  const Bounds box(Vector3(1, 2, 3), Vector3(4, 6, 9));
  EXPECT_LT(sideBySide({box})[0].norm(), 1e-12);
  const std::vector<Vector3> moves = sideBySide({Bounds(), box, Bounds()});
  EXPECT_EQ(moves[0], Vector3::Zero());
  EXPECT_LT(moves[1].norm(), 1e-12);
  EXPECT_TRUE(sideBySide({}).empty());
  const Bounds point(Vector3(1, 1, 1), Vector3(1, 1, 1));
  for (const Vector3& move : sideBySide({point, point})) EXPECT_TRUE(move.allFinite());
}

TEST(SideBySide, CellsThatAreGiven) {
  const Bounds box(Vector3(0, 0, 0), Vector3(1, 2, 3));
  const std::vector<Bounds> boxes(3, box);
  const std::vector<Bounds> laid =
      laidOut(boxes, sideBySide(boxes, {}, {{0, 0.5}, {1, 0}, {2, 1}}));
  EXPECT_DOUBLE_EQ(laid[0].center().y(), box.center().y());  // half way down two rows
  EXPECT_GT(laid[1].center().y(), laid[0].center().y());
  EXPECT_LT(laid[2].center().y(), laid[0].center().y());
  EXPECT_GT(laid[1].min().x(), laid[0].max().x());
  EXPECT_GT(laid[2].min().x(), laid[1].max().x());
}

TEST(SideBySide, BoxesAreOfWhatIsFinite) {
  Points points(3, 3);
  points << 0, 0, 0, std::numeric_limits<double>::quiet_NaN(), 1, 1, 2, 3, 4;
  EXPECT_EQ(boxOf(points).max(), Vector3(2, 3, 4));
}

TEST(SpherePattern, CellsGrowWithTheMesh) {
  EXPECT_EQ(cellsFor(0), 4);
  EXPECT_EQ(cellsFor(872), 4);
  EXPECT_EQ(cellsFor(4000), 8);
  EXPECT_EQ(cellsFor(12000), 14);
  EXPECT_EQ(cellsFor(10'000'000), 16);
}

}  // namespace
}  // namespace sphere_propagation::test
