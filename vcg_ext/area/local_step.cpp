// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/area/local_step.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "vcg_ext/sphere/admissible.h"
#include "vcg_ext/sphere/spherical_triangle.h"

namespace sphere_propagation {
namespace {

double energyAt(const VertexStar& star, const AreaEnergyWeights& weights, const Vector3& x) {
  double energy = 0;
  for (size_t i = 0; i < star.rim.size(); ++i) {
    const std::array<Vector3, 3> p{x, star.rim[i], star.rim[i + 1 == star.rim.size() ? 0 : i + 1]};
    const double s = solidAngle(p[0], p[1], p[2]);
    if (!(s > Admissible::minSolidAngle && s <= Admissible::maxSolidAngle) ||
        p[0].dot(p[1]) < Admissible::minCosine)
      return std::numeric_limits<double>::infinity();
    energy += faceEnergy(star.targets[i], weights, s, p);
  }
  return energy;
}

}  // namespace

double relaxVertex(const VertexStar& star, const AreaEnergyWeights& weights, int iterations,
                   Vector3& x) {
  const Vector3 start = x;
  double energy = energyAt(star, weights, x);
  if (!std::isfinite(energy)) return 0;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    std::array<std::array<Vector3, 2>, 3> frame;
    for (auto& f : frame) tangentFrame(x, f[0], f[1]);  // only the first is used
    Tangent gradient = Tangent::Zero();
    TangentBlock hessian = TangentBlock::Zero();
    for (size_t i = 0; i < star.rim.size(); ++i) {
      const FaceExpansion e =
          expandFaceEnergy(star.targets[i], weights,
                           {x, star.rim[i], star.rim[i + 1 == star.rim.size() ? 0 : i + 1]}, frame);
      gradient += e.gradient(0);
      hessian += e.hessian(0, 0, frame);
    }
    const double trace = hessian.trace();
    hessian.diagonal().array() += 1e-9 * trace + 1e-300;
    const double determinant = hessian(0, 0) * hessian(1, 1) - hessian(0, 1) * hessian(1, 0);
    Tangent step = -gradient / trace;
    if (determinant > 1e-14 * trace * trace)
      step = -Tangent(hessian(1, 1) * gradient[0] - hessian(0, 1) * gradient[1],
                      hessian(0, 0) * gradient[1] - hessian(1, 0) * gradient[0]) /
             determinant;
    const double length = step.norm();
    constexpr double longest = 0.5;
    if (!std::isfinite(length)) break;
    double share = std::min(1.0, longest / length);
    bool lower = false;
    for (int i = 0; i < 12 && !lower; ++i, share *= 0.4) {
      const Vector3 y = (x + share * (step[0] * frame[0][0] + step[1] * frame[0][1])).normalized();
      const double there = energyAt(star, weights, y);
      if (there < energy) {
        lower = true;
        x = y;
        energy = there;
      }
    }
    if (!lower || length < 1e-10) break;
  }
  return (x - start).norm();
}

}  // namespace sphere_propagation
