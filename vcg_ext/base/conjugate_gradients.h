// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Linear systems that are known by what they make of a vector only, and nearly solved by another.

#include <utility>

namespace sphere_propagation {

struct ConjugateGradientParameters {
  /// Of the residual, relative to the right side, in the norm of the preconditioner; squared.
  double squaredTolerance = 1e-6;
  int maxSteps = 100;
};

/// Solves A x = right for a symmetric positive definite A by preconditioned conjugate gradients
/// (Hestenes and Stiefel 1952), from the x that is given; returns how many steps that took.
/// times(x) is A x, precondition(r) near A^-1 r, symmetric positive definite; both may return an
/// expression of Eigen's. Of matrices all entries together are the vector.
template <class Vector, class Times, class Precondition>
int solveByConjugateGradients(const Times& times, const Precondition& precondition,
                              const Vector& right, Vector& x,
                              const ConjugateGradientParameters& parameters) {
  const auto dot = [](const Vector& a, const Vector& b) { return a.cwiseProduct(b).sum(); };
  Vector rest = right - times(x), step = precondition(rest), along = step;
  auto left = dot(rest, step);
  const auto enough = parameters.squaredTolerance * dot(right, precondition(right));
  int steps = 0;
  for (; steps < parameters.maxSteps && left > enough; ++steps) {
    const Vector image = times(along);
    const auto length = left / dot(along, image);
    x += length * along;
    rest -= length * image;
    step = precondition(rest);
    const auto before = std::exchange(left, dot(rest, step));
    along = step + left / before * along;
  }
  return steps;
}

}  // namespace sphere_propagation
