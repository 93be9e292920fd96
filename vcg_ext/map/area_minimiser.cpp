#include "vcg_ext/map/area_minimiser.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "vcg_ext/map/spherical_triangle.h"

namespace sphere_propagation {
namespace {

/// Twice what the certificate asks: what is good here is good there, whatever the rounding.
constexpr double leastSolidAngle = 2e-14;
constexpr double largestSolidAngle = 6.0;
/// An edge near to antipodal has no direction: past this cosine it may not grow.
constexpr double leastCosine = -0.9;
/// A face may shrink in one step to this share of what it has, or of what it should have.
constexpr double shrinkage = 0.1;

std::array<Vector3, 3> corners(const Triangles& faces, const Points& positions, int f) {
  return {positions.row(faces(f, 0)).transpose(), positions.row(faces(f, 1)).transpose(),
          positions.row(faces(f, 2)).transpose()};
}

}  // namespace

AreaMinimiser::AreaMinimiser(const ClosedSurface& surface, std::vector<FaceTarget> targets)
    : surface_(surface), targets_(std::move(targets)) {
  const auto n = static_cast<size_t>(surface.vertexCount()), halfEdges = 3 * static_cast<size_t>(surface.faceCount());
  rowStart_.assign(n + 1, 0);
  slot_.resize(halfEdges);
  column_.reserve(halfEdges);
  for (int v = 0; v < surface.vertexCount(); ++v) {
    for (int h : surface.outgoing(v)) {
      slot_[h] = static_cast<int>(column_.size());
      column_.push_back(surface.target(h));
    }
    rowStart_[v + 1] = static_cast<int>(column_.size());
  }
  frame_.resize(n);
  diagonal_.resize(n);
  preconditioner_.resize(n);
  offDiagonal_.resize(halfEdges);
  for (auto* vector : {&gradient_, &step_, &residual_, &search_, &image_, &scaled_}) vector->resize(n);
  solidAngle_.resize(targets_.size());
  share_.resize(n);
  trial_.resize(surface.vertexCount(), 3);
  best_.resize(surface.vertexCount(), 3);
}

double AreaMinimiser::energy(const AreaEnergyWeights& weights, const Points& positions) const {
  double sum = 0;
  for (int f = 0; f < surface_.faceCount(); ++f) {
    const auto p = corners(surface_.faces(), positions, f);
    sum += faceEnergy(targets_[f], weights, solidAngle(p[0], p[1], p[2]), p);
  }
  return sum;
}

double AreaMinimiser::step(const AreaStepParameters& parameters, Points& positions) {
  const double before = energy(parameters.weights, positions);
  if (!std::isfinite(before)) return 1;
  assemble(parameters, positions);
  solve(parameters);
  constexpr int halvings = 14;
  double least = before, length = 1;
  for (int i = 0; i < halvings; ++i, length /= 2) {
    const double after = take(length, parameters, positions);
    if (after < least) {
      least = after;
      best_.swap(trial_);
    } else if (least < before) {
      break;  // shorter steps were better so far, this one is not
    }
  }
  if (least < before) positions.swap(best_);
  return least / before;
}

void AreaMinimiser::assemble(const AreaStepParameters& parameters, const Points& positions) {
  for (int v = 0; v < surface_.vertexCount(); ++v) {
    tangentFrame(positions.row(v).transpose(), frame_[v][0], frame_[v][1]);
    gradient_[v].setZero();
    diagonal_[v].setZero();
  }
  for (TangentBlock& block : offDiagonal_) block.setZero();
  for (int f = 0; f < surface_.faceCount(); ++f) {
    const auto p = corners(surface_.faces(), positions, f);
    const std::array<int, 3> v = {surface_.faces()(f, 0), surface_.faces()(f, 1), surface_.faces()(f, 2)};
    const FaceExpansion e =
        expandFaceEnergy(targets_[f], parameters.weights, p, {frame_[v[0]], frame_[v[1]], frame_[v[2]]});
    solidAngle_[f] = e.solidAngle;
    for (int k = 0; k < 3; ++k) {
      const int l = (k + 1) % 3, h = 3 * f + k, forward = slot_[h], backward = slot_[surface_.twin(h)];
      gradient_[v[k]] += e.gradient[k];
      diagonal_[v[k]] += e.hessian[k][k];
      offDiagonal_[forward] += e.hessian[k][l];
      offDiagonal_[backward] += e.hessian[l][k];
      // Damping: the Dirichlet energy of the displacement, cotangents of the triangle on the sphere, kept within
      // bounds.
      const Vector3 a = p[k] - p[(k + 2) % 3], b = p[l] - p[(k + 2) % 3];
      const double cotangent = 0.5 * a.dot(b) / (a.cross(b).norm() + 1e-300);
      const double c = parameters.damping * std::clamp(cotangent, 0.005, 10.0);
      TangentBlock turn;
      for (int i = 0; i < 2; ++i)
        for (int j = 0; j < 2; ++j) turn(i, j) = frame_[v[k]][i].dot(frame_[v[l]][j]);
      diagonal_[v[k]] += c * TangentBlock::Identity();
      diagonal_[v[l]] += c * TangentBlock::Identity();
      offDiagonal_[forward] -= c * turn;
      offDiagonal_[backward] -= c * turn.transpose();
    }
  }
  for (size_t v = 0; v < diagonal_.size(); ++v) {
    diagonal_[v].diagonal() *= 1 + 1e-8;
    preconditioner_[v] = diagonal_[v].inverse();
  }
}

/// image = H search; returns their dot product.
double AreaMinimiser::multiplySearch() {
  double sum = 0;
  for (size_t v = 0; v < search_.size(); ++v) {
    Tangent row = diagonal_[v] * search_[v];
    for (int i = rowStart_[v]; i < rowStart_[v + 1]; ++i) row += offDiagonal_[i] * search_[column_[i]];
    image_[v] = row;
    sum += search_[v].dot(row);
  }
  return sum;
}

void AreaMinimiser::solve(const AreaStepParameters& parameters) {
  const size_t n = step_.size();
  double rho = 0;
  for (size_t v = 0; v < n; ++v) {
    step_[v].setZero();
    residual_[v] = -gradient_[v];
    search_[v] = preconditioner_[v] * residual_[v];
    rho += residual_[v].dot(search_[v]);
  }
  const double enough = rho * parameters.conjugateGradientTolerance * parameters.conjugateGradientTolerance;
  for (int i = 0; i < parameters.conjugateGradientIterations && rho > enough; ++i) {
    const double alpha = rho / multiplySearch();
    double next = 0;
    for (size_t v = 0; v < n; ++v) {
      step_[v] += alpha * search_[v];
      // Local copies: the compiler cannot know that the vectors do not overlap.
      const Tangent r = residual_[v] - alpha * image_[v], z = preconditioner_[v] * r;
      residual_[v] = r;
      scaled_[v] = z;
      next += r.dot(z);
    }
    const double beta = next / rho;
    rho = next;
    for (size_t v = 0; v < n; ++v) search_[v] = scaled_[v] + beta * search_[v];
  }
}

/// Moves all vertices by `length` of the step into trial_, less where a face would degenerate; returns the energy
/// there.
double AreaMinimiser::take(double length, const AreaStepParameters& parameters, const Points& positions) {
  const Triangles& faces = surface_.faces();
  std::fill(share_.begin(), share_.end(), length);
  constexpr int rounds = 30, stopping = 20;  // after `stopping` rounds the vertices of a bad face stay where they are
  for (int round = 0; round < rounds; ++round) {
    for (int v = 0; v < surface_.vertexCount(); ++v) {
      Vector3 p = positions.row(v).transpose();
      if (share_[v] > 0) p = (p + share_[v] * (step_[v][0] * frame_[v][0] + step_[v][1] * frame_[v][1])).normalized();
      trial_.row(v) = p.transpose();
    }
    bool admissible = true;
    double energy = 0;
    for (int f = 0; f < surface_.faceCount(); ++f) {
      const auto p = corners(faces, trial_, f);
      const double s = solidAngle(p[0], p[1], p[2]);
      // A start beyond the limits is no reason to stand still: it must not get worse.
      bool bad = !(s > shrinkage * std::min(solidAngle_[f], targets_[f].area)) ||
                 (s < leastSolidAngle && s < solidAngle_[f]) || (s > largestSolidAngle && s > solidAngle_[f]);
      for (int k = 0; k < 3 && !bad; ++k) {
        const double cosine = p[k].dot(p[(k + 1) % 3]);
        bad = cosine < leastCosine &&
              cosine < positions.row(faces(f, k)).dot(positions.row(faces(f, (k + 1) % 3))) - 1e-12;
      }
      if (bad) {
        admissible = false;
        for (int k = 0; k < 3; ++k) share_[faces(f, k)] *= round < stopping ? 0.6 : 0;
      } else if (admissible) {
        energy += faceEnergy(targets_[f], parameters.weights, s, p);
      }
    }
    if (admissible) return energy;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace sphere_propagation
