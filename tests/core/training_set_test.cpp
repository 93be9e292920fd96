// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/training_set.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/core/test_shapes.h"
#include "vcg_ext/base/error.h"

namespace sphere_propagation {
namespace {

std::string refusal(const std::vector<TrainingSet::Shape>& shapes, const Triangles& faces) {
  try {
    const TrainingSet set(shapes, faces);
  } catch (const ParameterError& error) {
    return error.what();
  }
  return "";
}

bool contains(const std::string& text, const std::string& words) {
  return text.find(words) != std::string::npos;
}

TEST(TrainingSet, KeepsWhatItIsGiven) {
  const auto mesh = test::icosahedron();
  const TrainingSet set({{"a", mesh.vertices}, {"b", 2 * mesh.vertices}}, mesh.faces);
  EXPECT_EQ(set.shapeCount(), 2);
  EXPECT_EQ(set.landmarkCount(), 12);
  EXPECT_EQ(set.shapes()[1].name, "b");
  EXPECT_EQ(set.faces(), mesh.faces);
}

TEST(TrainingSet, LeavesLandmarksOut) {
  const auto mesh = test::icosahedron();
  const TrainingSet set({{"a", mesh.vertices}, {"b", 2 * mesh.vertices}}, mesh.faces);
  std::vector<char> leave(12, 0);
  leave[0] = leave[7] = 1;
  const TrainingSet some = set.without(leave);
  EXPECT_EQ(some.leftOut(), leave);
  ASSERT_EQ(some.landmarkCount(), 10);
  EXPECT_EQ(some.shapes()[1].landmarks.row(0), 2 * mesh.vertices.row(1));
  EXPECT_EQ(some.shapes()[1].landmarks.row(6), 2 * mesh.vertices.row(8));
  const bool neighbours = [&] {
    for (int f = 0; f < 20; ++f)
      if ((mesh.faces.row(f).array() == 0).any() && (mesh.faces.row(f).array() == 7).any())
        return true;
    return false;
  }();
  EXPECT_EQ(some.faces().rows(), neighbours ? 12 : 10);
  EXPECT_LT(some.faces().maxCoeff(), 10);

  std::vector<char> again(10, 0);
  again[6] = 1;  // what was the eighth
  leave[8] = 1;
  EXPECT_EQ(some.without(again).leftOut(), leave);
  EXPECT_TRUE(set.leftOut().empty());
  EXPECT_THROW(set.without(std::vector<char>(12, 1)), ParameterError);
}

TEST(TrainingSet, NamesTheShapesThatDoNotCorrespond) {
  const auto small = test::octahedron(), large = test::icosahedron();
  const std::string text =
      refusal({{"a", large.vertices}, {"b", large.vertices}, {"c", small.vertices}}, large.faces);
  for (const char* words : {"\"a\"", "\"c\"", "12", "6"})
    EXPECT_TRUE(contains(text, words)) << text;
  EXPECT_FALSE(contains(text, "\"b\"")) << text;
}

TEST(TrainingSet, NeedsTwoShapes) {
  const auto mesh = test::icosahedron();
  EXPECT_TRUE(contains(refusal({}, mesh.faces), "no shape"));
  EXPECT_TRUE(contains(refusal({{"only", mesh.vertices}}, mesh.faces), "\"only\""));
  EXPECT_TRUE(contains(refusal({{"a", Points(0, 3)}, {"b", Points(0, 3)}}, Triangles(0, 3)),
                       "no landmarks"));
}

TEST(TrainingSet, CountsWhatIsNotFinite) {
  const auto mesh = test::icosahedron();
  Points bad = mesh.vertices;
  bad(7, 1) = std::numeric_limits<double>::quiet_NaN();
  bad(9, 0) = bad(9, 2) = std::numeric_limits<double>::infinity();
  const std::string text = refusal({{"good", mesh.vertices}, {"bad", bad}}, mesh.faces);
  for (const char* words : {"\"bad\"", "2 landmarks", "landmark 7"})
    EXPECT_TRUE(contains(text, words)) << text;
}

TEST(TrainingSet, RefusesFacesOfLandmarksThatAreNotThere) {
  const auto mesh = test::icosahedron();
  Triangles faces = mesh.faces;
  faces(3, 2) = 12;
  EXPECT_TRUE(contains(refusal({{"a", mesh.vertices}, {"b", mesh.vertices}}, faces), "Face 3"));
}

}  // namespace
}  // namespace sphere_propagation
