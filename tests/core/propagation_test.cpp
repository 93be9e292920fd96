// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/propagation.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <string>
#include <thread>
#include <vector>

#include "tests/core/sizes.h"
#include "tests/core/test_meshes.h"
#include "tests/core/test_pool.h"
#include "vcg_ext/area/area_restoration.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/propagation/aligned/aligned_propagation.h"
#include "vcg_ext/propagation/motion/motion_propagation.h"
#include "vcg_ext/sphere/certificate.h"

namespace sphere_propagation {
namespace {

using test::pool;

using test::largestDistance;
using test::Mesh;
using test::sizeFor;

Eigen::Matrix3d turnAbout(const Vector3& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

/// Hills and hollows, as deep as this share of the radius.
ClosedSurface wavy(const ClosedSurface& surface, double height) {
  Points points = surface.vertices();
  const Eigen::RowVector3d centre = points.colwise().mean();
  for (Eigen::Index v = 0; v < points.rows(); ++v) {
    const Eigen::RowVector3d d = (points.row(v) - centre).normalized();
    const double wave = std::sin(7 * d[0]) * std::sin(7 * d[1]) + std::sin(7 * d[2]);
    points.row(v) = centre + (1 + height * wave) * (points.row(v) - centre);
  }
  return surface.withVertices(points);
}

/// An ellipsoid that grows thinner, on meshes that have nothing to do with each other.
struct Phases {
  std::vector<ClosedSurface> surfaces;
  explicit Phases(int layers, const Eigen::Matrix3d& rotation = Eigen::Matrix3d::Identity(),
                  int frequency = sizeFor(6, 4)) {
    for (int i = 0; i < layers; ++i) {
      // Turning the sphere before it is stretched gives the same ellipsoid by other vertices.
      Mesh mesh = test::transformed(test::icosphereMesh(frequency + i % 2),
                                    test::randomRotation(100 + i), 1, Vector3::Zero());
      mesh.vertices *= Vector3(30, 20 - i, 15 - 0.5 * i).asDiagonal();
      surfaces.push_back(surfaceOf(test::transformed(mesh, rotation, 1, Vector3(5, i, 0)),
                                   "phase " + std::to_string(i)));
    }
  }
  MappedSurface map(
      int layer) const {  // the central projection: valid for what is convex about its middle
    Points positions = surfaces[layer].vertices();
    positions.rowwise() -= positions.colwise().mean().eval();
    positions.rowwise().normalize();
    return MappedSurface(surfaces[layer], positions);
  }
  /// The same with the second layer in another place.
  std::vector<ClosedSurface> withSecondMoved(const Eigen::Matrix3d& rotation, double scale,
                                             const Vector3& shift) const {
    std::vector<ClosedSurface> layers;
    for (size_t i = 0; i < surfaces.size(); ++i) {
      const Mesh mesh{surfaces[i].vertices(), surfaces[i].faces()};
      layers.push_back(i == 1
                           ? surfaceOf(test::transformed(mesh, rotation, scale, shift), "elsewhere")
                           : surfaces[i]);
    }
    return layers;
  }
};

TEST(AlignedPropagation, ToTheSameSurfaceIsTheIdentity) {
  const ClosedSurface surface = surfaceOf(test::noisyEllipsoid(1));
  const MappedSurface map(surface, test::icosphereMesh(8).vertices);
  const TransferredMap result = propagateAligned(map, surface);
  EXPECT_LT(largestDistance(result.map.positions(), map.positions()), 1e-12);
  EXPECT_EQ(result.repairedFaces, 0);
  EXPECT_LT(result.residual.mean, 1e-12);
  EXPECT_LT(result.residual.p95, 1e-12);
}

TEST(AlignedPropagation, ToARigidlyMovedCopyIsTheIdentity) {
  const Mesh mesh = test::noisyEllipsoid(2);
  const ClosedSurface reference = surfaceOf(mesh);
  const MappedSurface map(reference, test::icosphereMesh(8).vertices);
  const Mesh moved =
      test::transformed(mesh, turnAbout(Vector3(1, 2, 3), 0.15), 1, Vector3(100, 0, -7));
  const TransferredMap result = propagateAligned(map, surfaceOf(moved));
  EXPECT_LT(largestDistance(result.map.positions(), map.positions()), 1e-9);
  EXPECT_LT(result.residual.p95, 1e-9);
}

TEST(AlignedPropagation, FollowsADilation) {
  const Mesh mesh = test::noisyEllipsoid(3);
  const ClosedSurface reference = surfaceOf(mesh);
  const MappedSurface map(reference, test::icosphereMesh(8).vertices);
  Mesh dilated = mesh;
  dilated.vertices *= Vector3(1.1, 0.95, 0.9).asDiagonal();
  const TransferredMap result = propagateAligned(map, surfaceOf(dilated));
  EXPECT_LT((result.map.positions() - map.positions()).rowwise().norm().mean(), 0.03);
}

TEST(AlignedPropagation, TurnsWithTheSurfacesAndIgnoresScale) {
  const Phases sequence(2);
  const MappedSurface map = sequence.map(0);
  const TransferredMap here = propagateAligned(map, sequence.surfaces[1]);
  const Eigen::Matrix3d rotation = test::randomRotation(7);
  for (double scale : {0.01, 1.0, 1000.0}) {
    const auto moved = [&](int i) {
      const ClosedSurface& surface = sequence.surfaces[i];
      return surfaceOf(test::transformed({surface.vertices(), surface.faces()}, rotation, scale,
                                         Vector3(9, i, -40)));
    };
    const ClosedSurface reference = moved(0), target = moved(1);
    const TransferredMap there =
        propagateAligned(MappedSurface(reference, map.positions()), target);
    EXPECT_LT(largestDistance(there.map.positions(), here.map.positions()), 1e-9);
    EXPECT_NEAR(there.residual.mean, scale * here.residual.mean, 1e-9 * scale);
  }
}

TEST(Propagation, GoesAlongTheTree) {
  const Phases sequence(5);
  for (const PropagationTree& tree :
       {timeOrder(5, 2), cyclicTimeOrder(5, 2), star(5, 2), givenOrder({4, 0, -1, 2, 2})}) {
    const MappedSurface root = sequence.map(2);
    const std::vector<PropagatedLayer> layers = propagate(sequence.surfaces, root, tree).layers;
    ASSERT_EQ(layers.size(), 5U);
    for (int i = 0; i < 5; ++i) {
      EXPECT_EQ(layers[i].parent, tree.parent[i]);
      EXPECT_TRUE(certify(sequence.surfaces[i].faces(), layers[i].map().positions()).valid());
      if (i == 2) continue;
      EXPECT_GT(layers[i].seconds, 0);
      // The ellipsoids are images of each other, and the map says so.
      EXPECT_LT((layers[i].map().positions() - sequence.map(i).positions()).rowwise().norm().mean(),
                0.1)
          << i;
    }
    EXPECT_EQ(layers[2].map().positions(), root.positions());
    EXPECT_EQ(layers[2].transferred.repairedFaces, 0);
    EXPECT_EQ(layers[2].transferred.residual.mean, 0);
    EXPECT_EQ(layers[2].seconds, 0);
  }
}

TEST(Propagation, FindsALayerInAnotherPose) {
  const Phases sequence(3, Eigen::Matrix3d::Identity(), 6);
  const MappedSurface root = sequence.map(0);
  const std::vector<ClosedSurface> surfaces =
      sequence.withSecondMoved(turnAbout(Vector3(1, 2, 3), 0.4), 1, Vector3(200, 0, 0));
  const PropagationTree tree = timeOrder(3, 0);
  ASSERT_FALSE(followMotion(surfaces, root, tree, pool).layers[1]);
  const std::vector<PropagatedLayer> layers = propagate(surfaces, root, tree).layers;
  for (const PropagatedLayer& layer : layers) EXPECT_EQ(layer.route, Route::Method);
  EXPECT_TRUE(layers[1].pose.moved);
  EXPECT_FALSE(layers[2].pose.moved);
  EXPECT_LT((layers[1].map().positions() - sequence.map(1).positions()).rowwise().norm().mean(),
            0.1);
  EXPECT_LT((layers[2].map().positions() - sequence.map(2).positions()).rowwise().norm().mean(),
            0.1);
}

TEST(Propagation, GoesArcByArcWhereTheMotionIsLost) {
  // The second layer is all spikes: no fit of neighbours in time follows that.
  const Phases sequence(3);
  const MappedSurface root = sequence.map(0);
  std::vector<ClosedSurface> surfaces = sequence.surfaces;
  Mesh fine = test::icosphereMesh(24);  // whose edges are short
  fine.vertices *= Vector3(30, 19, 14.5).asDiagonal();
  surfaces[1] = wavy(
      surfaceOf(test::transformed(fine, Eigen::Matrix3d::Identity(), 1, Vector3(5, 1, 0))), 0.35);
  const PropagationTree tree = timeOrder(3, 0);
  const std::vector<PropagatedLayer> layers = propagate(surfaces, root, tree).layers;
  ASSERT_FALSE(layers[1].pose.moved);
  ASSERT_FALSE(followMotion(surfaces, root, tree, pool).layers[1]);
  const TransferredMap arc = propagateAligned(root, surfaces[1]);
  EXPECT_EQ(layers[1].route, Route::Alignment);
  EXPECT_EQ(layers[0].route, Route::Method);
  EXPECT_EQ(layers[1].map().positions(), arc.map.positions());
  EXPECT_EQ(layers[1].transferred.repairedFaces, arc.repairedFaces);
  EXPECT_EQ(layers[1].transferred.residual.mean, arc.residual.mean);
  EXPECT_EQ(layers[1].transferred.residual.p95, arc.residual.p95);
}

TEST(Propagation, AsPublishedTakesItsParameters) {
  const Phases sequence(3);
  const MappedSurface root = sequence.map(0);
  PropagationParameters parameters;
  parameters.method = PropagationMethod::AsPublished;
  parameters.published.smoothingSweeps = 3;
  const std::vector<PropagatedLayer> layers =
      propagate(sequence.surfaces, root, timeOrder(3, 0), parameters).layers;
  const TransferredMap arc =
      propagateAsPublished(layers[1].map(), sequence.surfaces[2], parameters.published);
  EXPECT_EQ(layers[2].map().positions(), arc.map.positions());
  EXPECT_EQ(layers[2].transferred.residual.p95, arc.residual.p95);
  EXPECT_NE(layers[2].map().positions(),
            propagate(sequence.surfaces, root, timeOrder(3, 0)).layers[2].map().positions());
}

TEST(Propagation, WhatIsRestoredDoesNotGoDownTheTree) {
  const Phases sequence(3);
  const MappedSurface root = sequence.map(0);
  const PropagationTree tree = timeOrder(3, 0);
  const std::vector<PropagatedLayer> plain = propagate(sequence.surfaces, root, tree).layers;
  const std::vector<PropagatedLayer> restored =
      propagate(sequence.surfaces, root, tree, {PropagationMethod::Robust, {}, 0.5}).layers;
  EXPECT_EQ(restored[0].map().positions(), root.positions());
  for (int i : {1, 2}) {
    EXPECT_EQ(restored[i].map().positions(), restoreArea(plain[i].map(), 0.5).positions());
    EXPECT_NE(restored[i].map().positions(), plain[i].map().positions());
    EXPECT_EQ(restored[i].transferred.residual.mean, plain[i].transferred.residual.mean);
  }
}

TEST(Propagation, TellsItsProgress) {
  const Phases sequence(4);
  for (double restoration : {0.0, 0.3}) {
    std::vector<double> told;
    const std::thread::id here = std::this_thread::get_id();
    propagate(sequence.surfaces, sequence.map(1), timeOrder(4, 1),
              {PropagationMethod::Robust, {}, restoration}, [&](double fraction) {
                EXPECT_EQ(std::this_thread::get_id(), here);
                if (!told.empty()) {
                  EXPECT_GE(fraction, told.back());
                }
                told.push_back(fraction);
              });
    EXPECT_EQ(told.front(), 0);
    EXPECT_DOUBLE_EQ(told.back(), 1);
    EXPECT_GE(told.size(), 4U);
  }
}

TEST(Propagation, OneLayerIsTheRoot) {
  const Phases sequence(1);
  std::vector<double> told;
  const std::vector<PropagatedLayer> layers =
      propagate(sequence.surfaces, sequence.map(0), star(1, 0), {}, [&](double fraction) {
        told.push_back(fraction);
      }).layers;
  ASSERT_EQ(layers.size(), 1U);
  EXPECT_EQ(layers[0].parent, -1);
  EXPECT_EQ(told.back(), 1);
}

TEST(Propagation, ComparesTheBranchesOfACycle) {
  const Phases sequence(5);
  const MappedSurface root = sequence.map(0);
  PropagationParameters parameters;
  const Propagation open = propagate(sequence.surfaces, root, cyclicTimeOrder(5, 0), parameters);
  EXPECT_FALSE(open.closing);
  for (PropagationMethod method : {PropagationMethod::Robust, PropagationMethod::AsPublished}) {
    parameters.method = method;
    parameters.closing = closingArc(5, 0);
    const Propagation closed =
        propagate(sequence.surfaces, root, cyclicTimeOrder(5, 0), parameters);
    ASSERT_TRUE(closed.closing);
    EXPECT_GT(closed.closing->distance.mean, 0);
    EXPECT_LT(closed.closing->distance.mean, 3);  // of an ellipsoid with semi-axes of 30, 16 and 13
    EXPECT_LT(closed.closing->angle.mean, 15);
    EXPECT_LE(closed.closing->distance.mean, closed.closing->distance.p95);
    EXPECT_EQ(closed.averaged, method == PropagationMethod::Robust ? 4 : 0);
    if (method == PropagationMethod::AsPublished) continue;
    EXPECT_EQ(closed.layers[0].map().positions(), open.layers[0].map().positions());
    for (size_t i = 1; i < 5;
         ++i) {  // both ways round are averaged; who hands the map to whom stays the tree's
      EXPECT_EQ(closed.layers[i].parent, open.layers[i].parent);
      EXPECT_NE(closed.layers[i].map().positions(), open.layers[i].map().positions());
      EXPECT_LT(differenceOf(closed.layers[i].map(), open.layers[i].map()).distance.mean, 1);
    }
  }
  parameters.closing = Arc{0, 5};
  EXPECT_THROW(propagate(sequence.surfaces, root, cyclicTimeOrder(5, 0), parameters),
               ParameterError);
}

TEST(Propagation, KeepsTheDistancesThatTheResidualIsMadeOf) {
  const Phases sequence(3);
  for (PropagationMethod method : {PropagationMethod::Robust, PropagationMethod::AsPublished}) {
    PropagationParameters parameters;
    parameters.method = method;
    const Propagation made =
        propagate(sequence.surfaces, sequence.map(0), timeOrder(3, 0), parameters);
    for (size_t i = 0; i < 3; ++i) {
      const PropagatedLayer& layer = made.layers[i];
      ASSERT_EQ(layer.transferred.distances.size(),
                static_cast<size_t>(sequence.surfaces[i].vertexCount()));
      EXPECT_EQ(residualOf(layer.transferred.distances).mean, layer.transferred.residual.mean);
    }
    EXPECT_EQ(residualOf(made.layers[0].transferred.distances).p95, 0);
  }
}

TEST(Propagation, RefusesLayersInDifferentUnits) {
  const Phases sequence(3);
  const MappedSurface root = sequence.map(0);
  std::vector<ClosedSurface> larger;  // than the root, which is the odd one
  for (size_t i = 0; i < 3; ++i)
    larger.emplace_back(sequence.surfaces[i].vertices() * (i > 0 ? 1000 : 1),
                        sequence.surfaces[i].faces(), "phase " + std::to_string(i));
  try {
    propagate(larger, root, timeOrder(3, 0));
    FAIL();
  } catch (const ParameterError& error) {
    EXPECT_NE(std::string(error.what()).find("\"phase 0\" is "), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("smaller"), std::string::npos) << error.what();
  }
  for (double scale : {0.001, 1000.0, 1e-30, 1e30}) {
    std::vector<ClosedSurface> surfaces;
    for (size_t i = 0; i < 3; ++i)
      surfaces.emplace_back(sequence.surfaces[i].vertices() * (i == 1 ? scale : 1),
                            sequence.surfaces[i].faces(), "phase " + std::to_string(i));
    try {
      propagate(surfaces, root, timeOrder(3, 0));
      FAIL() << scale;
    } catch (const ParameterError& error) {
      EXPECT_NE(std::string(error.what()).find("phase 1"), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find("phase 0"), std::string::npos) << error.what();
    }
    PropagationParameters parameters;
    parameters.method = PropagationMethod::AsPublished;  // scales each layer to its parent
    if (scale > 1e-6 && scale < 1e6) {
      EXPECT_NO_THROW(propagate(surfaces, root, timeOrder(3, 0), parameters));
    }
  }
  const std::vector<PropagatedLayer> layers =
      propagate(sequence.surfaces, root, timeOrder(3, 0)).layers;
  EXPECT_FALSE(layers[0].size.standsOut);
  EXPECT_LT(layers[1].size.relative, 1.5);
}

TEST(Propagation, ALayerInAnotherUnitGetsTheMapThatItWouldHave) {
  const Phases sequence(5);
  const std::vector<PropagatedLayer> plain =
      propagate(sequence.surfaces, sequence.map(0), timeOrder(5, 0)).layers;
  std::vector<double> scales{0.1, 1 / 25.4, 3.0, 10.0};
  scales.resize(static_cast<size_t>(sizeFor(4, 1)));
  for (const double scale : scales)
    for (const int odd : {0, 2}) {
      std::vector<ClosedSurface> surfaces = sequence.surfaces;
      const auto k = static_cast<size_t>(odd);
      surfaces[k] = surfaces[k].withVertices(scale * surfaces[k].vertices());
      const MappedSurface root(surfaces[0], sequence.map(0).positions());
      const std::vector<PropagatedLayer> layers = propagate(surfaces, root, timeOrder(5, 0)).layers;
      for (size_t i = 0; i < 5; ++i) {
        EXPECT_EQ(layers[i].size.standsOut, i == k) << scale << " " << i;
        EXPECT_FALSE(layers[i].residualStandsOut);
        EXPECT_EQ(layers[i].route, Route::Method);
        EXPECT_LT(
            (layers[i].map().positions() - plain[i].map().positions()).rowwise().norm().mean(),
            scale == 3 ? 0.1 : 1e-3)
            << scale << " " << i;
        const double unit = i == k ? scale : 1;
        if (scale != 3) {
          EXPECT_NEAR(layers[i].transferred.residual.mean / unit,
                      plain[i].transferred.residual.mean, 1e-3);
        }
      }
    }
}

TEST(Propagation, AResidualStandsOutAgainstTheOthers) {
  const Phases sequence(6);
  std::vector<PropagatedLayer> layers =
      propagate(sequence.surfaces, sequence.map(0), timeOrder(6, 0)).layers;
  const auto found = [&](const std::vector<double>& edges) {
    for (size_t i = 0; i < 6; ++i)
      layers[i].transferred.residual.mean =
          edges[i] * PreparedSurface(sequence.surfaces[i]).meanEdge();
    return residualsThatStandOut(sequence.surfaces, layers);
  };
  EXPECT_EQ(found({0, 0.1, 0.12, 0.15, 0.1, 0.11}), std::vector<char>(6, 0));
  EXPECT_EQ(found({0, 0.1, 0.12, 0.9, 0.1, 0.11}), (std::vector<char>{0, 0, 0, 1, 0, 0}));
  EXPECT_EQ(found({0, 0.1, 0.12, 0.45, 0.1, 0.11}), std::vector<char>(6, 0));  // on its surface
  EXPECT_EQ(found({0, 0.3, 0.6, 0.9, 0.2, 0.4}), std::vector<char>(6, 0));     // no two are alike
}

TEST(Propagation, IsTheSameWithAnyNumberOfThreads) {
  const Phases sequence(13);
  PropagationParameters parameters;
  for (const PropagationTree& tree : {cyclicTimeOrder(13, 3), star(13, 0)}) {
    const MappedSurface root = sequence.map(tree.root());
    parameters.threads = 3;
    const Propagation one = propagate(sequence.surfaces, root, tree, parameters);
    ASSERT_TRUE(one.learnt);
    if (test::underSanitizer()) continue;  // a second run meets what the first did
    for (const int threads : {1, 2, 7}) {
      parameters.threads = threads;
      const Propagation many = propagate(sequence.surfaces, root, tree, parameters);
      for (size_t i = 0; i < 13; ++i) {
        EXPECT_EQ(many.layers[i].map().positions(), one.layers[i].map().positions());
        EXPECT_EQ(many.layers[i].transferred.residual.mean,
                  one.layers[i].transferred.residual.mean);
      }
      EXPECT_EQ(many.learnt->rotation, one.learnt->rotation);
    }
  }
  parameters.threads = -1;
  EXPECT_THROW(propagate(sequence.surfaces, sequence.map(0), star(13, 0), parameters),
               ParameterError);
}

TEST(Propagation, AnErrorNamesTheLayer) {
  // A flat double cover, and the same with its faces reversed: each side is read off the other.
  Mesh flat = test::tetrahedron(), reversed;
  flat.vertices << 3, 1, 0, -3, 2, 0, -2, -1, 0, 2, -2, 0;
  reversed = flat;
  reversed.faces.col(1).swap(reversed.faces.col(2));
  const std::vector<ClosedSurface> surfaces = {surfaceOf(flat, "first phase"),
                                               surfaceOf(flat, "second phase"),
                                               surfaceOf(reversed, "third phase")};
  const MappedSurface root(surfaces[0], test::tetrahedron().vertices);
  PropagationParameters parameters;
  parameters.method = PropagationMethod::AsPublished;
  parameters.published.smoothingSweeps = 0;  // four vertices shrink to a point
  try {
    propagate(surfaces, root, timeOrder(3, 0), parameters);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.finding().name, "third phase");
    EXPECT_EQ(error.finding().other, "second phase");
  }
  // The motion model fits no flat shape, but what can be mended is no error.
  const std::vector<PropagatedLayer> layers = propagate(surfaces, root, timeOrder(3, 0)).layers;
  for (size_t i = 0; i < 3; ++i)
    EXPECT_TRUE(certify(surfaces[i].faces(), layers[i].map().positions()).valid());
}

TEST(Propagation, RefusesWhatDoesNotFit) {
  const Phases sequence(3);
  const MappedSurface root = sequence.map(0);
  EXPECT_THROW(propagate(std::vector<ClosedSurface>(), root, star(1, 0)), ParameterError);
  EXPECT_THROW(propagate(sequence.surfaces, root, star(2, 0)), ParameterError);
  EXPECT_THROW(propagate(sequence.surfaces, root, star(3, 1)),
               ParameterError);  // other faces
  for (double restoration : {-0.1, 1.1})
    EXPECT_THROW(propagate(sequence.surfaces, root, star(3, 0),
                           {PropagationMethod::Robust, {}, restoration}),
                 ParameterError);
}

}  // namespace
}  // namespace sphere_propagation
