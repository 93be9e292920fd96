// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sequence/mirroring.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "vcg_ext/registration/chirality.h"
#include "vcg_ext/registration/shape_alignment.h"
#include "vcg_ext/sequence/surface_sizes.h"

namespace sphere_propagation {
namespace {

constexpr double lies = 0.15;  // in R: as it lies to its parent, a surface needs no other pose
constexpr double meshNoise = 0.003, halfAsGood = 0.05, recognisable = 0.25;  // in R
constexpr double mostEvidence = 1, noEvidence = 0.05;
constexpr double usual = 0.15, certain = 0.5;
constexpr int rounds = 3, pairsPerRound = 2;
constexpr int exactLayers = 16;  // 2^15 choices of sides

/// How a surface comes to lie on the root: itself and its mirror image.
struct Poses {
  Isometry itself, image;
};

double evidenceOf(const PreparedSurface& from, const PreparedSurface& to, const Poses& fromPoses,
                  const Poses& toPoses) {
  const Isometry back = toPoses.itself.inverse(), backFromImage = toPoses.image.inverse();
  std::vector<Isometry> proper{{}, back * fromPoses.itself, backFromImage * fromPoses.image};
  std::vector<Isometry> mirroring{back * fromPoses.image, backFromImage * fromPoses.itself};
  for (int axis = 0; axis < 3; ++axis)
    for (const double plane : {0.0, from.centre()[axis]})
      mirroring.push_back(reflection(axis, plane));
  Fit itself = bestFit(from, to, proper), image = bestFit(from, to, mirroring);
  // What is nearly its own mirror image fits as well once more, turned: were only one of the two
  // found, it would be taken for evidence.
  Fit& worse = itself.distance > image.distance ? itself : image;
  const Isometry& better = itself.distance > image.distance ? image.motion : itself.motion;
  const Fit again = bestFit(
      from, to,
      {better * fromPoses.itself.inverse() * fromPoses.image, back * toPoses.image * better});
  if (again.distance < worse.distance) worse = again;
  const double least = std::min(itself.distance, image.distance);
  if (least * to.radius() > recognisable * std::min(from.radius(), to.radius())) return 0;
  const double ratio =
      std::hypot(image.distance, meshNoise) / std::hypot(itself.distance, meshNoise);
  const double size = std::min(std::fabs(std::log(ratio)), mostEvidence) - noEvidence;
  const double trust = 1 / (1 + (least / halfAsGood) * (least / halfAsGood));
  return size <= 0 ? 0 : std::copysign(size * trust, ratio - 1);
}

/// What the sides are worth, and the best of them.
class Sides {
 public:
  Sides(const Eigen::MatrixXd& evidence, int fixed) : evidence_(evidence), fixed_(fixed) {}

  using Choice = std::vector<int>;  // +1 or -1

  double gain(const Choice& sides, int i) const {  // of flipping i
    double pull = usual;
    for (int j = 0; j < size(); ++j)
      if (j != i) pull += evidence_(i, j) * sides[static_cast<size_t>(j)];
    return -2 * pull * sides[static_cast<size_t>(i)];
  }

  int size() const { return static_cast<int>(evidence_.rows()); }

  struct Best {
    Choice sides;
    std::vector<double> loss;  // of choosing the other side for a surface
  };

  /// As a gain over all being right.
  double worthOf(const Choice& sides) const {
    Choice now(sides.size(), 1);
    double worth = 0;
    for (int i = 0; i < size(); ++i) {
      const auto k = static_cast<size_t>(i);
      if (now[k] == sides[k]) continue;
      worth += gain(now, i);
      now[k] *= -1;
    }
    return worth;
  }

  Best best() const { return size() <= exactLayers ? exactly() : bySearch(); }

 private:
  Best exactly() const {  // all choices, one flip after the other (Gray code)
    std::vector<int> free;
    for (int i = 0; i < size(); ++i)
      if (i != fixed_) free.push_back(i);
    Choice sides(static_cast<size_t>(size()), 1), top = sides;
    double worth = 0, most = 0;
    std::vector<double> right(sides.size(), -HUGE_VAL), wrong(sides.size(), -HUGE_VAL);
    for (unsigned step = 0;; ++step) {
      for (const int i : free) {
        const auto k = static_cast<size_t>(i);
        double& marginal = sides[k] > 0 ? right[k] : wrong[k];
        marginal = std::max(marginal, worth);
      }
      if (worth > most) {
        most = worth;
        top = sides;
      }
      if (step + 1 == 1U << free.size()) break;
      size_t bit = 0;
      while (((step + 1) >> bit & 1U) == 0) ++bit;
      worth += gain(sides, free[bit]);
      sides[static_cast<size_t>(free[bit])] *= -1;
    }
    Best best{std::move(top), std::vector<double>(sides.size(), HUGE_VAL)};
    for (const int i : free) {
      const auto k = static_cast<size_t>(i);
      best.loss[k] = most - (best.sides[k] > 0 ? wrong[k] : right[k]);
    }
    return best;
  }

  /// B. W. Kernighan and S. Lin, An efficient heuristic procedure for partitioning graphs, 1970:
  /// flips, the best first, also those that lose, and the best of what was passed. Returns the
  /// gain.
  double improve(Choice& sides, int held) const {
    double all = 0;
    for (;;) {
      Choice trial = sides, best = sides;
      std::vector<char> done(sides.size(), 0);
      done[static_cast<size_t>(fixed_)] = done[static_cast<size_t>(held)] = 1;
      double sum = 0, most = 0;
      for (;;) {
        int next = -1;
        double gains = -HUGE_VAL;
        for (int i = 0; i < size(); ++i) {
          if (done[static_cast<size_t>(i)]) continue;
          const double g = gain(trial, i);
          if (g <= gains) continue;
          gains = g;
          next = i;
        }
        if (next < 0) break;
        sum += gains;
        trial[static_cast<size_t>(next)] *= -1;
        done[static_cast<size_t>(next)] = 1;
        if (sum <= most + 1e-12) continue;
        most = sum;
        best = trial;
      }
      if (!(most > 1e-12)) return all;
      all += most;
      sides = best;
    }
  }

  Best bySearch() const {
    Best best{Choice(static_cast<size_t>(size()), 1), {}};
    improve(best.sides, fixed_);
    double most = worthOf(best.sides);
    for (bool better = true; better;) {
      better = false;
      best.loss.assign(best.sides.size(), HUGE_VAL);
      for (int i = 0; i < size() && !better; ++i) {
        if (i == fixed_) continue;
        const auto k = static_cast<size_t>(i);
        Choice alone = best.sides, all = best.sides;
        alone[k] *= -1;
        for (int j = 0; j < size(); ++j)
          if (j != fixed_) all[static_cast<size_t>(j)] *= -1;
        improve(alone, i);
        improve(all, i);
        const double a = worthOf(alone), b = worthOf(all);
        if (std::max(a, b) > most + 1e-9) {
          best.sides = a >= b ? alone : all;
          most = std::max(a, b);
          better = true;
        }
        best.loss[k] = most - std::max(a, b);
      }
    }
    return best;
  }

  const Eigen::MatrixXd& evidence_;
  int fixed_;
};

/// How different two surfaces are by what mirroring does not change: their moments.
Eigen::MatrixXd differencesOfMoments(const Sequence& sequence) {
  const int count = sequence.size();
  Eigen::MatrixXd moments(count, 5);
  for (int i = 0; i < count; ++i) {
    const PreparedSurface& shape = sequence[i];
    const Points along = (shape.samples().rowwise() - shape.centre().transpose()) * shape.axes();
    moments.row(i) << std::log(shape.radius()), std::cbrt(shape.volume()) / shape.radius(),
        along.cwiseAbs2().colwise().mean().cwiseSqrt() / shape.radius();
  }
  Eigen::MatrixXd differences(count, count);
  for (int i = 0; i < count; ++i)
    differences.col(i) = (moments.rowwise() - moments.row(i)).rowwise().norm();
  return differences;
}

}  // namespace

ClosedSurface mirrorImage(const ClosedSurface& surface, double plane) {
  Points vertices = surface.vertices();
  vertices.col(0) = (2 * plane - vertices.col(0).array()).matrix();
  Triangles faces = surface.faces();
  faces.col(1).swap(faces.col(2));
  return {std::move(vertices), std::move(faces), surface.name()};
}

std::vector<SurfaceSide> sidesFromEvidence(const Eigen::MatrixXd& evidence, int fixed) {
  const Sides all(evidence, fixed);
  const Sides::Best best = all.best();
  std::vector<SurfaceSide> sides(best.sides.size());
  Sides::Choice unreflected = best.sides;  // what is not known taken for right
  for (size_t i = 0; i < sides.size(); ++i) {
    sides[i].known = best.loss[i] >= certain;
    sides[i].mirrored = sides[i].known && best.sides[i] < 0;
    if (!sides[i].known) unreflected[i] = 1;
  }
  const bool mixed = all.worthOf(best.sides) - all.worthOf(unreflected) >= certain;
  for (SurfaceSide& side : sides) side.inDoubt = mixed && !side.known;
  return sides;
}

std::vector<SurfaceSide> findSides(const Sequence& sequence, const PropagationTree& tree,
                                   ThreadPool& pool) {
  const int count = sequence.size(), root = tree.root();
  std::vector<SurfaceSide> sides(static_cast<size_t>(count));
  if (count < 2) return sides;
  sequence.prepare(pool);
  const PreparedSurface& first = sequence[root];
  std::vector<Poses> poses(static_cast<size_t>(count), {{}, roughIsometry(first, first, true)});
  pool.forEach(count, [&](int i) {
    if (i == root || shapeDistance(sequence[i], first) < lies * first.radius()) return;
    poses[static_cast<size_t>(i)] = {roughIsometry(sequence[i], first, false),
                                     roughIsometry(sequence[i], first, true)};
  });
  Eigen::MatrixXd evidence = Eigen::MatrixXd::Zero(count, count),
                  differences = differencesOfMoments(sequence);
  differences.diagonal().setConstant(HUGE_VAL);
  std::vector<Arc> pairs;
  for (int i = 0; i < count; ++i)
    if (i != root) pairs.push_back({i, tree.parent[static_cast<size_t>(i)]});
  for (int round = 0;; ++round) {
    std::vector<double> found(pairs.size());
    pool.forEach(static_cast<int>(pairs.size()), [&](int k) {
      const auto [i, j] = pairs[static_cast<size_t>(k)];
      found[static_cast<size_t>(k)] = evidenceOf(
          sequence[i], sequence[j], poses[static_cast<size_t>(i)], poses[static_cast<size_t>(j)]);
    });
    for (size_t k = 0; k < pairs.size(); ++k) {
      const auto [i, j] = pairs[k];
      evidence(i, j) = evidence(j, i) = found[k];
      differences(i, j) = differences(j, i) = HUGE_VAL;
    }
    sides = sidesFromEvidence(evidence, root);
    pairs.clear();
    if (round == rounds) return sides;
    for (int i = 0; i < count; ++i) {
      if (sides[static_cast<size_t>(i)].known && i != root) continue;
      for (int more = 0; more < pairsPerRound; ++more) {
        Eigen::Index j = 0;
        if (!(differences.row(i).minCoeff(&j) < HUGE_VAL)) break;
        differences(i, j) = differences(j, i) = HUGE_VAL;
        pairs.push_back({i, static_cast<int>(j)});
      }
    }
    const bool allKnown =
        std::all_of(sides.begin(), sides.end(), [](const SurfaceSide& side) { return side.known; });
    if (allKnown || pairs.empty()) return sides;
  }
}

ReflectedSequence reflectMirrorImages(const Sequence& sequence, const PropagationOrder& order,
                                      int root, ThreadPool& pool, bool reflects) {
  ReflectedSequence result{sequence, {}, makeTree(order, sequence, root, pool), {}};
  result.planes.resize(static_cast<size_t>(sequence.size()));
  const Sequence sized =
      inRootsSize(sequence, findSurfaceSizes(sequence, result.tree), result.tree);
  result.sides = findSides(sized, result.tree, pool);
  if (!reflects) return result;
  bool found = false;
  for (int i = 0; i < sequence.size(); ++i) {
    const auto k = static_cast<size_t>(i);
    if (!result.sides[k].mirrored) continue;
    found = true;
    const double plane = sequence[i].centre()[0];
    result.planes[k] = plane;
    result.sequence = result.sequence.with(i, mirrorImage(sequence.surface(i), plane));
  }
  if (found && order.goesByShape()) result.tree = makeTree(order, result.sequence, root, pool);
  return result;
}

}  // namespace sphere_propagation
