// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/volume/slice_holes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace sphere_propagation {
namespace {

/// Slices drawn by rows: # inside.
Mask maskOf(const std::vector<std::vector<std::string>>& slices) {
  const auto nx = static_cast<int>(slices[0][0].size()), ny = static_cast<int>(slices[0].size());
  Mask mask(Eigen::Vector3i(nx, ny, static_cast<int>(slices.size())));
  for (int k = 0; k < mask.size[2]; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        mask(i, j, k) =
            slices[static_cast<size_t>(k)][static_cast<size_t>(j)][static_cast<size_t>(i)] == '#';
  return mask;
}

const std::vector<std::string> ring{"........", ".####...", ".#..#...",
                                    ".#..#...", ".####...", "........"};
const std::vector<std::string> movedRing{"........", "...####.", "...#..#.",
                                         "...#..#.", "...####.", "........"};  // by its width
const std::vector<std::string> aside{"........", "..####..", "..#..#..",
                                     "..#..#..", "..####..", "........"};
const std::vector<std::string> disc{"........", "........", "..##....",
                                    "..##....", "........", "........"};
const std::vector<std::string> open{"........", ".####...", ".#......",
                                    ".#......", ".####...", "........"};
const std::vector<std::string> diamond{"........", "...#....", "..#.#...",
                                       ".#...#..", "..#.#...", "...#...."};
const std::vector<std::string> nothing(6, "........");

TEST(SliceHoles, AreWhatTheSliceEncloses) {
  const Mask mask = maskOf({ring, open, nothing});
  const SliceHoles holes(mask);
  EXPECT_TRUE(holes.has(0));
  EXPECT_FALSE(holes.has(1) || holes.has(2));
  EXPECT_EQ(std::count(holes.holes().values.begin(), holes.holes().values.end(), 1), 4);
  EXPECT_EQ(holes.holes()(2, 2, 0), 1);
  for (size_t v = 0; v < mask.values.size(); ++v)
    EXPECT_EQ(holes.filled().values[v], mask.values[v] + holes.holes().values[v]);
}

TEST(SliceHoles, NeedNoWallThickerThanADiagonal) {
  Mask mask = maskOf({diamond});
  mask(3, 5, 0) = 0;  // the border is outside
  EXPECT_FALSE(SliceHoles(mask).has(0));
  mask = Mask(Eigen::Vector3i(8, 7, 1));
  for (const auto& [i, j] :
       {std::pair(3, 1), {2, 2}, {4, 2}, {1, 3}, {5, 3}, {2, 4}, {4, 4}, {3, 5}})
    mask(i, j, 0) = 1;
  const SliceHoles holes(mask);
  EXPECT_EQ(std::count(holes.holes().values.begin(), holes.holes().values.end(), 1), 5);
}

TEST(SliceHoles, LeadThroughWhereTheyOverlapOrAreClosed) {
  const SliceHoles holes(maskOf({ring, aside, disc, open, movedRing, nothing, ring}));
  EXPECT_TRUE(holes.leadThrough(0, 1) && holes.leadThrough(1, 0));   // overlap
  EXPECT_TRUE(holes.leadThrough(0, 2) && holes.leadThrough(2, 0));   // closed by the disc
  EXPECT_FALSE(holes.leadThrough(0, 3) || holes.leadThrough(3, 0));  // opens to the side
  EXPECT_FALSE(holes.leadThrough(2, 3));                             // no hole at all
  EXPECT_FALSE(holes.leadThrough(0, 5));
  EXPECT_TRUE(holes.leadThrough(0, 6));
}

}  // namespace
}  // namespace sphere_propagation
