// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/volume/slice_places.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "vcg_ext/base/statistics.h"
#include "vcg_ext/volume/distance_transform.h"
#include "vcg_ext/volume/slice_holes.h"

namespace sphere_propagation {
namespace {

constexpr double minMeeting = 0.4;  // of the smaller slice, that lies on the other
constexpr size_t maxOutline = 200;  // points of an outline
constexpr int firstStep = 4;        // of the search, voxels
// A slice with less, and with less than this part of the widest one, is a speck.
constexpr long speckVoxels = 8;
constexpr double speckShare = 0.01;

long turn(const Eigen::Vector2i& o, const Eigen::Vector2i& a, const Eigen::Vector2i& b) {
  return static_cast<long>(a[0] - o[0]) * (b[1] - o[1]) -
         static_cast<long>(a[1] - o[1]) * (b[0] - o[0]);
}

/// A slice with a label, its holes filled.
struct Outline {
  int slice = 0;
  long voxels = 0;
  std::vector<Eigen::Vector2i> points;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  SliceHull hull;
};

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
      outline.hull = SliceHull(outline.points);
      const size_t every = std::max<size_t>(1, outline.points.size() / maxOutline);
      std::vector<Eigen::Vector2i> some;
      for (size_t p = 0; p < outline.points.size(); p += every) some.push_back(outline.points[p]);
      outline.points = std::move(some);
      outlines_.push_back(std::move(outline));
    }
    long widest = 0;
    for (const Outline& outline : outlines_) widest = std::max(widest, outline.voxels);
    const double limit = speckShare * static_cast<double>(widest);
    outlines_.erase(std::remove_if(outlines_.begin(), outlines_.end(),
                                   [&](const Outline& outline) {
                                     return outline.voxels < speckVoxels &&
                                            static_cast<double>(outline.voxels) < limit;
                                   }),
                    outlines_.end());
  }

  std::vector<Outline>& outlines() { return outlines_; }

  struct Fit {
    Eigen::Vector2i offset;  // 0 where they fit as they are
    double misfit;
  };

  /// Where slice b lies, seen from slice a.
  Fit fit(const Outline& a, const Outline& b) const {
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
    return {-best, least};
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
    std::vector<double> values;
    values.reserve(points.size());
    for (const Eigen::Vector2i& point : points) {
      const Eigen::Vector2i x =
          (point + shift).cwiseMax(0).cwiseMin(mask_.size.head<2>() - Eigen::Vector2i::Ones());
      // What is beyond the grid is as much farther away.
      const double beyond = (point + shift - x).cast<double>().norm();
      values.push_back(static_cast<double>(distance_[mask_.index(x[0], x[1], of.slice)]) - beyond);
    }
    const double middle = medianOf(values);
    double sum = 0;
    for (const double value : values) sum += std::fabs(value - middle);
    return sum / static_cast<double>(values.size());
  }

  const Mask& mask_;
  std::vector<float> distance_;
  std::vector<Outline> outlines_;
};

}  // namespace

SliceHull::SliceHull(std::vector<Eigen::Vector2i> voxels) {
  // A. M. Andrew's two chains.
  std::sort(voxels.begin(), voxels.end(), [](const Eigen::Vector2i& a, const Eigen::Vector2i& b) {
    return a[0] != b[0] ? a[0] < b[0] : a[1] < b[1];
  });
  std::vector<Eigen::Vector2i> hull;
  for (int chain = 0; chain < 2; ++chain) {
    const size_t begin = hull.size();
    for (const Eigen::Vector2i& x : voxels) {
      while (hull.size() >= begin + 2 && turn(hull[hull.size() - 2], hull.back(), x) <= 0)
        hull.pop_back();
      hull.push_back(x);
    }
    hull.pop_back();  // the next chain begins there
    std::reverse(voxels.begin(), voxels.end());
  }
  if (hull.empty()) hull.push_back(voxels.front());
  int high = low_ = hull.front()[1];
  for (const Eigen::Vector2i& x : hull) {
    low_ = std::min(low_, x[1]);
    high = std::max(high, x[1]);
  }
  const double far = std::numeric_limits<double>::infinity();
  rows_.assign(static_cast<size_t>(high - low_) + 1, {far, -far});
  for (size_t e = 0; e < hull.size(); ++e) {
    const Eigen::Vector2i &a = hull[e], &b = hull[(e + 1) % hull.size()];
    for (int y = std::min(a[1], b[1]); y <= std::max(a[1], b[1]); ++y) {
      const double t = a[1] == b[1] ? 0 : static_cast<double>(y - a[1]) / (b[1] - a[1]);
      auto& [first, last] = rows_[static_cast<size_t>(y - low_)];
      const double x = a[0] + t * (b[0] - a[0]);
      first = std::min(first, x);
      last = std::max(last, x);
    }
  }
  for (const auto& [first, last] : rows_) area_ += last - first + 1;
}

double SliceHull::common(const SliceHull& other) const {
  double area = 0;
  const int from = std::max(low_, other.low_),
            to = std::min(low_ + static_cast<int>(rows_.size()),
                          other.low_ + static_cast<int>(other.rows_.size()));
  for (int y = from; y < to; ++y) {
    const auto& mine = rows_[static_cast<size_t>(y - low_)];
    const auto& its = other.rows_[static_cast<size_t>(y - other.low_)];
    area += std::max(0.0, std::min(mine.second, its.second) - std::max(mine.first, its.first) + 1);
  }
  return area;
}

void SliceHull::move(const Eigen::Vector2i& by) {
  low_ += by[1];
  for (auto& [first, last] : rows_) {
    first += by[0];
    last += by[0];
  }
}

std::vector<SlicePlace> slicePlaces(const Mask& mask) {
  const SliceHoles holes(mask);
  Registration registration(holes.filled());
  std::vector<Outline>& outlines = registration.outlines();
  std::vector<SlicePlace> places;
  for (size_t i = 0; i < outlines.size(); ++i) {
    SlicePlace place;
    place.slice = outlines[i].slice;
    if (i > 0) {
      const Registration::Fit fit = registration.fit(outlines[i - 1], outlines[i]);
      place.step = fit.offset;
      place.misfit = fit.misfit;
    }
    places.push_back(place);
  }
  for (size_t i = 0; i < outlines.size(); ++i) {
    places[i].hull = std::move(outlines[i].hull);
    if (i == 0) continue;
    const SliceHull &a = places[i - 1].hull, &b = places[i].hull;
    places[i].misfit /= std::sqrt(std::min(a.area(), b.area()));
    if (a.common(b) >= minMeeting * std::min(a.area(), b.area()))
      places[i - 1].meets = places[i].meets = true;
  }
  return places;
}

}  // namespace sphere_propagation
