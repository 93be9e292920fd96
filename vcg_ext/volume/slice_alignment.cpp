// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/volume/slice_alignment.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "vcg_ext/volume/distance_transform.h"
#include "vcg_ext/volume/slice_holes.h"

namespace sphere_propagation {
namespace {

using Place = Eigen::RowVector2d;
using Places = Eigen::Matrix<double, Eigen::Dynamic, 2>;

constexpr double minMeeting = 0.4;  // of the smaller slice, that lies on the other
constexpr size_t maxOutline = 200;  // points of an outline
constexpr int firstStep = 4;        // of the search, voxels
constexpr double usualBend = 1.5;   // third difference of places in a smooth organ, mm
constexpr double usualNoise = 1;    // and what registration in voxels adds, mm
constexpr double leastSmoothing = 0.05;
constexpr double tukey = 4.685;
constexpr int reweightings = 30;

/// A slice with a label: its outline, and how far everything is from it.
struct Outline {
  int slice = 0;
  long voxels = 0;
  std::vector<Eigen::Vector2i> points;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
};

double medianOf(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

class Registration {
 public:
  explicit Registration(const Mask& mask)
      : mask_(mask), distance_(signedDistance(mask, Vector3::Ones(), 2)) {
    for (int k = 0; k < mask.size[2]; ++k) {
      Outline outline;
      outline.slice = k;
      for (int j = 1; j + 1 < mask.size[1]; ++j)
        for (int i = 1; i + 1 < mask.size[0]; ++i) {
          if (mask(i, j, k) == 0) continue;
          ++outline.voxels;
          outline.centre += Eigen::Vector2d(i, j);
          if (mask(i - 1, j, k) == 0 || mask(i + 1, j, k) == 0 || mask(i, j - 1, k) == 0 ||
              mask(i, j + 1, k) == 0)
            outline.points.emplace_back(i, j);
        }
      if (outline.voxels == 0) continue;
      outline.centre /= static_cast<double>(outline.voxels);
      const size_t every = std::max<size_t>(1, outline.points.size() / maxOutline);
      std::vector<Eigen::Vector2i> some;
      for (size_t p = 0; p < outline.points.size(); p += every) some.push_back(outline.points[p]);
      outline.points = std::move(some);
      outlines_.push_back(std::move(outline));
    }
  }

  const std::vector<Outline>& outlines() const { return outlines_; }

  /// Where slice b lies, seen from slice a: 0 where they fit as they are.
  Eigen::Vector2i offset(const Outline& a, const Outline& b) const {
    const Eigen::Vector2i apart = (a.centre - b.centre).array().round().cast<int>();
    Eigen::Vector2i best = Eigen::Vector2i::Zero();
    double least = -1;
    for (const Eigen::Vector2i& start : {Eigen::Vector2i(Eigen::Vector2i::Zero()), apart}) {
      Eigen::Vector2i at = start;
      double cost = costOf(a, b, at);
      for (int step = firstStep; step > 0;) {
        Eigen::Vector2i better = at;
        for (int n = 0; n < 9; ++n) {
          const Eigen::Vector2i next = at + step * Eigen::Vector2i(n % 3 - 1, n / 3 - 1);
          const double there = costOf(a, b, next);
          if (there < cost - 1e-9) {
            cost = there;
            better = next;
          }
        }
        if (better == at)
          step /= 2;
        else
          at = better;
      }
      if (least < 0 || cost < least - 1e-9) {
        least = cost;
        best = at;
      }
    }
    return -best;
  }

  /// Whether much of the smaller of two slices lies on the other.
  bool meet(const Outline& a, const Outline& b) const {
    const size_t plane = mask_.index(0, 0, 1);
    const std::uint8_t* first = mask_.values.data() + mask_.index(0, 0, a.slice);
    const std::uint8_t* second = mask_.values.data() + mask_.index(0, 0, b.slice);
    long both = 0;
    for (size_t i = 0; i < plane; ++i) both += first[i] & second[i];
    return static_cast<double>(both) >=
           minMeeting * static_cast<double>(std::min(a.voxels, b.voxels));
  }

 private:
  /// Of b moved by a shift onto a.
  double costOf(const Outline& a, const Outline& b, const Eigen::Vector2i& shift) const {
    return (deviation(a, b.points, shift) * static_cast<double>(b.points.size()) +
            deviation(b, a.points, -shift) * static_cast<double>(a.points.size())) /
           static_cast<double>(a.points.size() + b.points.size());
  }
  double deviation(const Outline& of, const std::vector<Eigen::Vector2i>& points,
                   const Eigen::Vector2i& shift) const {
    values_.clear();
    for (const Eigen::Vector2i& point : points) {
      const Eigen::Vector2i x =
          (point + shift).cwiseMax(0).cwiseMin(mask_.size.head<2>() - Eigen::Vector2i::Ones());
      // What is beyond the grid is as much farther away.
      const double beyond = (point + shift - x).cast<double>().norm();
      values_.push_back(static_cast<double>(distance_[mask_.index(x[0], x[1], of.slice)]) - beyond);
    }
    std::vector<double> sorted = values_;
    const double middle = medianOf(sorted);
    double sum = 0;
    for (const double value : values_) sum += std::fabs(value - middle);
    return sum / static_cast<double>(values_.size());
  }

  const Mask& mask_;
  std::vector<float> distance_;
  std::vector<Outline> outlines_;
  mutable std::vector<double> values_;
};

/// Rows: differences of this order of neighbours.
Eigen::MatrixXd differencesOf(Eigen::Index count, int order) {
  Eigen::MatrixXd d = Eigen::MatrixXd::Identity(count, count);
  for (int i = 0; i < order; ++i) d = (d.bottomRows(d.rows() - 1) - d.topRows(d.rows() - 1)).eval();
  return d;
}

/// Of places along one axis and the other, in mm, what third differences say of their noise.
double noiseOf(const Places& places, const Eigen::VectorXd& known, const Eigen::MatrixXd& d) {
  std::vector<double> sizes;
  for (Eigen::Index row = 0; row < d.rows(); ++row) {
    bool good = true;
    for (Eigen::Index i = 0; i < d.cols(); ++i) good = good && (d(row, i) == 0 || known[i] > 0);
    if (!good) continue;
    for (int a = 0; a < 2; ++a)
      sizes.push_back(std::fabs(d.row(row).dot(places.col(a))) / d.row(row).norm());
  }
  return sizes.empty() ? 0 : medianOf(sizes) / 0.6745;
}

/// The smooth line through places, robustly; those without weight follow from the others.
Places trendOf(const Places& places, const Eigen::VectorXd& known, double noise, double scale,
               const Eigen::MatrixXd& d) {
  const double smoothing = std::max(
      (noise * noise - 0.1 * usualNoise * usualNoise) / (usualBend * usualBend), leastSmoothing);
  const Eigen::MatrixXd rough = smoothing * d.transpose() * d;
  Eigen::VectorXd weights = known;
  Places trend = places;
  for (int i = 0; i < reweightings; ++i) {
    Eigen::MatrixXd normal = rough;
    normal.diagonal().array() += weights.array() + 1e-9;
    trend = normal.ldlt().solve(weights.asDiagonal() * places);
    for (Eigen::Index k = 0; k < places.rows(); ++k) {
      const double off = (places.row(k) - trend.row(k)).norm() / (tukey * scale),
                   left = std::max(1 - off * off, 0.0);
      weights[k] = known[k] * (left * left + 1e-6);
    }
  }
  return trend;
}

/// The smaller of two numbers of the same sign; else 0.
double smaller(double a, double b) {
  if (a * b <= 0) return 0;
  return std::fabs(a) < std::fabs(b) ? a : b;
}

/// How far the outermost slice at one end lies off the straight line through the third and fourth
/// one; infinity where that cannot be told.
double endInLine(const Places& places, const std::vector<Outline>& outlines,
                 const std::vector<char>& alone, bool low) {
  const auto number = [&](size_t i) { return low ? i : outlines.size() - 1 - i; };
  if (outlines.size() < 5 || alone[number(0)] != 0) return std::numeric_limits<double>::infinity();
  const auto row = [&](size_t i) { return outlines[number(i)].slice - outlines.front().slice; };
  const Place third = places.row(row(2)), fourth = places.row(row(3));
  const double steps = static_cast<double>(row(0) - row(2)) / (row(2) - row(3));
  return (places.row(row(0)) - (third + steps * (third - fourth))).norm();
}

}  // namespace

std::vector<SliceShift> findSliceShifts(const Mask& mask, const Vector3& spacing) {
  const SliceHoles holes(mask);
  const Registration registration(holes.filled());
  const std::vector<Outline>& outlines = registration.outlines();
  const auto slices = static_cast<Eigen::Index>(outlines.size());
  std::vector<SliceShift> shifts;
  if (slices < 3) return shifts;

  const Place unit = spacing.head<2>().transpose();
  const double voxel = unit.maxCoeff();
  // One row per slice from the first to the last, those without a label unknown.
  const int first = outlines.front().slice;
  const Eigen::Index count = outlines.back().slice - first + 1;
  Places places = Places::Zero(count, 2);
  Eigen::VectorXd known = Eigen::VectorXd::Zero(count);
  std::vector<char> alone(static_cast<size_t>(slices), 0);
  Eigen::Vector2i at = Eigen::Vector2i::Zero();
  for (Eigen::Index s = 0; s < slices; ++s) {
    const auto i = static_cast<size_t>(s);
    const Outline& here = outlines[i];
    if (s > 0) at += registration.offset(outlines[i - 1], here);
    const bool meets = (s > 0 && registration.meet(outlines[i - 1], here)) ||
                       (s + 1 < slices && registration.meet(here, outlines[i + 1]));
    alone[i] = meets ? 0 : 1;
    places.row(here.slice - first) = at.cast<double>().transpose().cwiseProduct(unit);
    known[here.slice - first] = meets ? 1 : 0;
  }
  if (known.sum() < 2) return shifts;
  const Eigen::MatrixXd d = differencesOf(count, known.sum() > 5 ? 3 : 2);
  const double noise = noiseOf(places, known, d),
               scale = std::max({noise, usualNoise, 0.5 * voxel});
  const bool smooth = noise < std::max(SliceAlignmentLimits::smoothNoise, 0.8 * voxel);
  const Places trend = trendOf(places, known, noise, scale, d);

  for (Eigen::Index s = 0; s < slices; ++s) {
    const auto i = static_cast<size_t>(s);
    const Eigen::Index row = outlines[i].slice - first;
    const bool outermost = s == 0 || s + 1 == slices;
    if (outermost && alone[i] == 0) continue;
    Place move = trend.row(row) - places.row(row);
    const double least = std::max(SliceAlignmentLimits::least, 1.5 * voxel);
    if (!outermost && alone[i] == 0) {
      const Place middle = (trend.row(row - 1) + trend.row(row + 1)) / 2 - places.row(row);
      for (int a = 0; a < 2; ++a) move[a] = smaller(move[a], middle[a]);
      // Next to the first or last slice: is it off, or does that one bend away?
      if (smooth && (s == 1 || s + 2 == slices) &&
          !(endInLine(places, outlines, alone, s == 1) <= move.norm()))
        continue;
    }
    if (smooth && move.norm() < least) continue;
    const Eigen::Vector2i voxels = move.cwiseQuotient(unit).transpose().array().round().cast<int>();
    if (voxels != Eigen::Vector2i::Zero())
      shifts.push_back({outlines[i].slice, voxels, alone[i] != 0});
  }
  return shifts;
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
