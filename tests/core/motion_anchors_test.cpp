// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/propagation/motion/motion_anchors.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "tests/core/sizes.h"
#include "tests/core/test_meshes.h"
#include "vcg_ext/base/error.h"
#include "vcg_ext/propagation/motion/motion_learning.h"
#include "vcg_ext/propagation/propagation.h"
#include "vcg_ext/sphere/certificate.h"

namespace sphere_propagation {
namespace {

/// Ellipsoids of one round cross-section that turn in themselves, which no surface shows.
struct Turning {
  std::vector<ClosedSurface> surfaces;
  test::Mesh sphere = test::icosphereMesh(12);
  std::vector<int> marked{40, 300, 620, 900, 1201};
  double angle;

  explicit Turning(int layers, double angleOfAll) : angle(angleOfAll) {
    for (int i = 0; i < layers; ++i)
      surfaces.push_back(test::surfaceOf({points(i), sphere.faces}, "layer " + std::to_string(i)));
  }
  Points points(int layer) const {
    const double turn = surfacesTurn(layer);
    const Eigen::Matrix3d rotation = Eigen::AngleAxisd(turn, Vector3::UnitZ()).toRotationMatrix();
    Points moved = sphere.vertices * Vector3(20, 20, 30 - 0.5 * layer).asDiagonal();
    return moved * rotation.transpose();
  }
  double surfacesTurn(int layer) const { return layer * angle / 4; }
  MappedSurface root() const { return MappedSurface(surfaces[0], sphere.vertices); }
  std::vector<AnchorSet> anchors() const {
    std::vector<AnchorSet> all;
    for (const ClosedSurface& surface : surfaces) {
      all.emplace_back();
      for (const int v : marked) all.back().emplace("v" + std::to_string(v), surface.vertex(v));
    }
    return all;
  }
  /// How far vertices are from where the last layer's map has those of the root, in radians.
  double errorOf(const Propagation& propagation) const {
    return (propagation.layers.back().map().positions() - sphere.vertices).rowwise().norm().mean();
  }
  PropagationTree tree() const { return timeOrder(static_cast<int>(surfaces.size()), 0); }
};

PropagationParameters with(AnchorUse use, const std::vector<AnchorSet>& anchors) {
  PropagationParameters parameters;
  parameters.anchors.use = use;
  parameters.anchors.layers = anchors;
  return parameters;
}

TEST(MotionAnchors, TellHowSurfacesTurnInThemselves) {
  const Turning turning(5, 0.5);
  const Sequence sequence(turning.surfaces);
  const double without = turning.errorOf(propagate(sequence, turning.root(), turning.tree()));
  PropagationParameters parameters = with(AnchorUse::Soft, turning.anchors());
  parameters.anchors.deviation =
      0.3;  // they are exact, and the mesh's edges of 2 say nothing of it
  const Propagation soft = propagate(sequence, turning.root(), turning.tree(), parameters);
  EXPECT_GT(without, 0.2);
  EXPECT_LT(turning.errorOf(soft), 0.65 * without);  // five say little of what is far from them
  for (size_t k = 0; k < turning.marked.size(); ++k) {
    EXPECT_TRUE(std::isnan(soft.layers[0].anchors.before[k]));
    EXPECT_LT(soft.layers[4].anchors.after[k], 0.6);
    EXPECT_GT(soft.layers[1].anchors.before[k], 1);
    EXPECT_LT(soft.layers[1].anchors.standardised[k], 3);
  }
}

TEST(MotionAnchors, OfNoneTheMapsAreBitForBitTheSame) {
  const Turning turning(3, 0.3);
  const Sequence sequence(turning.surfaces);
  const Propagation without = propagate(sequence, turning.root(), turning.tree());
  for (const PropagationParameters& parameters :
       {with(AnchorUse::Off, turning.anchors()), with(AnchorUse::Exact, {}),
        with(AnchorUse::Soft, std::vector<AnchorSet>(3))}) {
    const Propagation same = propagate(sequence, turning.root(), turning.tree(), parameters);
    for (size_t i = 0; i < 3; ++i)
      EXPECT_EQ(same.layers[i].map().positions(), without.layers[i].map().positions());
  }
}

TEST(MotionAnchors, OfTheRootAloneTheMapsAreBitForBitTheSame) {
  const Turning turning(14, 0.3);  // enough to learn from, and to be smoothed
  const Sequence sequence(turning.surfaces);
  std::vector<AnchorSet> ofRoot(14);
  ofRoot[0] = turning.anchors()[0];
  const Propagation without = propagate(sequence, turning.root(), turning.tree());
  EXPECT_TRUE(without.learnt);
  EXPECT_GT(without.smoothed, 0);
  for (const AnchorUse use : {AnchorUse::Soft, AnchorUse::Exact}) {
    const Propagation same = propagate(sequence, turning.root(), turning.tree(), with(use, ofRoot));
    for (size_t i = 0; i < 14; ++i)
      EXPECT_EQ(same.layers[i].map().positions(), without.layers[i].map().positions());
    EXPECT_EQ(same.smoothed, without.smoothed);
  }
}

/// The mean variance that a prior expects of twists, in units of A0/2.
double varianceOfTwists(const MotionModel& model, const MotionPrior& prior) {
  const Eigen::MatrixXd twists = model.basis().twists();
  Eigen::MatrixXd fields = Eigen::MatrixXd::Zero(MotionBasis::columns, twists.cols());
  fields.topRows(twists.rows()) = twists;
  return (fields.transpose() * prior.precision.inverse() * fields).trace() /
         static_cast<double>(twists.cols());
}

TEST(MotionAnchors, MakeALearntPriorExpectTwists) {
  const Turning round(1, 0);
  std::vector<ClosedSurface> surfaces;
  for (int i = 0; i < 14; ++i) {
    Points points = round.points(0);
    for (Eigen::Index v = 0; v < points.rows(); ++v) {
      const double turn = 0.04 * std::min(i, 14 - i) * points(v, 2) / 10;
      points.row(v) *= Eigen::AngleAxisd(-turn, Vector3::UnitZ()).toRotationMatrix();
    }
    surfaces.push_back(test::surfaceOf({points, round.sphere.faces}, std::to_string(i)));
  }
  const Sequence sequence(surfaces);
  const MotionModel model(round.root());
  AnchorPlaces places;
  for (const int v : round.marked) places.names.push_back(std::to_string(v));
  for (const ClosedSurface& surface : surfaces) {
    AnchorSet anchors;
    for (const int v : round.marked) anchors.emplace(std::to_string(v), surface.vertex(v));
    places.points.push_back(
        closestPoints(SurfaceLocator(surface.vertices(), surface.faces()), anchors, places.names));
  }
  const MotionAnchors held(model, sequence, 0, round.root(), places, std::vector<double>(14, 0.3));
  ThreadPool pool(2);
  const auto expected = [&](const MotionAnchors& anchors) {
    return varianceOfTwists(
        model, learnMotionPrior(model, sequence, timeOrder(14, 0), pool, {}, anchors).prior);
  };
  const double with = expected(held), without = expected({});
  EXPECT_GT(with, 5 * without);  // what anchors alone teach makes it 2.3 times as much
}

TEST(MotionAnchors, AreHeldExactlyByBothMethodsAlsoWhereAreasAreRestored) {
  const Turning turning(3, 0.4);
  const Sequence sequence(turning.surfaces);
  std::vector<AnchorSet> anchors = turning.anchors();
  anchors[1].erase("v300");                         // a layer may lack one
  anchors[2].emplace("nowhere", Vector3(0, 0, 0));  // the root does
  for (const PropagationMethod method : {PropagationMethod::Robust, PropagationMethod::AsPublished})
    for (const double restored : {0.0, 0.5}) {
      PropagationParameters parameters = with(AnchorUse::Exact, anchors);
      parameters.method = method;
      parameters.areaRestoration = restored;
      const Propagation held = propagate(sequence, turning.root(), turning.tree(), parameters);
      for (int i = 1; i < 3; ++i) {
        const MappedSurface& map = held.layers[static_cast<size_t>(i)].map();
        EXPECT_TRUE(certify(map.faces(), map.positions()).valid());
        for (const int v : turning.marked)
          if (i != 1 || v != 300) {
            EXPECT_LT((map.position(v) - turning.root().position(v)).norm(), 1e-12);
          }
      }
      EXPECT_TRUE(std::isnan(held.layers[1].anchors.after[1]));
      EXPECT_LT(held.layers[2].anchors.after[0], 1e-9);
    }
}

TEST(MotionAnchors, FarOnesAreHeldAlikeWithAnyNumberOfThreads) {
  const Turning turning(4, 1.6);
  PropagationParameters parameters = with(AnchorUse::Soft, turning.anchors());
  parameters.method = PropagationMethod::AsPublished;
  const auto propagatedBy = [&](int threads) {
    parameters.threads = threads;
    return propagate(Sequence(turning.surfaces), turning.root(), turning.tree(), parameters);
  };
  const std::vector<double> left = propagatedBy(1).layers[2].anchors.after;
  EXPECT_GT(*std::max_element(left.begin(), left.end()), 0.2 * 20) << "not far enough to be spread";
  parameters.anchors.use = AnchorUse::Exact;
  const Propagation alone = propagatedBy(1);
  for (const int threads : {2, 3, 8}) {
    const Propagation together = propagatedBy(threads);
    for (size_t t = 1; t < 4; ++t)
      EXPECT_EQ(together.layers[t].map().positions(), alone.layers[t].map().positions());
    if (test::underSanitizer()) break;
  }
}

TEST(MotionAnchors, OneThatContradictsTheOthersStandsOut) {
  const Turning turning(2, 0.3);
  std::vector<AnchorSet> anchors = turning.anchors();
  std::swap(anchors[1]["v40"], anchors[1]["v900"]);
  const Propagation found = propagate(Sequence(turning.surfaces), turning.root(), turning.tree(),
                                      with(AnchorUse::Soft, anchors));
  const std::vector<double>& z = found.layers[1].anchors.standardised;
  EXPECT_GT(z[2], 3);  // "v40" comes behind "v1201" and "v300"
  EXPECT_GT(z[4], 3);
  using Turns = std::vector<std::vector<size_t>>;
  EXPECT_EQ(found.layers[1].anchors.exchanged, (Turns{{2, 4}}));
  const Propagation fine = propagate(Sequence(turning.surfaces), turning.root(), turning.tree(),
                                     with(AnchorUse::Soft, turning.anchors()));
  EXPECT_EQ(fine.layers[1].anchors.exchanged, Turns{});
  EXPECT_GT(found.layers[1].anchors.widening, 1);
  // In turn: "v1201" has the place of "v300", that of "v40", that of "v620", that of "v1201".
  std::vector<AnchorSet> inTurn = turning.anchors();
  const AnchorSet right = inTurn[1];
  inTurn[1]["v1201"] = right.at("v300");
  inTurn[1]["v300"] = right.at("v40");
  inTurn[1]["v40"] = right.at("v620");
  inTurn[1]["v620"] = right.at("v1201");
  const Propagation turned = propagate(Sequence(turning.surfaces), turning.root(), turning.tree(),
                                       with(AnchorUse::Soft, inTurn));
  EXPECT_EQ(turned.layers[1].anchors.exchanged, (Turns{{0, 1, 2, 3}}));
}

TEST(MotionAnchors, RefusesWhatCannotBe) {
  const Turning turning(2, 0.1);
  PropagationParameters parameters = with(AnchorUse::Soft, turning.anchors());
  parameters.anchors.deviation = -1;
  EXPECT_THROW(requireValid(parameters), ParameterError);
  parameters.anchors.deviation = 0;
  parameters.anchors.layers.pop_back();
  EXPECT_THROW(propagate(Sequence(turning.surfaces), turning.root(), turning.tree(), parameters),
               ParameterError);
}

}  // namespace
}  // namespace sphere_propagation
