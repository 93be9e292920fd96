// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/volume/slice_alignment.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "vcg_ext/base/statistics.h"

namespace sphere_propagation {
namespace {

using Place = Eigen::RowVector2d;
using Places = Eigen::Matrix<double, Eigen::Dynamic, 2>;

// mm
constexpr double usualBend = 1.5;   // third difference of places in a smooth organ
constexpr double usualNoise = 1;    // of a step of one phase,
constexpr double noiseAtEnds = 3;   // and of one to the first or last slice
constexpr double farOff = 8;        // deviation of slices that stand out
constexpr double leastApart = 4;    // phases differ
constexpr double leastInRough = 3;  // shifts in a stack whose third differences are small
constexpr double smoothDifferences = 1.75;
constexpr std::array<double, 8> deviations{0.33, 0.5, 0.7, 1, 1.4, 2, 2.8, 4};

constexpr double rounding = 0.29;  // standard deviation of a whole number, for voxels
// Where an arch joins the body of a vertebra, no step makes the outlines fit: 0.15 to 0.6. On each
// other, slices of hearts are at 0.02 to 0.07, but for the first and last ones.
constexpr double otherShape = 0.1;
constexpr double nothingSaid = 30;  // deviation of such a step

constexpr double otherSteps = 3.5;  // differences of phases that do not belong together
constexpr double otherStepsInVoxels = 2.5;
constexpr double voxelsApart = 3;
constexpr size_t fewPhases = 3;
constexpr double sharedPlace = 0.4;
constexpr double atEnds = 3;  // how much more ends bend
constexpr double leastSmoothing = 0.05;
constexpr double tukey = 4.685;
constexpr int reweightings = 30;

/// From one slice with a label to another, over the phases that have both.
struct Step {
  int from = 0, to = 0;
  Place mean = Place::Zero();  // mm
  double deviation = 0;        // of the phases, mm
};

/// How many slices with a label are beyond one, at the nearer end.
size_t depthOf(size_t slice, size_t slices) { return std::min(slice, slices - 1 - slice); }

using PhasePlaces = std::vector<SlicePlace>;
using StackPhases = std::vector<const PhasePlaces*>;
using StepsOfStack = std::map<std::pair<int, int>, Step>;

StepsOfStack stepsOf(const StackPhases& phases, const Place& unit) {
  std::map<std::pair<int, int>, std::vector<Place>> found;
  std::map<std::pair<int, int>, double> usual;  // variances
  std::map<std::pair<int, int>, std::vector<double>> misfits;
  for (const PhasePlaces* phase : phases)
    for (size_t i = 1; i < phase->size(); ++i) {
      const std::pair slices((*phase)[i - 1].slice, (*phase)[i].slice);
      found[slices].emplace_back((*phase)[i].step.cast<double>().transpose().cwiseProduct(unit));
      const auto depth =
          static_cast<double>(std::min(depthOf(i - 1, phase->size()), depthOf(i, phase->size())));
      const double noise = std::max(usualNoise, noiseAtEnds / (1 + depth));
      usual[slices] += noise * noise;
      misfits[slices].push_back((*phase)[i].misfit);
    }
  const double floor = rounding * unit.maxCoeff();
  constexpr double perAxis = 1.18;  // the median length of normal vectors in the plane
  StepsOfStack steps;
  for (const auto& [slices, places] : found) {
    const auto deviationsFrom = [&places = places](const Place& x) {
      std::vector<double> sizes;
      for (const Place& place : places) sizes.push_back((place - x).norm());
      return sizes;
    };
    std::vector<double> xs, ys;
    for (const Place& place : places) {
      xs.push_back(place[0]);
      ys.push_back(place[1]);
    }
    const Place middle(medianOf(xs), medianOf(ys));
    std::vector<double> off = deviationsFrom(middle);
    const double reach = 2.5 * std::max(normalDeviation * medianOf(off), perAxis * floor) + 1e-9;
    Place sum = Place::Zero();
    double count = 0;
    for (size_t i = 0; i < places.size(); ++i)
      if (off[i] <= reach) {
        sum += places[i];
        ++count;
      }
    Step step{slices.first, slices.second, count > 0 ? Place(sum / count) : middle, 0};
    off = deviationsFrom(step.mean);
    const double most = 3 * medianOf(off) + floor;
    double variance = 0;
    for (const double size : off) variance += std::min(size, most) * std::min(size, most) / 2;
    const auto number = static_cast<double>(places.size());
    step.deviation =
        std::sqrt((variance + 2 * usual[slices] / number) / (number + 1) + floor * floor);
    if (medianOf(misfits[slices]) > otherShape) step.deviation = nothingSaid;
    steps[slices] = step;
  }
  return steps;
}

/// The smaller of two numbers of the same sign; else 0.
double smaller(double a, double b) {
  if (a * b <= 0) return 0;
  return std::fabs(a) < std::fabs(b) ? a : b;
}

/// Slices of a phase that lie otherwise than the steps say, against both slices beside them.
/// Near the ends of more than a few phases, by much more than the phases vary there anyway.
std::vector<int> apartFrom(const StepsOfStack& steps, const PhasePlaces& phase, const Place& unit,
                           size_t phases) {
  std::vector<int> apart;
  for (size_t i = 1; i + 1 < phase.size(); ++i) {
    const auto before = steps.find({phase[i - 1].slice, phase[i].slice}),
               after = steps.find({phase[i].slice, phase[i + 1].slice});
    if (before == steps.end() || after == steps.end()) continue;
    const auto off = [&](const Step& step, const SlicePlace& place) {
      return Place(place.step.cast<double>().transpose().cwiseProduct(unit) - step.mean);
    };
    const Place first = off(before->second, phase[i]), second = off(after->second, phase[i + 1]);
    const Place both(smaller(first[0], -second[0]), smaller(first[1], -second[1]));
    double least = std::max(leastApart, voxelsApart * unit.maxCoeff());
    if (phases > fewPhases && depthOf(i, phase.size()) < 3)
      least = std::max(least, 3 * std::min(before->second.deviation, after->second.deviation));
    if (both.norm() >= least) apart.push_back(phase[i].slice);
  }
  return apart;
}

/// Whether the steps of a phase are these, by and large, but for a bend.
bool hasSteps(const StepsOfStack& steps, const PhasePlaces& phase, const Place& unit) {
  std::vector<double> off;
  std::optional<Place> before;
  for (size_t i = 1; i < phase.size(); ++i) {
    const auto step = steps.find({phase[i - 1].slice, phase[i].slice});
    std::optional<Place> here;
    if (step != steps.end())
      here = phase[i].step.cast<double>().transpose().cwiseProduct(unit) - step->second.mean;
    if (here && before) off.push_back((*here - *before).norm() / 2);
    before = here;
  }
  return medianOf(off) < std::max(otherSteps, otherStepsInVoxels * unit.maxCoeff());
}

bool sharePlace(const PhasePlaces& a, const PhasePlaces& b) {
  double common = 0, first = 0, second = 0;
  for (const SlicePlace& place : a) {
    first += place.hull.area();
    for (const SlicePlace& other : b)
      if (other.slice == place.slice) common += place.hull.common(other.hull);
  }
  for (const SlicePlace& place : b) second += place.hull.area();
  return common >= sharedPlace * std::min(first, second);
}

/// The phases of each sequence, by number.
std::vector<std::vector<size_t>> sequencesOf(const std::vector<PhasePlaces>& phases,
                                             const Place& unit) {
  std::vector<std::vector<size_t>> sequences;
  for (size_t p = 0; p < phases.size(); ++p) {
    const PhasePlaces& phase = phases[p];
    const auto joins = [&](const std::vector<size_t>& sequence) {
      if (!sharePlace(phases[sequence.front()], phase)) return false;
      StackPhases members;
      for (const size_t member : sequence) members.push_back(&phases[member]);
      return hasSteps(stepsOf(members, unit), phase, unit);
    };
    const auto found = std::find_if(sequences.begin(), sequences.end(), joins);
    if (found == sequences.end())
      sequences.push_back({p});
    else
      found->push_back(p);
  }
  return sequences;
}

/// Rows: differences of this order of neighbours.
Eigen::MatrixXd differencesOf(Eigen::Index count, int order) {
  Eigen::MatrixXd d = Eigen::MatrixXd::Identity(count, count);
  for (int i = 0; i < order; ++i) d = (d.bottomRows(d.rows() - 1) - d.topRows(d.rows() - 1)).eval();
  return d;
}

/// The stack that a sequence's phases have in common: one row per slice from the first to the last.
class JointStack {
 public:
  JointStack(const StackPhases& phases, const StepsOfStack& steps, const Place& unit)
      : unit_(unit), voxel_(unit.maxCoeff()) {
    low_ = std::numeric_limits<int>::max();
    int high = std::numeric_limits<int>::min();
    for (const PhasePlaces* phase : phases)
      if (!phase->empty()) {
        low_ = std::min(low_, phase->front().slice);
        high = std::max(high, phase->back().slice);
      }
    if (low_ > high) return;
    count_ = high - low_ + 1;
    describeSlices(phases);
    if (known_.sum() < 2) return;
    for (const auto& step : steps) steps_.push_back(step.second);
    differences_ = differencesOf(count_, known_.sum() > 5 ? 3 : 2);
    places_ = placesByStepsAlone();
  }

  /// How each slice is to be moved, by z; those that stay left out.
  std::map<int, SliceShift> shifts() const {
    std::map<int, SliceShift> found;
    if (places_.rows() < 3) return found;
    const Explanation best = explain();
    const bool smooth = best.deviation < SliceAlignmentLimits::roughness &&
                        best.far.size() <= std::max<size_t>(1, labelled_ / 5);
    const Places moves = smooth ? movesOfFew(best) : movesOfAll();
    for (Eigen::Index row = 0; row < count_; ++row) {
      const Eigen::Vector2i voxels =
          moves.row(row).cwiseQuotient(unit_).transpose().array().round().cast<int>();
      if (voxels != Eigen::Vector2i::Zero())
        found[low_ + static_cast<int>(row)] = {low_ + static_cast<int>(row), voxels, false};
    }
    return found;
  }

 private:
  /// Of the places: a common deviation from a smooth line, and slices that lie far off it.
  struct Explanation {
    double evidence = 0, deviation = 0;
    std::vector<Eigen::Index> far;
    Places off;  // without the ties to the line of those that are far or alone
  };

  void describeSlices(const StackPhases& phases) {
    Eigen::VectorXd meeting = Eigen::VectorXd::Zero(count_);
    present_ = Eigen::VectorXd::Zero(count_);
    std::vector<std::vector<double>> depths(static_cast<size_t>(count_));
    for (const PhasePlaces* phase : phases)
      for (size_t i = 0; i < phase->size(); ++i) {
        const int row = (*phase)[i].slice - low_;
        present_[row] += 1;
        meeting[row] += (*phase)[i].meets ? 1 : 0;
        depths[static_cast<size_t>(row)].push_back(static_cast<double>(depthOf(i, phase->size())));
      }
    known_ = Eigen::VectorXd::Zero(count_);
    depth_.assign(static_cast<size_t>(count_), 0);
    first_ = count_;
    const auto all = static_cast<double>(phases.size());
    for (Eigen::Index row = 0; row < count_; ++row) {
      const auto i = static_cast<size_t>(row);
      known_[row] = present_[row] > 0 && 2 * meeting[row] >= present_[row] ? 1 : 0;
      depths[i].resize(phases.size(), 0);
      depth_[i] = static_cast<int>(std::floor(medianOf(depths[i])));
      if (2 * present_[row] < all) continue;
      ++labelled_;
      first_ = std::min(first_, row);
      last_ = row;
    }
  }

  Places placesByStepsAlone() const {
    Eigen::MatrixXd normal = 1e-9 * Eigen::MatrixXd::Identity(count_, count_);
    Places right = Places::Zero(count_, 2);
    for (const Step& step : steps_) add(step, normal, right);
    return normal.llt().solve(right);
  }

  void add(const Step& step, Eigen::MatrixXd& normal, Places& right) const {
    const int a = step.from - low_, b = step.to - low_;
    const double weight = 1 / (step.deviation * step.deviation);
    normal(a, a) += weight;
    normal(b, b) += weight;
    normal(a, b) -= weight;
    normal(b, a) -= weight;
    right.row(a) -= weight * step.mean;
    right.row(b) += weight * step.mean;
  }

  /// How far the first or last slice, whichever is nearer, lies off the straight line through the
  /// third and fourth from there; infinity where that cannot be told.
  double endOffLine(Eigen::Index row) const {
    const Eigen::Index end = row - first_ <= last_ - row ? first_ : last_,
                       step = end == first_ ? 1 : -1;
    if (last_ - first_ < 4 || known_[end] == 0) return std::numeric_limits<double>::infinity();
    return (places_.row(end) - 3 * places_.row(end + 2 * step) + 2 * places_.row(end + 3 * step))
        .norm();
  }

  /// Unknown are the places x and the line c, with x - c normal.
  Explanation explain(double deviation) const {
    const Eigen::Index n = count_;
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(2 * n, 2 * n);
    Places right = Places::Zero(2 * n, 2);
    double given = 0;
    for (const Step& step : steps_) {
      add(step, normal, right);
      given += (step.mean / step.deviation).squaredNorm();
    }
    const double tight = 1 / (deviation * deviation), loose = 1 / (farOff * farOff);
    for (Eigen::Index row = 0; row < n; ++row) {
      const double tie = present_[row] > 0 && known_[row] == 0 ? loose : tight;
      normal(row, row) += tie;
      normal(n + row, n + row) += tie;
      normal(row, n + row) -= tie;
      normal(n + row, row) -= tie;
    }
    Eigen::MatrixXd rough = differences_ / usualBend;
    for (Eigen::Index r = 0; r < rough.rows(); ++r)
      if (r <= first_ || r + n - rough.rows() >= last_) rough.row(r) /= atEnds;
    normal.bottomRightCorner(n, n) += rough.transpose() * rough;
    normal.diagonal().array() += 1e-7;
    const Eigen::LLT<Eigen::MatrixXd> factor(normal);
    Eigen::MatrixXd inverse = factor.solve(Eigen::MatrixXd::Identity(2 * n, 2 * n));
    Places solution = inverse * right;

    Explanation found;
    found.deviation = deviation;
    // Of both axes.
    found.evidence = -2 * std::log(deviation) * known_.sum() -
                     2 * factor.matrixLLT().diagonal().array().log().sum() -
                     0.5 * (given - right.cwiseProduct(solution).sum());
    // u of a row, how its solution answers to a force on it, and its variance.
    const auto offOf = [&](Eigen::Index row) {
      return Place(solution.row(row) - solution.row(n + row));
    };
    const auto varianceOf = [&](Eigen::Index row) {
      return inverse(row, row) + inverse(n + row, n + row) - 2 * inverse(row, n + row);
    };
    const auto freed = [&](Eigen::Index row, double tie) {
      return Place(offOf(row) / (1 - varianceOf(row) * tie));
    };
    const double loosened = tight - loose;
    while (found.far.size() < static_cast<size_t>(n) / 3 + 1) {
      Eigen::Index best = -1;
      double most = 0;
      for (Eigen::Index row = 0; row < n; ++row) {
        const int depth = depth_[static_cast<size_t>(row)];
        if (known_[row] == 0 || depth < 1 ||
            std::find(found.far.begin(), found.far.end(), row) != found.far.end())
          continue;
        const double size = freed(row, tight).norm();
        if (size < SliceAlignmentLimits::least || (depth < 2 && !(endOffLine(row) <= size)))
          continue;
        const double left = 1 - loosened * varianceOf(row);
        const double gain = 2 * std::log(deviation / farOff) - std::log(left) +
                            0.5 * loosened * offOf(row).squaredNorm() / left;
        if (gain > most + 1e-9) {
          most = gain;
          best = row;
        }
      }
      if (best < 0) break;
      found.far.push_back(best);
      found.evidence += most;
      const double factorOf = loosened / (1 - loosened * varianceOf(best));
      const Place off = offOf(best);
      const Eigen::VectorXd answer = inverse.col(best) - inverse.col(n + best);
      solution += factorOf * answer * off;
      inverse += factorOf * answer * answer.transpose();
    }
    found.off = Places::Zero(n, 2);
    for (Eigen::Index row = 0; row < n; ++row)
      if (present_[row] > 0 && (known_[row] == 0 || std::find(found.far.begin(), found.far.end(),
                                                              row) != found.far.end()))
        found.off.row(row) = freed(row, loose);
    return found;
  }

  Explanation explain() const {
    Explanation best;
    for (const double deviation : deviations) {
      Explanation found = explain(deviation);
      if (best.off.rows() == 0 || found.evidence > best.evidence + 1e-9) best = std::move(found);
    }
    return best;
  }

  Places movesOfFew(const Explanation& explanation) const {
    Places moves = -explanation.off;
    const double least = std::max(SliceAlignmentLimits::least, 1.5 * voxel_);
    for (Eigen::Index row = 0; row < count_; ++row)
      if (moves.row(row).norm() < least) moves.row(row).setZero();
    return moves;
  }

  /// Of places along one axis and the other, in mm, what third differences say of their noise.
  double noise() const {
    std::vector<double> sizes;
    for (Eigen::Index row = 0; row < differences_.rows(); ++row) {
      const auto d = differences_.row(row);
      bool good = true;
      for (Eigen::Index i = 0; i < count_; ++i) good = good && (d[i] == 0 || known_[i] > 0);
      if (!good) continue;
      for (int a = 0; a < 2; ++a) sizes.push_back(std::fabs(d.dot(places_.col(a))) / d.norm());
    }
    return normalDeviation * medianOf(sizes);
  }

  /// The smooth line through places, robustly; those without weight follow from the others.
  Places trend(double noise) const {
    const double scale = std::max({noise, usualNoise, 0.5 * voxel_});
    const double smoothing = std::max(
        (noise * noise - 0.1 * usualNoise * usualNoise) / (usualBend * usualBend), leastSmoothing);
    const Eigen::MatrixXd rough = smoothing * differences_.transpose() * differences_;
    Eigen::VectorXd weights = known_;
    Places line = places_;
    for (int i = 0; i < reweightings; ++i) {
      Eigen::MatrixXd normal = rough;
      normal.diagonal().array() += weights.array() + 1e-9;
      line = normal.ldlt().solve(weights.asDiagonal() * places_);
      for (Eigen::Index k = 0; k < count_; ++k) {
        const double off = (places_.row(k) - line.row(k)).norm() / (tukey * scale),
                     left = std::max(1 - off * off, 0.0);
        weights[k] = known_[k] * (left * left + 1e-6);
      }
    }
    return line;
  }

  Places movesOfAll() const {
    const double spread = noise();
    const bool smooth = spread < std::max(smoothDifferences, 0.8 * voxel_);
    const Places line = trend(spread);
    Places moves = Places::Zero(count_, 2);
    for (Eigen::Index row = 0; row < count_; ++row) {
      const bool alone = known_[row] == 0, outermost = depth_[static_cast<size_t>(row)] == 0;
      if (present_[row] == 0 || (outermost && !alone)) continue;
      Place move = line.row(row) - places_.row(row);
      if (!alone) {
        const Place middle = (line.row(row - 1) + line.row(row + 1)) / 2 - places_.row(row);
        for (int a = 0; a < 2; ++a) move[a] = smaller(move[a], middle[a]);
      }
      if (smooth && move.norm() < std::max(leastInRough, 1.5 * voxel_)) continue;
      moves.row(row) = move;
    }
    return moves;
  }

  Place unit_;
  double voxel_;
  int low_ = 0;
  Eigen::Index count_ = 0;
  size_t labelled_ = 0;                // slices that most phases have
  Eigen::Index first_ = 0, last_ = 0;  // rows of the first and last of these
  Eigen::VectorXd present_, known_;    // how many phases have it; 1: it meets a slice beside it
  std::vector<int> depth_;             // slices beyond it at the nearer end, in most phases
  std::vector<Step> steps_;
  Eigen::MatrixXd differences_;
  Places places_;  // mm, by the steps alone
};

std::map<int, SliceShift> jointShifts(const StackPhases& phases, const Place& unit) {
  return JointStack(phases, stepsOf(phases, unit), unit).shifts();
}

}  // namespace

std::vector<PhaseAlignment> alignSlices(const std::vector<std::vector<SlicePlace>>& phases,
                                        const Vector3& spacing) {
  const Place unit = spacing.head<2>().transpose();
  std::vector<PhaseAlignment> alignments(phases.size());
  int number = 0;
  for (const std::vector<size_t>& sequence : sequencesOf(phases, unit)) {
    StackPhases members;
    for (const size_t p : sequence) members.push_back(&phases[p]);
    const StepsOfStack steps = stepsOf(members, unit);
    const std::map<int, SliceShift> joint = JointStack(members, steps, unit).shifts();
    for (const size_t p : sequence) {
      PhaseAlignment& alignment = alignments[p];
      alignment.sequence = number;
      alignment.apart = apartFrom(steps, phases[p], unit, members.size());
      const std::map<int, SliceShift> own =
          alignment.apart.empty() ? std::map<int, SliceShift>() : jointShifts({&phases[p]}, unit);
      for (const SlicePlace& place : phases[p]) {
        const bool apart = std::find(alignment.apart.begin(), alignment.apart.end(), place.slice) !=
                           alignment.apart.end();
        const std::map<int, SliceShift>& shifts = apart ? own : joint;
        const auto found = shifts.find(place.slice);
        if (found != shifts.end())
          alignment.shifts.push_back({place.slice, found->second.voxels, !place.meets});
      }
    }
    ++number;
  }
  return alignments;
}

std::vector<SliceShift> findSliceShifts(const Mask& mask, const Vector3& spacing) {
  return alignSlices({slicePlaces(mask)}, spacing).front().shifts;
}

Eigen::Vector2i moveSlices(Mask& mask, const std::vector<SliceShift>& shifts) {
  Eigen::Vector2i low = Eigen::Vector2i::Zero(), high = Eigen::Vector2i::Zero();
  std::vector<Eigen::Vector2i> of(static_cast<size_t>(mask.size[2]), Eigen::Vector2i::Zero());
  for (const SliceShift& shift : shifts) {
    of[static_cast<size_t>(shift.slice)] = shift.voxels;
    low = low.cwiseMax(-shift.voxels);
    high = high.cwiseMax(shift.voxels);
  }
  Mask moved(mask.size + Eigen::Vector3i(low[0] + high[0], low[1] + high[1], 0));
  for (int k = 0; k < mask.size[2]; ++k) {
    const Eigen::Vector2i to = low + of[static_cast<size_t>(k)];
    for (int j = 0; j < mask.size[1]; ++j)
      std::copy_n(
          mask.values.begin() + static_cast<std::ptrdiff_t>(mask.index(0, j, k)), mask.size[0],
          moved.values.begin() + static_cast<std::ptrdiff_t>(moved.index(to[0], j + to[1], k)));
  }
  mask = std::move(moved);
  return low;
}

}  // namespace sphere_propagation
