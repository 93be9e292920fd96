// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/area/area_minimiser.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace sphere_propagation {
namespace {

/// A face may shrink in one step to this share of what it has, or of what it should have.
constexpr double shrinkage = 0.1;

std::array<Vector3, 3> cornersOf(const Triangles& faces, const Points& positions, int f) {
  const int* v = faces.data() + 3 * static_cast<Eigen::Index>(f);
  return {positions.row(v[0]).transpose(), positions.row(v[1]).transpose(),
          positions.row(v[2]).transpose()};
}

Eigen::Vector2f times(const Eigen::Matrix2f& block, const Eigen::Vector2f& x) {
  return {block(0, 0) * x[0] + block(0, 1) * x[1], block(1, 0) * x[0] + block(1, 1) * x[1]};
}

/// The columns of block x, one after the other: four products in one register.
Eigen::Array4f columnsTimes(const Eigen::Matrix2f& block, const Eigen::Vector2f& x) {
  return Eigen::Map<const Eigen::Array4f>(block.data()) * Eigen::Array4f(x[0], x[0], x[1], x[1]);
}

}  // namespace

AreaMinimiser::AreaMinimiser(FaceRings rings, std::vector<FaceTarget> targets, ThreadPool* pool)
    : rings_(std::move(rings)),
      targets_(std::move(targets)),
      pool_(pool != nullptr ? pool : &ownPool_) {
  const auto n = static_cast<size_t>(rings_.vertexCount());
  column_.resize(rings_.corner.size());
  pool_->forRanges(static_cast<int>(column_.size()), [&](int begin, int end) {
    for (int i = begin; i < end; ++i) column_[i] = rings_.second(rings_.corner[i]);
  });
  terms_.resize(targets_.size());
  diagonal_.resize(n);
  frame_.resize(n);
  preconditioner_.resize(n);
  offDiagonal_.resize(column_.size());
  for (auto* vector : {&gradient_, &step_, &residual_, &search_, &image_}) vector->resize(n);
  solidAngle_.resize(targets_.size());
  share_.resize(n);
  held_.resize(static_cast<size_t>(ThreadPool::rangesOf(rings_.faceCount())));
  trial_.resize(rings_.vertexCount(), 3);
  best_.resize(rings_.vertexCount(), 3);
}

double AreaMinimiser::energy(const AreaEnergyWeights& weights, const Points& positions) const {
  return pool_->sum(rings_.faceCount(), [&](int begin, int end) {
    double sum = 0;
    for (int f = begin; f < end; ++f) {
      const auto p = cornersOf(rings_.faces, positions, f);
      sum += faceEnergy(targets_[f], weights, solidAngle(p[0], p[1], p[2]), p);
    }
    return sum;
  });
}

double AreaMinimiser::step(const AreaStepParameters& parameters, Points& positions) {
  const double before = expandFaces(parameters, positions);
  if (!(before > 0) || !std::isfinite(before)) return 1;  // 0 cannot be lowered
  assemble(positions);
  const double promised = solve(parameters);
  constexpr int halvings = 14;
  double least = before, length = 1;
  for (int i = 0; i < halvings; ++i, length /= 2) {
    bool shortened = false;
    const double after = take(length, parameters, positions, shortened);
    if (after < least) {
      least = after;
      best_.swap(trial_);
      if (i == 0 && !shortened && before - after > 0.75 * promised) break;
    } else if (least < before) {
      break;  // shorter steps were better so far, this one is not
    }
  }
  if (least < before) positions.swap(best_);
  return least / before;
}

/// Returns the energy; not a number where a face has no solid angle.
double AreaMinimiser::expandFaces(const AreaStepParameters& parameters, const Points& positions) {
  return pool_->sum(rings_.faceCount(), [&](int begin, int end) {
    double sum = 0;
    for (int f = begin; f < end; ++f) {
      const auto p = cornersOf(rings_.faces, positions, f);
      std::array<std::array<Vector3, 2>, 3> frame;
      for (int k = 0; k < 3; ++k) tangentFrame(p[k], frame[k][0], frame[k][1]);
      const FaceExpansion e = expandFaceEnergy(targets_[f], parameters.weights, p, frame);
      sum += e.energy;
      solidAngle_[f] = e.solidAngle;
      FaceTerms& terms = terms_[f];
      terms.slope = static_cast<float>(e.slope);
      terms.curvature = static_cast<float>(e.curvature);
      terms.shapeWeight = static_cast<float>(e.shapeWeight);
      const double flatArea = 0.5 * (p[1] - p[0]).cross(p[2] - p[0]).norm() + 1e-300;
      for (int k = 0; k < 3; ++k) {
        terms.logArea[k] = e.logArea[k].cast<float>();
        terms.quotient[k] = e.quotient[k].cast<float>();
        // Damping: the Dirichlet energy of the displacement, cotangents of the triangle on the
        // sphere, kept within bounds.
        const double cotangent =
            0.25 * (p[(k + 1) % 3] - p[k]).dot(p[(k + 2) % 3] - p[k]) / flatArea;
        terms.tie[k] =
            static_cast<float>(e.tie[k] + parameters.damping * std::clamp(cotangent, 0.005, 10.0));
      }
    }
    return sum;
  });
}

/// The rows of the Hessian: each vertex gathers what its faces hold, so that threads do not meet.
void AreaMinimiser::assemble(const Points& positions) {
  pool_->forRanges(rings_.vertexCount(), [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      Vector3 t1, t2;
      tangentFrame(positions.row(v).transpose(), t1, t2);
      frame_[v] << t1.cast<float>(), t2.cast<float>();
    }
  });
  pool_->forRanges(rings_.vertexCount(), [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      const int first = rings_.offset[v], last = rings_.offset[v + 1];
      const Frame frame = frame_[v];
      Tangent2 gradient = Tangent2::Zero();
      double diagonal[3] = {0, 0, 0};
      // What the face before holds of the edge that it shares with this one, that to its third
      // vertex.
      int before = rings_.corner[last - 1];
      Block block = coupling(before, false);
      float tie = terms_[before / 3].tie[(before + 1) % 3];
      for (int i = first; i < last; ++i) {
        const int c = rings_.corner[i], f = c / 3, k = c - 3 * f, l = k == 2 ? 0 : k + 1,
                  m = k == 0 ? 2 : k - 1;
        const FaceTerms& t = terms_[f];
        const Tangent2 &g = t.logArea[k], &d = t.quotient[k];
        gradient += t.slope * g + t.shapeWeight * d;
        const float ties = t.tie[l] + t.tie[m];
        diagonal[0] +=
            static_cast<double>(t.curvature * g[0] * g[0] - 2 * t.shapeWeight * d[0] * g[0] + ties);
        diagonal[1] += static_cast<double>(t.curvature * g[0] * g[1] -
                                           t.shapeWeight * (d[0] * g[1] + d[1] * g[0]));
        diagonal[2] +=
            static_cast<double>(t.curvature * g[1] * g[1] - 2 * t.shapeWeight * d[1] * g[1] + ties);
        block += coupling(c, true);
        tie += t.tie[m];
        const Frame& other = frame_[column_[i]];
        for (int y = 0; y < 2; ++y)
          for (int x = 0; x < 2; ++x)
            block(x, y) -=
                tie * (frame[3 * x] * other[3 * y] + frame[3 * x + 1] * other[3 * y + 1] +
                       frame[3 * x + 2] * other[3 * y + 2]);
        offDiagonal_[i] = block;
        block = coupling(c, false);
        tie = t.tie[l];
      }
      gradient_[v] = gradient;
      diagonal[0] *= 1 + 1e-6;
      diagonal[2] *= 1 + 1e-6;
      const double scale = 1 / (diagonal[0] * diagonal[2] - diagonal[1] * diagonal[1]);
      const auto cast = [](double x) { return static_cast<float>(x); };
      diagonal_[v] << cast(diagonal[0]), cast(diagonal[1]), cast(diagonal[1]), cast(diagonal[2]);
      preconditioner_[v] << cast(scale * diagonal[2]), cast(-scale * diagonal[1]),
          cast(-scale * diagonal[1]), cast(scale * diagonal[0]);
      if (!stays_.empty() && stays_[static_cast<size_t>(v)]) preconditioner_[v].setZero();
    }
  });
}

/// What the face of corner c adds to the block of that corner's vertex and the next one (`forward`)
/// or the one before: curvature l l^T - w (d l^T + l d^T).
AreaMinimiser::Block AreaMinimiser::coupling(int c, bool forward) const {
  const int f = c / 3, k = c - 3 * f, other = forward ? (k == 2 ? 0 : k + 1) : (k == 0 ? 2 : k - 1);
  const FaceTerms& t = terms_[f];
  const Tangent2 a = t.curvature * t.logArea[k] - t.shapeWeight * t.quotient[k],
                 b = t.shapeWeight * t.logArea[k];
  const Tangent2 &g = t.logArea[other], &d = t.quotient[other];
  Block block;
  block << a[0] * g[0] - b[0] * d[0], a[0] * g[1] - b[0] * d[1], a[1] * g[0] - b[1] * d[0],
      a[1] * g[1] - b[1] * d[1];
  return block;
}

/// image = H x; returns their dot product.
double AreaMinimiser::multiply(const std::vector<Tangent2>& x) {
  return pool_->sum(rings_.vertexCount(), [&](int begin, int end) {
    double sum = 0;
    for (int v = begin; v < end; ++v) {
      Eigen::Array4f columns = columnsTimes(diagonal_[v], x[v]);
      for (int j = rings_.offset[v]; j < rings_.offset[v + 1]; ++j)
        columns += columnsTimes(offDiagonal_[j], x[column_[j]]);
      const Tangent2 row(columns[0] + columns[2], columns[1] + columns[3]);
      image_[v] = row;
      sum += static_cast<double>(x[v].dot(row));
    }
    return sum;
  });
}

/// Conjugate gradients for H step = -gradient. Returns by how much the quadratic model then falls.
double AreaMinimiser::solve(const AreaStepParameters& parameters) {
  const int n = rings_.vertexCount();
  double rho = pool_->sum(n, [&](int begin, int end) {
    double sum = 0;
    for (int v = begin; v < end; ++v) {
      step_[v].setZero();
      residual_[v] = -gradient_[v];
      search_[v] = times(preconditioner_[v], residual_[v]);
      sum += static_cast<double>(residual_[v].dot(search_[v]));
    }
    return sum;
  });
  const double enough =
      rho * parameters.conjugateGradientTolerance * parameters.conjugateGradientTolerance;
  for (int i = 0; i < parameters.conjugateGradientIterations && rho > enough; ++i) {
    const double curvature = multiply(search_);
    if (!(curvature > 0)) break;  // rounding
    const auto alpha = static_cast<float>(rho / curvature);
    const double next = pool_->sum(n, [&](int begin, int end) {
      double sum = 0;
      for (int v = begin; v < end; ++v) {
        step_[v] += alpha * search_[v];
        const Tangent2 r = residual_[v] - alpha * image_[v], z = times(preconditioner_[v], r);
        residual_[v] = r;
        image_[v] = z;
        sum += static_cast<double>(r.dot(z));
      }
      return sum;
    });
    const auto beta = static_cast<float>(next / rho);
    rho = next;
    pool_->forRanges(n, [&](int begin, int end) {
      for (int v = begin; v < end; ++v) search_[v] = image_[v] + beta * search_[v];
    });
  }
  return -0.5 * pool_->sum(n, [&](int begin, int end) {
    double sum = 0;
    for (int v = begin; v < end; ++v) sum += static_cast<double>(gradient_[v].dot(step_[v]));
    return sum;
  });
}

void AreaMinimiser::move(int v, const Points& positions) {
  Vector3 p = positions.row(v).transpose();
  if (share_[v] > 0) {
    Vector3 t1, t2;
    tangentFrame(p, t1, t2);
    const double share = share_[v];
    p = (p + share * step_[v][0] * t1 + share * step_[v][1] * t2).normalized();
  }
  trial_.row(v) = p.transpose();
}

/// Whether face f may lie as trial_ says when it comes from `positions`; its solid angle and
/// corners there.
bool AreaMinimiser::isAdmissible(int f, const Points& positions, double& s,
                                 std::array<Vector3, 3>& p) const {
  p = cornersOf(rings_.faces, trial_, f);
  s = solidAngle(p[0], p[1], p[2]);
  // A start beyond the limits is no reason to stand still: it must not get worse.
  if (!(s > shrinkage * std::min(solidAngle_[f], targets_[f].area)) ||
      (s < Admissible::minSolidAngle && s < solidAngle_[f]) ||
      (s > Admissible::maxSolidAngle && s > solidAngle_[f]))
    return false;
  for (int k = 0; k < 3; ++k) {
    const int l = k == 2 ? 0 : k + 1;
    const double cosine = p[k].dot(p[l]);
    if (cosine < Admissible::minCosine &&
        cosine < positions.row(rings_.faces(f, k)).dot(positions.row(rings_.faces(f, l))) - 1e-12)
      return false;
  }
  return true;
}

/// Moves all vertices by `length` of the step into trial_, less where a face would degenerate
/// (`shortened`); returns the energy there.
double AreaMinimiser::take(double length, const AreaStepParameters& parameters,
                           const Points& positions, bool& shortened) {
  pool_->forRanges(rings_.vertexCount(), [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      share_[v] = static_cast<float>(length);
      move(v, positions);
    }
  });
  constexpr int rounds = 30,
                stopping =
                    20;  // after `stopping` rounds the vertices of a bad face stay where they are
  std::vector<int> held, moved, touched;
  for (int round = 0; round < rounds || held.empty(); ++round) {
    if (held.empty()) {
      const double energy = pool_->sum(rings_.faceCount(), [&](int begin, int end) {
        std::vector<int>& bad = held_[begin / ThreadPool::rangeSize];
        bad.clear();
        double sum = 0, s = 0;
        std::array<Vector3, 3> p;
        for (int f = begin; f < end; ++f)
          if (!isAdmissible(f, positions, s, p))
            bad.push_back(f);
          else if (bad.empty())
            sum += faceEnergy(targets_[f], parameters.weights, s, p);
        return sum;
      });
      held.clear();
      for (const std::vector<int>& bad : held_) held.insert(held.end(), bad.begin(), bad.end());
      if (held.empty()) return energy;
    }
    shortened = true;
    // Only what the held faces' vertices touch has to be looked at again.
    moved.clear();
    for (int f : held)
      for (int k = 0; k < 3; ++k) {
        const int v = rings_.faces(f, k);
        share_[v] = round < stopping ? 0.6F * share_[v] : 0;
        moved.push_back(v);
      }
    std::sort(moved.begin(), moved.end());
    moved.erase(std::unique(moved.begin(), moved.end()), moved.end());
    touched.clear();
    for (int v : moved) {
      move(v, positions);
      for (int i = rings_.offset[v]; i < rings_.offset[v + 1]; ++i)
        touched.push_back(rings_.corner[i] / 3);
    }
    std::sort(touched.begin(), touched.end());
    touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
    held.clear();
    double s = 0;
    std::array<Vector3, 3> p;
    for (int f : touched)
      if (!isAdmissible(f, positions, s, p)) held.push_back(f);
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace sphere_propagation
