// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/leave_one_out.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace sphere_propagation {
namespace {

using Array = Eigen::ArrayXd;

constexpr double machine = std::numeric_limits<double>::epsilon();

/// A part of the secular equation's sum w_j / (d_j - mu), as a series about some mu.
struct SecularSum {
  double value = 0, slope = 0, curvature = 0;

  SecularSum operator+(const SecularSum& other) const {
    return {value + other.value, slope + other.slope, curvature + other.curvature};
  }
  SecularSum continued(double step) const {
    return {value + step * (slope + step * curvature), slope + 2 * step * curvature, curvature};
  }
};

/// D - rho x x^T for one x: eigenvalues from the largest on, and what rho x has along their
/// vectors.
class Downdate {
 public:
  struct Mode {
    double eigenvalue = 0;
    double square = 0;              ///< of rho x along it
    double origin = 0, offset = 0;  ///< eigenvalue = origin + offset, exactly
  };

  /// d: falling, > 0. null: where rho x^T D^-1 x comes that close to 1, where it is when nothing is
  /// left along a direction, the smallest eigenvalue is 0.
  Downdate(const Array& d, const Array& x, double rho, double null) : rho_(rho) {
    const double negligible = 1e-30 * x.square().sum();
    poles_.resize(d.size());
    weights_.resize(d.size());
    for (Eigen::Index j = 0; j < d.size(); ++j) {
      const double weight = rho * x[j] * x[j];
      if (!(x[j] * x[j] > negligible)) {  // x is no part of this one, which stays
        untouched_.push_back(d[j]);
      } else if (count_ > 0 && poles_[count_ - 1] == d[j]) {  // x takes one direction of the plane
        untouched_.push_back(d[j]);
        weights_[count_ - 1] += weight;
      } else {
        poles_[count_] = d[j];
        weights_[count_++] = weight;
      }
    }
    poles_.conservativeResize(count_);
    weights_.conservativeResize(count_);
    total_ = rho * weights_.sum();
    singular_ = 1 - (weights_ / poles_).sum() <= null;
  }

  double squareOfWhole() const { return total_; }
  /// Whether the last mode spans nothing: x is not in the span of the others.
  bool singular() const { return singular_; }

  /// The next mode.
  Mode next() {
    if (root_ < count_ && !known_) {
      upcoming_ = solve(root_);
      known_ = true;
    }
    if (known_ && (kept_ == untouched_.size() || upcoming_.eigenvalue > untouched_[kept_])) {
      known_ = false;
      ++root_;
      return upcoming_;
    }
    return {untouched_[kept_++]};
  }

 private:
  /// sum over poles begin .. end - 1 at mu = origin + t. All of the time goes here: four terms at a
  /// time, which compilers make vectors of.
  SecularSum sum(Eigen::Index begin, Eigen::Index end, double origin, double t) const {
    constexpr int lanes = 4;
    double value[lanes] = {}, slope[lanes] = {}, curvature[lanes] = {};
    const auto add = [&](Eigen::Index j, int lane) {
      const double inverse = 1 / ((poles_[j] - origin) - t);
      const double first = weights_[j] * inverse, second = first * inverse;
      value[lane] += first;
      slope[lane] += second;
      curvature[lane] += second * inverse;
    };
    Eigen::Index j = begin;
    for (; j + lanes <= end; j += lanes)
      for (int lane = 0; lane < lanes; ++lane) add(j + lane, lane);
    for (; j < end; ++j) add(j, 0);
    return {(value[0] + value[1]) + (value[2] + value[3]),
            (slope[0] + slope[1]) + (slope[2] + slope[3]),
            (curvature[0] + curvature[1]) + (curvature[2] + curvature[3])};
  }

  /// What is left of the shape along a vector with this slope of the sum.
  Mode mode(double origin, double offset, double slope) const {
    return {origin + offset, rho_ / slope, origin, offset};
  }

  /// The zero below pole l, mu as the distance t from its nearer pole, so that differences are
  /// exact. Poles far off are summed up once or twice per zero, and their sum continued from there.
  Mode solve(Eigen::Index l) {
    const bool last = l + 1 == count_;
    if (last && singular_) return mode(0, 0, sum(0, count_, 0, 0).slope);
    const double upper = poles_[l], lower = last ? 0 : poles_[l + 1];
    const Eigen::Index begin = std::max<Eigen::Index>(0, l + 1 - near),
                       end = std::min(count_, l + 1 + near);
    double origin = upper, t = -(upper - lower) / 2, from = 2 * t, to = 0, slope = 0;
    for (int round = 0; round < 20; ++round) {
      const double start = t;
      const SecularSum farAbove = sum(0, begin, origin, t), farBelow = sum(end, count_, origin, t);
      SecularSum above = sum(begin, l + 1, origin, t) + farAbove,
                 below = sum(l + 1, end, origin, t) + farBelow;
      if (round == 0 && above.value + below.value > 1) {  // nearer to the lower end
        origin = lower;
        from = 0;
        to = upper - lower;
        t = to / 2;
      }
      const double base = t;
      (above.value + below.value > 1 ? to : from) = t;
      double low = from, high = to;
      for (int iteration = 0; iteration < 100; ++iteration) {
        const double excess = above.value + below.value - 1;
        slope = above.slope + below.slope;
        if (std::fabs(excess) <= 16 * machine * (1 + above.value - below.value)) break;
        (excess > 0 ? high : low) = t;
        double step = interpolated((upper - origin) - t, (lower - origin) - t, last, above, below);
        double next = t + step;
        if (!(next > low && next < high)) {
          next = (low + high) / 2;
          if (!(next > low && next < high)) break;
          step = next - t;
        }
        t = next;
        above = sum(begin, l + 1, origin, t) + farAbove.continued(t - base);
        below = sum(l + 1, end, origin, t) + farBelow.continued(t - base);
        slope = above.slope + below.slope;
        if (std::fabs(step) <= machine * std::fabs(t)) break;
      }
      double reach = std::numeric_limits<double>::infinity();  // to the next pole far off
      if (begin > 0) reach = (poles_[begin - 1] - origin) - t;
      if (end < count_) reach = std::min(reach, t - (poles_[end] - origin));
      if (std::fabs(t - base) <= exact * reach || (round > 0 && t == start)) break;
    }
    return mode(origin, t, slope);
  }

  /// Step from t to the zero of r + a / (up - s) + b / (down - s) - 1 in s, which has the values
  /// and slopes of both sums at s = 0 (J. R. Bunch, C. P. Nielsen and D. C. Sorensen, 1978); up > 0
  /// > down are the poles seen from t.
  static double interpolated(double up, double down, bool last, const SecularSum& above,
                             const SecularSum& below) {
    const double a = above.slope * up * up;
    double r = above.value - above.slope * up - 1;
    if (last) return up + a / r;  // r + a / (up - s) = 0
    const double b = below.slope * down * down;
    r += below.value - below.slope * down;
    // r (up - s)(down - s) + a (down - s) + b (up - s) = 0
    const double linear = r * (up + down) + a + b;
    const double constant = up * down * (above.value + below.value - 1);
    const double root = std::sqrt(std::max(0.0, linear * linear - 4 * r * constant));
    const double q = (linear + std::copysign(root, linear)) / 2;  // r s^2 - linear s + constant = 0
    const double first = constant / q, second = q / r;
    return first > down && first < up ? first : second;
  }

  static constexpr Eigen::Index near = 48;  // poles on each side that are summed up every time
  /// A series is exact within this share of the distance to its poles: the slope's error is the
  /// square of it.
  static constexpr double exact = 3e-7;

  Array poles_, weights_;
  std::vector<double> untouched_;
  Eigen::Index count_ = 0, root_ = 0;
  size_t kept_ = 0;
  double rho_, total_ = 0;
  bool singular_ = false, known_ = false;
  Mode upcoming_;
};

/// The others' extent along a direction, as a share of this shape's, below which (its square) the
/// direction is this shape's alone. Scores are orthogonal to 1e-13 or so of their lengths.
constexpr double beyondTheOthers = 1e-11;

/// Below this share of the whole, what is left is added up from its parts, since differences would
/// lose digits.
constexpr double smallRest = 1e-3;

Eigen::VectorXd distances(const Array& d, const Array& x, Eigen::Index shapes, Eigen::Index modes,
                          double rounding) {
  const double rho = static_cast<double>(shapes) / static_cast<double>(shapes - 1);
  Downdate downdate(d, x, rho, beyondTheOthers);
  const Eigen::Index size = d.size();
  // A singular matrix' last mode is none, nor is any beyond what the others can span.
  const Eigen::Index most = std::min(shapes - 2, size - (downdate.singular() ? 1 : 0));

  Eigen::VectorXd squares(size);  // along each mode
  Eigen::Index known = 0, counted = 0;
  const auto findMode = [&] {
    const Downdate::Mode mode = downdate.next();
    squares[known++] = mode.square;
    if (counted == known - 1 && counted < most && mode.eigenvalue > rounding * rounding) ++counted;
  };

  const double whole = downdate.squareOfWhole();
  double rest = whole;
  Eigen::VectorXd result(modes);
  for (Eigen::Index m = 0; m < modes; ++m) {
    if (known == m) findMode();
    if (counted <= m) {  // no further mode
      result.tail(modes - m).setConstant(m > 0 ? result[m - 1] : std::sqrt(whole));
      break;
    }
    rest -= squares[m];
    if (rest >= smallRest * whole) {
      result[m] = std::sqrt(rest);
      continue;
    }
    while (known < size) findMode();
    double tail = squares.tail(size - counted).sum();
    for (Eigen::Index i = modes; i < counted; ++i) tail += squares[i];
    const Eigen::Index end = std::min(counted, modes);
    for (Eigen::Index i = end - 1; i >= m; --i) {
      result[i] = std::sqrt(tail);
      tail += squares[i];
    }
    result.tail(modes - end).setConstant(result[end - 1]);
    break;
  }
  return result;
}

/// Lengths of the scores that are more than rounding, which is no mode, here or among the others.
struct Lengths {
  explicit Lengths(const Eigen::MatrixXd& scores)
      : rounding(static_cast<double>(scores.rows()) * machine * scores.norm()) {
    const Array lengths = scores.colwise().squaredNorm().transpose().array();
    squares = lengths.head((lengths > rounding * rounding).count());
  }
  double rounding;
  Array squares;
};

}  // namespace

Eigen::MatrixXd leaveOneOut(const Eigen::MatrixXd& scores, Eigen::Index modes, ThreadPool& pool,
                            const Progress& progress) {
  const Eigen::Index shapes = scores.rows();
  const Lengths lengths(scores);
  const Array& d = lengths.squares;
  Eigen::MatrixXd result(shapes, modes);
  constexpr Eigen::Index together = 64;  // between two reports
  for (Eigen::Index begin = 0; begin < shapes && modes > 0; begin += together) {
    pool.forEach(static_cast<int>(std::min(together, shapes - begin)), [&](int i) {
      result.row(begin + i) = distances(d, scores.row(begin + i).head(d.size()).transpose().array(),
                                        shapes, modes, lengths.rounding)
                                  .transpose();
    });
    report(progress,
           static_cast<double>(std::min(begin + together, shapes)) / static_cast<double>(shapes));
  }
  return result;
}

Eigen::MatrixXd leftOutApproximations(const Eigen::MatrixXd& scores, Eigen::Index shape,
                                      Eigen::Index modes) {
  const Eigen::Index shapes = scores.rows();
  const Lengths lengths(scores);
  const Array &d = lengths.squares, x = scores.row(shape).head(d.size()).transpose().array();
  const double others = static_cast<double>(shapes - 1);
  Downdate downdate(d, x, static_cast<double>(shapes) / others, beyondTheOthers);
  const Eigen::Index most = std::min(shapes - 2, d.size() - (downdate.singular() ? 1 : 0));
  Eigen::MatrixXd found = Eigen::MatrixXd::Zero(modes, scores.cols());
  Array approximation = -x / others;  // the mean of the others
  for (Eigen::Index m = 0; m < modes; ++m) {
    if (m < most) {
      const Downdate::Mode mode = downdate.next();
      // rho x is 1 / |w|^2 along w = x / (d - mu), |w|^-2 being the square.
      if (mode.square > 0 && mode.eigenvalue > lengths.rounding * lengths.rounding)
        approximation += mode.square * x / ((d - mode.origin) - mode.offset);
    }
    found.row(m).head(d.size()) = approximation.matrix().transpose();
  }
  return found;
}

}  // namespace sphere_propagation
