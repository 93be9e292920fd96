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
