// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sequence/mirroring.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "vcg_ext/base/statistics.h"
#include "vcg_ext/registration/chirality.h"
#include "vcg_ext/registration/shape_alignment.h"
#include "vcg_ext/sequence/surface_sizes.h"

namespace sphere_propagation {
namespace {

constexpr double lies = 0.15;  // in R: as it lies to its parent, a surface needs no other pose
constexpr double meshNoise = 0.003, halfAsGood = 0.05, recognisable = 0.25;  // in R
constexpr double mostEvidence = 1, noEvidence = 0.05;
constexpr double usual = 0.15, certain = 0.5;
constexpr int rootIsRight = 2;
constexpr int rounds = 3, pairsPerRound = 2;
constexpr int nearest = 6;  // the most alike that each surface is compared with in the end
// By how much the nearest image lies farther off than the nearest surface, as a logarithm; of the
// median this and the part of the surfaces that would be mirrored, within these bounds.
constexpr double hasSide = 0.1, leastForSide = 0.2, mostForSide = 0.5;
constexpr double tellsAgainst = 0.08, tellsAlone = 0.5;
constexpr int oddOneOf = 12;                            // surfaces
constexpr double oddAgainst = 0.75;                     // part of those compared
constexpr double sameSize = 0.004, sameMoments = 0.03;  // of meshes that may be others
constexpr size_t copiesLookedAt = 2;
constexpr double exactly = 0.001;   // in R
constexpr double unlikeItself = 4;  // times the noise of meshes
constexpr int enoughOfOne = 8;      // layers
constexpr double slowly = 0.3;      // part of what layers in any order would do
constexpr int exactLayers = 16;     // 2^15 choices of sides

/// How a surface comes to lie on the root: itself and its mirror image.
struct Poses {
  Isometry itself, image;
};

/// Of a pair, in the radius of the second one.
struct Distances {
  double itself = HUGE_VAL, image = HUGE_VAL;
};

/// `motion` after each reflection of the shape across a plane through its centre that holds its
/// long axis, every 15 degrees: about that axis closest points hardly turn a shape that is nearly
/// round.
std::vector<Isometry> turnedRound(const Isometry& motion, const PreparedSurface& shape) {
  constexpr int planes = 12;
  std::vector<Isometry> turned;
  for (int k = 0; k < planes; ++k) {
    const double angle = pi * k / planes;
    const Vector3 normal =
        std::cos(angle) * shape.axes().col(1) + std::sin(angle) * shape.axes().col(2);
    turned.push_back(motion * reflection(normal, shape.centre()));
  }
  return turned;
}

Distances distancesOf(const PreparedSurface& from, const PreparedSurface& to,
                      const Poses& fromPoses, const Poses& toPoses) {
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
  const Fit better = itself.distance > image.distance ? image : itself;
  const Fit again = bestFit(from, to,
                            {better.motion * fromPoses.itself.inverse() * fromPoses.image,
                             back * toPoses.image * better.motion});
  if (again.distance < worse.distance) worse = again;
  // A veto alone: what is nearly round fits nearly as well turned about its axis, whichever side it
  // is on, so that this makes no difference smaller, but may show that it was the other way round.
  const Fit turned = bestFit(from, to, turnedRound(better.motion, from));
  if (turned.distance < better.distance) worse = turned;
  return {itself.distance, image.distance};
}

double evidenceOf(const Distances& distances, const PreparedSurface& from,
                  const PreparedSurface& to) {
  const double least = std::min(distances.itself, distances.image);
  if (least * to.radius() > recognisable * std::min(from.radius(), to.radius())) return 0;
  const double ratio =
      std::hypot(distances.image, meshNoise) / std::hypot(distances.itself, meshNoise);
  const double size = std::min(std::fabs(std::log(ratio)), mostEvidence) - noEvidence;
  const double trust = 1 / (1 + (least / halfAsGood) * (least / halfAsGood));
  return size <= 0 ? 0 : std::copysign(size * trust, ratio - 1);
}

/// What the sides are worth, and the best of them.
class Sides {
 public:
  Sides(const Eigen::MatrixXd& evidence, int fixed, double preference = usual)
      : evidence_(evidence), fixed_(fixed), preference_(preference) {}

  using Choice = std::vector<int>;  // +1 or -1

  double gain(const Choice& sides, int i) const {  // of flipping i
    const int side = sides[static_cast<size_t>(i)];
    double pull = 0;
    int sum = 0;
    for (int j = 0; j < size(); ++j) {
      sum += sides[static_cast<size_t>(j)];
      if (j != i) pull += evidence_(i, j) * sides[static_cast<size_t>(j)];
    }
    return preference_ * (agreeing(sum - 2 * side) - agreeing(sum)) - 2 * pull * side;
  }

  /// Most are on one side, on the root's rather than on the other one.
  static int agreeing(int sum) { return sum < 0 ? -sum - rootIsRight : sum; }

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
  double preference_;
};

/// What mirroring does not change: size, roundness, and extents along the axes; #surfaces by 5.
Eigen::MatrixXd momentsOf(const Sequence& sequence) {
  Eigen::MatrixXd moments(sequence.size(), 5);
  for (int i = 0; i < sequence.size(); ++i) {
    const PreparedSurface& shape = sequence[i];
    const Points along = (shape.samples().rowwise() - shape.centre().transpose()) * shape.axes();
    moments.row(i) << std::log(shape.radius()), std::cbrt(shape.volume()) / shape.radius(),
        along.cwiseAbs2().colwise().mean().cwiseSqrt() / shape.radius();
  }
  return moments;
}

Eigen::MatrixXd differencesOf(const Eigen::MatrixXd& moments) {
  Eigen::MatrixXd differences(moments.rows(), moments.rows());
  for (Eigen::Index i = 0; i < moments.rows(); ++i)
    differences.col(i) = (moments.rowwise() - moments.row(i)).rowwise().norm();
  differences.diagonal().setConstant(HUGE_VAL);
  return differences;
}

/// Whether the surfaces are phases of one subject, whose shape changes little from one to the next:
/// J. von Neumann's ratio (Distribution of the ratio of the mean square successive difference to
/// the variance, 1941), which is 1 for surfaces in any order. Sizes are not looked at, by which
/// subjects may be sorted.
bool changesSlowly(const Eigen::MatrixXd& moments) {
  const Eigen::Index count = moments.rows();
  if (count < enoughOfOne) return false;
  const Eigen::MatrixXd shape = moments.rightCols(moments.cols() - 1);
  const double step = (shape.bottomRows(count - 1) - shape.topRows(count - 1)).squaredNorm() /
                      static_cast<double>(count - 1);
  const double spread =
      (shape.rowwise() - shape.colwise().mean()).squaredNorm() / static_cast<double>(count - 1);
  return step < slowly * 2 * spread;
}

/// What was found from the evidence alone.
struct Decision {
  Sides::Choice sides;      ///< the best; of all, also those that are not known
  std::vector<char> known;  ///< whether the other side is clearly worse
  bool mixed = false;       ///< clearly better than taking those that are not known for right

  bool isMirrored(size_t i) const { return known[i] && sides[i] < 0; }
  bool suspects() const {
    for (size_t i = 0; i < sides.size(); ++i)
      if (isMirrored(i)) return true;
    return mixed;
  }

  std::vector<SurfaceSide> result() const {
    std::vector<SurfaceSide> result(sides.size());
    for (size_t i = 0; i < sides.size(); ++i)
      result[i] = {isMirrored(i), known[i] != 0, mixed && !known[i]};
    return result;
  }
};

Decision decisionFrom(const Eigen::MatrixXd& evidence, int fixed) {
  const Sides all(evidence, fixed);
  Sides::Best best = all.best();
  Decision decision{std::move(best.sides), std::vector<char>(best.loss.size()), false};
  Sides::Choice unreflected = decision.sides;  // what is not known taken for right
  for (size_t i = 0; i < unreflected.size(); ++i) {
    decision.known[i] = best.loss[i] >= certain;
    if (!decision.known[i]) unreflected[i] = 1;
  }
  decision.mixed = all.worthOf(decision.sides) - all.worthOf(unreflected) >= certain;
  return decision;
}

/// The pairs that were compared.
class Comparisons {
 public:
  Comparisons(const Sequence& sequence, int root, ThreadPool& pool)
      : sequence_(sequence), pool_(pool), count_(sequence.size()) {
    const PreparedSurface& first = sequence[root];
    poses_.assign(static_cast<size_t>(count_), {{}, roughIsometry(first, first, true)});
    pool.forEach(count_, [&](int i) {
      if (i == root || shapeDistance(sequence[i], first) < lies * first.radius()) return;
      poses_[static_cast<size_t>(i)] = {roughIsometry(sequence[i], first, false),
                                        roughIsometry(sequence[i], first, true)};
    });
    evidence_ = Eigen::MatrixXd::Zero(count_, count_);
    itself_ = image_ = Eigen::MatrixXd::Constant(count_, count_, HUGE_VAL);
  }

  void compare(const std::vector<Arc>& pairs) {
    std::vector<Distances> found(pairs.size());
    pool_.forEach(static_cast<int>(pairs.size()), [&](int k) {
      const auto [i, j] = pairs[static_cast<size_t>(k)];
      found[static_cast<size_t>(k)] =
          distancesOf(sequence_[i], sequence_[j], poses_[static_cast<size_t>(i)],
                      poses_[static_cast<size_t>(j)]);
    });
    for (size_t k = 0; k < pairs.size(); ++k) {
      const auto [i, j] = pairs[k];
      evidence_(i, j) = evidence_(j, i) = evidenceOf(found[k], sequence_[i], sequence_[j]);
      itself_(i, j) = itself_(j, i) = found[k].itself;
      image_(i, j) = image_(j, i) = found[k].image;
    }
  }

  const Eigen::MatrixXd& evidence() const { return evidence_; }

  /// Whether one is the other's mirror image, and not its copy.
  bool areImages(int i, int j) const {
    if (itself_(i, j) < unlikeItself * exactly) return false;
    const PreparedSurface &from = sequence_[i], &to = sequence_[j];
    const Distances found =
        distancesOf(from, to, {roughIsometry(from, to, false), roughIsometry(from, to, true)},
                    {{}, roughIsometry(to, to, true)});
    return found.image < meshNoise && found.itself > unlikeItself * std::max(found.image, exactly);
  }

  /// Of margins: which of two exact images is the mirrored one, neither says of the other.
  void leaveOut(int i, int j) {
    itself_(i, j) = itself_(j, i) = image_(i, j) = image_(j, i) = HUGE_VAL;
  }

  /// To how many of those that surface i was compared with its image is nearer; and with how many.
  std::pair<int, int> against(int i) const {
    int nearer = 0, all = 0;
    for (int j = 0; j < count_; ++j) {
      if (!(itself_(i, j) < HUGE_VAL)) continue;
      ++all;
      if (image_(i, j) < itself_(i, j)) ++nearer;
    }
    return {nearer, all};
  }

  /// Of each surface, on the side that was found for it: by how much its image lies farther off the
  /// nearest of the others than it does itself, as the logarithm of the ratio.
  std::vector<double> margins(const Sides::Choice& sides) const {
    std::vector<double> margins;
    for (int i = 0; i < count_; ++i) {
      double itself = HUGE_VAL, image = HUGE_VAL;
      for (int j = 0; j < count_; ++j) {
        const bool alike = sides[static_cast<size_t>(i)] == sides[static_cast<size_t>(j)];
        itself = std::min(itself, (alike ? itself_ : image_)(i, j));
        image = std::min(image, (alike ? image_ : itself_)(i, j));
      }
      margins.push_back(itself < HUGE_VAL
                            ? std::log(std::hypot(image, meshNoise) / std::hypot(itself, meshNoise))
                            : 0);
    }
    return margins;
  }

 private:
  const Sequence& sequence_;
  ThreadPool& pool_;
  int count_;
  std::vector<Poses> poses_;
  Eigen::MatrixXd evidence_, itself_, image_;
};

/// Of different subjects no pair's evidence is independent of the others': one whose own asymmetry
/// is unlike that of several counts against each of them. Where the surfaces have no side in
/// common, images lie as near to the nearest surface as surfaces do, and nothing is known: returns
/// the median margin then.
std::optional<double> doubtWithoutSide(Decision& decision, const std::vector<double>& margins,
                                       int root) {
  const size_t count = margins.size();
  const auto reflected =
      static_cast<size_t>(std::count(decision.sides.begin(), decision.sides.end(), -1));
  const double share =
      static_cast<double>(std::min(reflected, count - reflected)) / static_cast<double>(count);
  const double median = medianOf(margins);
  const bool sided = median >= std::clamp(hasSide + share, leastForSide, mostForSide);
  bool unknown = false;
  for (size_t i = 0; i < count; ++i) {
    if (static_cast<int>(i) == root) continue;
    if (!sided || (decision.sides[i] < 0 && margins[i] < tellsAgainst)) decision.known[i] = 0;
    if (sided && margins[i] >= tellsAlone) decision.known[i] = 1;
    unknown = unknown || (decision.sides[i] < 0 && !decision.known[i]);
  }
  decision.mixed = decision.mixed && sided && unknown;
  if (sided) return std::nullopt;
  return median;
}

/// The few that are on the other side than the rest.
void findOddOnes(std::vector<SurfaceSide>& found, const Comparisons& compared, int root) {
  const auto count = static_cast<std::ptrdiff_t>(found.size());
  const Sides::Choice sides = Sides(compared.evidence(), root, 0).best().sides;
  const std::ptrdiff_t others = std::count(sides.begin(), sides.end(), -1);
  const int odd = 2 * others <= count ? -1 : 1;
  if (oddOneOf * std::min(others, count - others) > count) return;
  for (int i = 0; i < count; ++i) {
    SurfaceSide& side = found[static_cast<size_t>(i)];
    if (sides[static_cast<size_t>(i)] != odd || side.mirrored || side.inDoubt) continue;
    const auto [nearer, all] = compared.against(i);
    if (nearer < oddAgainst * all) continue;
    side.against = nearer;
    side.compared = all;
  }
}

using Pairs = std::vector<std::pair<int, int>>;

/// Of surfaces that are there on both sides, the higher number first. Mirroring changes no moments,
/// but those of samples, which depend on where the surface lies.
Pairs findImages(const Comparisons& compared, const Eigen::MatrixXd& moments, ThreadPool& pool) {
  const Eigen::MatrixXd differences = differencesOf(moments),
                        ofSize = differencesOf(moments.leftCols(2));
  Pairs pairs;
  for (int i = 0; i < differences.rows(); ++i) {
    std::vector<std::pair<double, int>> near;
    for (int j = 0; j < i; ++j)
      if (ofSize(i, j) <= sameSize && differences(i, j) <= sameMoments)
        near.emplace_back(ofSize(i, j), j);
    std::sort(near.begin(), near.end());
    near.resize(std::min(near.size(), copiesLookedAt));
    for (const auto& [difference, j] : near) pairs.emplace_back(i, j);
  }
  std::vector<char> images(pairs.size(), 0);
  pool.forEach(static_cast<int>(pairs.size()), [&](int k) {
    const auto [i, j] = pairs[static_cast<size_t>(k)];
    images[static_cast<size_t>(k)] = compared.areImages(i, j);
  });
  Pairs found;
  for (size_t k = 0; k < pairs.size(); ++k)
    if (images[k]) found.push_back(pairs[k]);
  return found;
}

/// margins: of the surfaces, where they were looked at. Which of two images is the mirrored one the
/// root tells, or a margin that tells alone.
void markImages(std::vector<SurfaceSide>& found, const Pairs& images, int root,
                const std::vector<double>& margins = {}) {
  for (const auto& [i, j] : images) {
    SurfaceSide &one = found[static_cast<size_t>(i)], &other = found[static_cast<size_t>(j)];
    one.imageOf = j;
    if (i == root || j == root) {
      SurfaceSide& image = i == root ? other : one;
      image.mirrored = image.known = true;
      image.inDoubt = false;
      image.against = 0;
    } else if (!margins.empty() && std::min(margins[static_cast<size_t>(i)],
                                            margins[static_cast<size_t>(j)]) < tellsAlone) {
      one.mirrored = other.mirrored = one.known = other.known = false;
      one.inDoubt = other.inDoubt = false;
    }
  }
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
  return decisionFrom(evidence, fixed).result();
}

SurfaceSides findSides(const Sequence& sequence, const PropagationTree& tree, ThreadPool& pool) {
  const int count = sequence.size(), root = tree.root();
  if (count < 2) return {std::vector<SurfaceSide>(static_cast<size_t>(count)), {}};
  sequence.prepare(pool);
  const Eigen::MatrixXd moments = momentsOf(sequence), differences = differencesOf(moments);
  Comparisons compared(sequence, root, pool);
  std::vector<Arc> pairs;
  for (int i = 0; i < count; ++i)
    if (i != root) pairs.push_back({i, tree.parent[static_cast<size_t>(i)]});
  Eigen::MatrixXd left = differences;
  for (const auto& [i, j] : pairs) left(i, j) = left(j, i) = HUGE_VAL;
  // Of surface i with the most alike that it was not compared with.
  const auto addPairs = [&](int i) {
    for (int more = 0; more < pairsPerRound; ++more) {
      Eigen::Index j = 0;
      if (!(left.row(i).minCoeff(&j) < HUGE_VAL)) break;
      left(i, j) = left(j, i) = HUGE_VAL;
      pairs.push_back({i, static_cast<int>(j)});
    }
  };
  Decision decision;
  bool allKnown = false;
  for (int round = 0;; ++round) {
    compared.compare(pairs);
    decision = decisionFrom(compared.evidence(), root);
    pairs.clear();
    allKnown = std::all_of(decision.known.begin(), decision.known.end(),
                           [](const char known) { return known != 0; });
    if (round == rounds || allKnown) break;
    for (int i = 0; i < count; ++i)
      if (i == root || !decision.known[static_cast<size_t>(i)]) addPairs(i);
    if (pairs.empty()) break;
  }
  SurfaceSides found;
  const bool looksCloser = decision.suspects() || (count >= oddOneOf && !allKnown);
  if (!looksCloser || changesSlowly(moments)) {
    found.surfaces = decision.result();
    markImages(found.surfaces, findImages(compared, moments, pool), root);
    return found;
  }
  const bool suspects = decision.suspects();
  for (int i = 0; i < count; ++i) {
    std::vector<int> others;
    for (int j = 0; j < count; ++j)
      if (j != i) others.push_back(j);
    const auto end =
        others.begin() + std::min<std::ptrdiff_t>(nearest, static_cast<std::ptrdiff_t>(count - 1));
    std::partial_sort(others.begin(), end, others.end(), [&](int a, int b) {
      return std::pair(differences(i, a), a) < std::pair(differences(i, b), b);
    });
    for (auto j = others.begin(); j != end; ++j) {
      if (!(left(i, *j) < HUGE_VAL)) continue;
      left(i, *j) = left(*j, i) = HUGE_VAL;
      pairs.push_back({i, *j});
    }
  }
  compared.compare(pairs);
  const Pairs images = findImages(compared, moments, pool);
  for (const auto& [i, j] : images) compared.leaveOut(i, j);
  const std::vector<double> margins = compared.margins(decision.sides);
  if (suspects && static_cast<int>(images.size()) + 1 < count)
    found.noSide = doubtWithoutSide(decision, margins, root);
  found.surfaces = decision.result();
  if (count >= oddOneOf) findOddOnes(found.surfaces, compared, root);
  markImages(found.surfaces, images, root, margins);
  return found;
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
    if (!result.sides.surfaces[k].mirrored) continue;
    found = true;
    const double plane = sequence[i].centre()[0];
    result.planes[k] = plane;
    result.sequence = result.sequence.with(i, mirrorImage(sequence.surface(i), plane));
  }
  if (found && order.goesByShape()) result.tree = makeTree(order, result.sequence, root, pool);
  return result;
}

}  // namespace sphere_propagation
