// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/morphing/morph.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/core/test_meshes.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/model/shape_model.h"
#include "vcg_ext/remeshing/icosphere_remesher.h"
#include "vcg_ext/sphere/certificate.h"

namespace sphere_propagation {
namespace {

/// Shapes that are no multiples of each other, on spheres that differ.
std::vector<MappedSurface> shapes(int count) {
  std::vector<MappedSurface> made;
  for (int k = 0; k < count; ++k) {
    const test::Mesh ball =
        test::transformed(test::icosphereMesh(4 + k),
                          test::randomRotation(static_cast<unsigned>(k)), 1, Vector3::Zero());
    Points positions = ball.vertices;
    positions.rowwise().normalize();
    const test::Mesh mesh = test::stretched(ball, 2 + k % 3, 2 + k % 2, 1 + std::sin(1.0 * k));
    made.emplace_back(surfaceOf(mesh, "shape " + std::to_string(k)), positions);
  }
  return made;
}

TEST(MorphPath, PassesThroughEachShapeAndIsSmooth) {
  for (const bool closed : {false, true})
    for (const MorphPath path : {MorphPath::Linear, MorphPath::ShapeModel}) {
      const int count = 5;
      for (int k = 0; k < count; ++k)
        EXPECT_LT((pathWeights(path, closed, count, k) - Eigen::VectorXd::Unit(count, k)).norm(),
                  1e-14);
      for (double t = 0; t < 4; t += 0.13)
        EXPECT_NEAR(pathWeights(path, closed, count, t).sum(), 1, 1e-14);
      const auto kink = [&](double t, double h) {  // of the velocity
        return ((pathWeights(path, closed, count, t + h) - pathWeights(path, closed, count, t)) -
                (pathWeights(path, closed, count, t) - pathWeights(path, closed, count, t - h)))
                   .norm() /
               h;
      };
      EXPECT_EQ(kink(2, 1e-4) > 0.5, path == MorphPath::Linear);
    }
  const Eigen::VectorXd end = pathWeights(MorphPath::ShapeModel, true, 5, 5 - 1e-12);
  EXPECT_LT((end - Eigen::VectorXd::Unit(5, 0)).norm(), 1e-10) << "back to the first";
}

TEST(MorphPath, KeepsLinesAndIsSymmetric) {
  Eigen::VectorXd values(6);
  values << 1, 3, 5, 7, 9, 11;
  EXPECT_NEAR(pathWeights(MorphPath::ShapeModel, false, 6, 3.3).dot(values), 1 + 2 * 3.3, 1e-13);
  EXPECT_LT((pathWeights(MorphPath::ShapeModel, false, 6, 1.2).reverse() -
             pathWeights(MorphPath::ShapeModel, false, 6, 3.8))
                .norm(),
            1e-13);
  EXPECT_EQ(pathWeights(MorphPath::ShapeModel, true, 2, 0.3), Eigen::Vector2d(0.7, 0.3));
}

TEST(Morph, BeginsAndEndsWithWhatIsGivenAndHasTheMeanInTheMiddle) {
  const std::vector<MappedSurface> given = shapes(2);
  MorphParameters parameters;
  const Morph morph = makeMorph(given, parameters);
  ASSERT_EQ(morph.shapes.size(), 5U);
  const IcosphereRemesher remesher(10);
  const Points a = remesher.remesh(given[0]).landmarks, b = remesher.remesh(given[1]).landmarks;
  const auto vertices = [&](size_t i) { return morph.shapes[i].map->surface().vertices(); };
  EXPECT_EQ(vertices(0), a);
  EXPECT_EQ(vertices(4), b);
  EXPECT_LT((vertices(2) - 0.5 * (a + b)).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_LT((vertices(1) - (0.75 * a + 0.25 * b)).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_EQ(morph.shapes[1].share, 0.25);
  EXPECT_EQ(morph.shapes[1].map->faces(), remesher.sphere().faces);
  parameters.ends = false;
  EXPECT_EQ(makeMorph(given, parameters).shapes.size(), 3U);
}

TEST(Morph, ByTheUnionIsBothSurfacesAtItsEnds) {
  const std::vector<MappedSurface> given = shapes(2);
  MorphParameters parameters;
  parameters.connectivity = MorphConnectivity::Union;
  const Morph morph = makeMorph(given, parameters);
  for (const MorphShape& shape : morph.shapes) {
    EXPECT_EQ(shape.map->vertexCount(),
              given[0].vertexCount() + given[1].vertexCount() + *morph.crossings[0]);
    EXPECT_TRUE(certify(shape.map->faces(), shape.map->positions()).valid());
    EXPECT_GT(shape.volume, 0);
  }
  for (const size_t end : {size_t{0}, size_t{1}}) {
    const ClosedSurface& surface = given[end].surface();
    EXPECT_NEAR(morph.shapes[end == 0 ? 0 : 4].volume,
                enclosedVolume(surface.vertices(), surface.faces()), 1e-9);
  }
  const Points middle =
      0.5 * (morph.shapes[0].map->surface().vertices() + morph.shapes[4].map->surface().vertices());
  EXPECT_LT((morph.shapes[2].map->surface().vertices() - middle).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(Morph, AlongTheModelIsASplineOfScores) {
  const std::vector<MappedSurface> given = shapes(5);
  const IcosphereRemesher remesher(3);
  std::vector<TrainingSet::Shape> training;
  for (const MappedSurface& surface : given)
    training.push_back({surface.surface().name(), remesher.remesh(surface).landmarks});
  const ShapeModel model = buildShapeModel(TrainingSet(training, remesher.sphere().faces));
  for (const bool closed : {false, true}) {
    MorphParameters parameters;
    parameters.frequency = 3;
    parameters.path = MorphPath::ShapeModel;
    parameters.closed = closed;
    const Morph morph = makeMorph(given, parameters);
    ASSERT_EQ(morph.shapes.size(), closed ? 21U : 17U);
    for (size_t i = 0; i < morph.shapes.size(); ++i) {
      const Eigen::VectorXd weights =
          pathWeights(MorphPath::ShapeModel, closed, 5, static_cast<double>(i) / 4);
      const Points expected = model.shape(model.scores.transpose() * weights);
      EXPECT_LT((morph.shapes[i].map->surface().vertices() - expected).cwiseAbs().maxCoeff(),
                1e-12);
    }
  }
  MorphParameters byUnion;
  byUnion.connectivity = MorphConnectivity::Union;
  byUnion.path = MorphPath::ShapeModel;
  EXPECT_EQ(makeMorph(given, byUnion).shapes.size(), 17U);
}

TEST(Morph, IsTheSameWithAnyNumberOfThreads) {
  const std::vector<MappedSurface> given = shapes(4);
  MorphParameters parameters;
  parameters.connectivity = MorphConnectivity::Union;
  parameters.threads = 1;
  const Morph alone = makeMorph(given, parameters);
  parameters.threads = 3;
  const Morph together = makeMorph(given, parameters);
  ASSERT_EQ(alone.shapes.size(), together.shapes.size());
  for (size_t i = 0; i < alone.shapes.size(); ++i)
    EXPECT_EQ(alone.shapes[i].map->surface().vertices(),
              together.shapes[i].map->surface().vertices());
}

TEST(Morph, GivesNoShapeThatEnclosesNothing) {
  const std::vector<MappedSurface> given = shapes(1);
  const Points turned =
      given[0].surface().vertices() * Eigen::Vector3d(-1, -1, 1).asDiagonal();  // half a turn
  const std::vector<MappedSurface> opposite{given[0],
                                            given[0].of(given[0].surface().withVertices(turned))};
  MorphParameters parameters;
  const Morph morph = makeMorph(opposite, parameters);
  EXPECT_TRUE(morph.shapes[1].map);
  EXPECT_FALSE(morph.shapes[2].map);
  EXPECT_NEAR(morph.shapes[2].volume, 0, 1e-12);
}

TEST(Morph, RefusesWhatIsNoMorph) {
  const std::vector<MappedSurface> given = shapes(2);
  MorphParameters parameters;
  EXPECT_THROW(makeMorph({given[0]}, parameters), ArgumentError);
  parameters.steps = 0;
  EXPECT_THROW(makeMorph(given, parameters), RangeError);
  parameters.steps = 10000;
  parameters.frequency = 100;
  EXPECT_THROW(makeMorph(given, parameters), RangeError);
}

TEST(Morph, NamesShapesByTheirShare) {
  EXPECT_EQ(nameOfMorph("a", "b", 0.25), "a to b 25 %");
  EXPECT_EQ(nameOfMorph("a", "b", 1.0 / 3), "a to b 33.33 %");
}

}  // namespace
}  // namespace sphere_propagation
