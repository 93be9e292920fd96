// SPDX-License-Identifier: GPL-3.0-only
// Landmarks are points of their surface, and two surfaces hardly share a thousand points: the test
// fails on the first few landmarks wherever it fails.

#include "filter_sphere_propagation/landmark_sources.h"

#include <algorithm>
#include <map>
#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/mesh/surface_locator.h"

namespace sphere_propagation {
namespace {

/// Files of floats round by 1e-7 of the largest coordinate, files of text by less than this.
constexpr double rounding = 1e-5;

std::optional<MeshSurface> surfaceIfSound(const host::Layer& layer) {
  try {
    return layer.surface();
  } catch (const Error&) {
    return std::nullopt;
  }
}

bool liesOn(const Points& landmarks, const SurfaceLocator& surface, double tolerance) {
  const Eigen::Index count = landmarks.rows(),
                     stride = 7;  // neighbours have neighbouring numbers: begin all over
  for (Eigen::Index start = 0; start < std::min(stride, count); ++start)
    for (Eigen::Index j = start; j < count; j += stride)
      if (!(surface.closest(landmarks.row(j).transpose()).distance <= tolerance)) return false;
  return true;
}

}  // namespace

std::vector<std::optional<size_t>> landmarkSources(const std::vector<host::Layer>& landmarks,
                                                   const std::vector<host::Layer>& surfaces) {
  std::vector<std::optional<size_t>> sources(landmarks.size());
  std::vector<bool> taken(surfaces.size(), false);
  const auto assign = [&](size_t layer, size_t surface) {
    sources[layer] = surface;
    taken[surface] = true;
  };
  for (size_t i = 0; i < landmarks.size(); ++i)
    for (size_t k = 0; k < surfaces.size() && !sources[i]; ++k)
      if (!taken[k] && landmarks[i].plainLabel() == surfaces[k].derivedLabel("landmarks"))
        assign(i, k);

  std::vector<std::pair<size_t, Points>> nameless;
  for (size_t i = 0; i < landmarks.size(); ++i)
    if (!sources[i])
      if (Points points = landmarks[i].content().vertices; points.allFinite())
        nameless.emplace_back(i, std::move(points));
  if (nameless.empty()) return sources;
  std::map<size_t, size_t> again;  // layers on a surface that another one came from
  for (size_t k = 0; k < surfaces.size(); ++k) {
    const auto mesh = surfaceIfSound(surfaces[k]);
    if (!mesh) continue;
    const SurfaceLocator locator(mesh->surface.vertices(), mesh->surface.faces());
    const double tolerance = rounding * mesh->surface.vertices().cwiseAbs().maxCoeff();
    for (const auto& [i, points] : nameless) {
      if (sources[i] || !liesOn(points, locator, tolerance)) continue;
      if (taken[k])
        again.emplace(i, k);
      else
        assign(i, k);
    }
  }
  for (const auto& [i, k] : again)
    if (!sources[i]) sources[i] = k;
  return sources;
}

}  // namespace sphere_propagation
