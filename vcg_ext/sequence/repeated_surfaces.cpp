// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sequence/repeated_surfaces.h"

#include <cmath>
#include <map>
#include <utility>

namespace sphere_propagation {
namespace {

constexpr double samePlace = 1e-4;  // of the radius

bool isRepetition(const PreparedSurface& surface, const PreparedSurface& of) {
  const double most = samePlace * of.radius();
  if (std::fabs(surface.radius() - of.radius()) > most) return false;
  if ((surface.centre() - of.centre()).norm() > most) return false;
  const Points &here = surface.surface().vertices(), &there = of.surface().vertices();
  const auto apart = [&](Eigen::Index v, Eigen::Index w) {
    return (here.row(v) - there.row(w)).norm() > most;
  };
  // Mostly the order is the same, and nearly always the first vertex tells surfaces apart.
  for (Eigen::Index v = 0; v < here.rows(); ++v)
    if (apart(v, v) && apart(v, of.vertexLocator().nearest(Vector3(here.row(v).transpose()))))
      return false;
  return true;
}

}  // namespace

std::vector<int> repeatedSurfaces(const Sequence& sequence) {
  std::vector<int> first(static_cast<size_t>(sequence.size()), -1);
  std::map<std::pair<Eigen::Index, Eigen::Index>, std::vector<int>> different;
  for (int i = 0; i < sequence.size(); ++i) {
    std::vector<int>& before =
        different[{sequence.surface(i).vertices().rows(), sequence.surface(i).faces().rows()}];
    for (const int other : before)
      if (isRepetition(sequence[i], sequence[other])) {
        first[static_cast<size_t>(i)] = other;
        break;
      }
    if (first[static_cast<size_t>(i)] < 0) before.push_back(i);
  }
  return first;
}

}  // namespace sphere_propagation
