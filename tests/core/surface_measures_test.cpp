// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/surface_measures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/core/test_shapes.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/mesh/icosphere.h"
#include "vcg_ext/model/procrustes.h"

namespace sphere_propagation {
namespace {

/// Shapes that are sampled from surfaces, as the filters have them.
struct Sampled {
  std::vector<Points> landmarks;
  Triangles faces;
  std::vector<SampledSurface> surfaces;

  SurfaceMeasures measures(Alignment alignment = Alignment::None,
                           const SurfaceMeasureParameters& parameters = {}) const {
    const TrainingSet given = test::trainingSet(landmarks, faces);
    ProcrustesParameters procrustes;
    procrustes.alignment = alignment;
    const TrainingSet aligned = alignShapes(given, procrustes).shapes;
    return measureSurfaces(buildShapeModel(aligned), given, aligned, surfaces, parameters);
  }
};

/// Where a map of a sphere to itself puts the vertices of an icosphere.
template <class Moved>
Points movedIcosphere(int frequency, const Moved& moved) {
  Points points = icosphere(frequency).vertices;
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    points.row(i) = moved(Vector3(points.row(i).transpose())).transpose();
  return points;
}

/// Spheres of these radii.
Sampled spheres(const std::vector<double>& radii) {
  Sampled sampled;
  sampled.faces = icosphere(8).faces;
  for (const double radius : radii) {
    sampled.landmarks.push_back(radius * icosphere(8).vertices);
    sampled.surfaces.push_back({radius * icosphere(16).vertices, icosphere(16).faces});
  }
  return sampled;
}

TEST(SurfaceMeasures, OfSpheresAreDifferencesOfRadii) {
  const Sampled sampled = spheres({9, 10, 12, 13});
  const SurfaceMeasures measures = sampled.measures();
  ASSERT_EQ(measures.generalisation.size(), 1);
  // What facets of a sphere of frequency 8 cut off: below a mean of 0.7 h^2 / 8 R, h the edge.
  for (Eigen::Index i = 0; i < 4; ++i) {
    EXPECT_GT(measures.offSurface[i], 0);
    EXPECT_LT(measures.offSurface[i], 0.005 * 13);
  }
  EXPECT_EQ(measures.foldedFaces, Eigen::VectorXi::Zero(4));
  EXPECT_LT(measures.generalisation[0], 0.005 * 13);  // the others make any radius
  // A sample has the radius r = 11 + s g, s^2 = 10 / 3.
  EXPECT_NEAR(measures.specificity[0], 0.543, 0.12);  // E min |r - r_i|, and what facets add
  EXPECT_GT(measures.specificityError[0], 0.02);
  EXPECT_LT(measures.specificityError[0], 0.1);
}

TEST(SurfaceMeasures, WithoutAModeThatTheOthersLack) {
  // Two spheres: without one of them there is the other, a tenth smaller or larger.
  SurfaceMeasureParameters parameters;
  parameters.samples = 1;
  const SurfaceMeasures measures = spheres({10, 11}).measures(Alignment::None, parameters);
  EXPECT_NEAR(measures.generalisation[0], 1, 0.03);
}

TEST(SurfaceMeasures, AreThoseOfAnyPoseAndUnit) {
  const Sampled sampled = spheres({9, 10, 12});
  Sampled moved = sampled;
  for (size_t k = 0; k < moved.landmarks.size(); ++k)
    for (Points* points : {&moved.landmarks[k], &moved.surfaces[k].vertices})
      *points = test::moved(*points, test::randomRotation(static_cast<unsigned>(k) + 3), 10,
                            Vector3(1, static_cast<double>(k), -5));
  SurfaceMeasureParameters parameters;
  parameters.samples = 20;
  const SurfaceMeasures here = sampled.measures(Alignment::Rigid, parameters),
                        there = moved.measures(Alignment::Rigid, parameters);
  EXPECT_LT((10 * here.offSurface - there.offSurface).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_LT((10 * here.generalisation - there.generalisation).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_LT((10 * here.specificity - there.specificity).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(SurfaceMeasures, SeeLandmarksThatGather) {
  // Bumps at different places of a sphere; landmarks that all sit on the other half know nothing of
  // them, and make a model without variance.
  const auto surface = [](double longitude) {
    const Vector3 top(std::cos(longitude), std::sin(longitude), 0.5);
    return SampledSurface{movedIcosphere(10,
                                         [&](const Vector3& u) -> Vector3 {
                                           const double c = u.dot(top.normalized());
                                           return 10 * (1 + 0.5 * std::exp(20 * (c - 1))) * u;
                                         }),
                          icosphere(10).faces};
  };
  Sampled gathered, spread;
  gathered.faces = spread.faces = icosphere(10).faces;
  for (const double longitude : {0.0, 0.3, 0.6, 0.9}) {
    gathered.surfaces.push_back(surface(longitude));
    spread.surfaces.push_back(surface(longitude));
    spread.landmarks.push_back(surface(longitude).vertices);
    gathered.landmarks.push_back(movedIcosphere(10, [](const Vector3& u) -> Vector3 {
      return 10 * (u - Vector3(0, 0, 2.5)).normalized();
    }));
  }
  SurfaceMeasureParameters parameters;
  parameters.samples = 1;
  const SurfaceMeasures few = gathered.measures(Alignment::None, parameters),
                        all = spread.measures(Alignment::None, parameters);
  EXPECT_EQ(few.generalisation.size(), 0);  // identical landmarks: a model without modes
  EXPECT_GT(few.offSurface.minCoeff(), 20 * all.offSurface.maxCoeff());
  EXPECT_GT(few.foldedFaces.minCoeff(), 0);  // the sphere's other half lies on this one
}

TEST(SurfaceMeasures, CountFacesThatFold) {
  Sampled sampled = spheres({9, 10});
  sampled.landmarks[1].row(7).swap(sampled.landmarks[1].row(300));
  SurfaceMeasureParameters parameters;
  parameters.samples = 1;
  const SurfaceMeasures measures = sampled.measures(Alignment::None, parameters);
  EXPECT_EQ(measures.foldedFaces[0], 0);
  EXPECT_GT(measures.foldedFaces[1], 0);
}

TEST(SurfaceMeasures, AreTheSameWithAnyNumberOfThreads) {
  const Sampled sampled = spheres({9, 10, 12, 13});
  SurfaceMeasureParameters one, three;
  one.samples = three.samples = 20;
  one.threads = 1;
  three.threads = 3;
  const SurfaceMeasures a = sampled.measures(Alignment::Rigid, one),
                        b = sampled.measures(Alignment::Rigid, three);
  EXPECT_EQ(a.generalisation, b.generalisation);
  EXPECT_EQ(a.specificity, b.specificity);
  EXPECT_EQ(a.offSurface, b.offSurface);
}

TEST(SurfaceMeasures, RefuseParametersOutOfRange) {
  const Sampled sampled = spheres({9, 10});
  for (const auto& spoil : std::vector<void (*)(SurfaceMeasureParameters&)>{
           [](SurfaceMeasureParameters& p) { p.modes = -1; },
           [](SurfaceMeasureParameters& p) { p.points = 0; },
           [](SurfaceMeasureParameters& p) { p.samples = 0; },
           [](SurfaceMeasureParameters& p) { p.leftOut = 0; },
           [](SurfaceMeasureParameters& p) { p.threads = -1; }}) {
    SurfaceMeasureParameters parameters;
    spoil(parameters);
    EXPECT_THROW(sampled.measures(Alignment::None, parameters), ParameterError);
  }
  Sampled fewer = sampled;
  fewer.surfaces.pop_back();
  EXPECT_THROW(fewer.measures(), ParameterError);
}

}  // namespace
}  // namespace sphere_propagation
