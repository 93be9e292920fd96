// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/morphing/morph.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <sstream>
#include <thread>
#include <utility>

#include "vcg_ext/base/error.h"
#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/mesh/icosphere.h"
#include "vcg_ext/mesh/surface_geometry.h"
#include "vcg_ext/morphing/sphere_overlay.h"
#include "vcg_ext/remeshing/remeshing.h"

namespace sphere_propagation {
namespace {

constexpr double nothing = 1e-3;  // of what the smaller neighbour encloses

void requireAffordable(const MorphParameters& parameters, long vertices, size_t pairs) {
  const long all = vertices * (parameters.steps + 1L) * static_cast<long>(pairs);
  requireRange("number of vertices of the morph", static_cast<double>(all),
               Range::between(0, maxMorphVertices));
}

/// Nothing where it encloses nothing.
std::optional<MappedSurface> shapeOf(const MappedSurface& base, Points vertices) {
  try {
    return base.of(base.surface().withVertices(std::move(vertices)));
  } catch (const SurfaceError&) {
    return std::nullopt;
  }
}

}  // namespace

std::string nameOfMorph(const std::string& from, const std::string& to, double share) {
  std::ostringstream text;
  text << from << " to " << to << ' ' << std::round(1e4 * share) / 100 << " %";
  return text.str();
}

Morph makeMorph(const std::vector<MappedSurface>& surfaces, const MorphParameters& parameters,
                const Progress& progress) {
  const auto count = static_cast<int>(surfaces.size());
  if (count < 2) throw ArgumentError("A morph takes two surfaces at least.");
  requireRange("number of steps", parameters.steps, Range::between(1, 10000));
  requireRange("number of threads", parameters.threads, Range::atLeast(0));
  const bool isUnion = parameters.connectivity == MorphConnectivity::Union;
  const bool closed = parameters.closed && count > 2;
  const int pairs = closed ? count : count - 1;
  ThreadPool pool(parameters.threads);
  std::optional<MappedSurface> common;
  std::vector<Points> landmarks;
  if (!isUnion) {
    requireIcosphereFrequency(parameters.frequency);
    const long f = parameters.frequency;
    requireAffordable(parameters, 10 * f * f + 2, static_cast<size_t>(pairs));
    const Icosphere sphere = icosphere(parameters.frequency);
    common.emplace(ClosedSurface(sphere.vertices, sphere.faces, "icosphere"), sphere.vertices);
    landmarks = pool.makeEach(count, [&](int i) {
      return remesh(surfaces[static_cast<size_t>(i)], sphere.vertices).landmarks;
    });
  }

  std::vector<double> volumes;
  for (const MappedSurface& surface : surfaces)
    volumes.push_back(enclosedVolume(surface.surface().vertices(), surface.faces()));

  struct OfPair {
    std::vector<MorphShape> shapes;
    std::optional<int> crossings;
  };
  const auto caller = std::this_thread::get_id();
  std::atomic<int> finished{0};
  std::vector<OfPair> made = pool.makeEach(pairs, [&](int pair) {
    const auto from = static_cast<size_t>(pair), to = static_cast<size_t>((pair + 1) % count);
    OfPair result;
    std::vector<Points> ofThis;  // places on all surfaces; of those without weight none
    std::optional<MappedSurface> base = common;
    if (isUnion) {
      const std::optional<SphereOverlay> overlay = overlayOnSphere(surfaces[from], surfaces[to]);
      if (!overlay) return result;
      requireAffordable(parameters, overlay->first.vertexCount(), static_cast<size_t>(pairs));
      result.crossings = overlay->crossings;
      ofThis.resize(static_cast<size_t>(count));
      for (size_t i = 0; i < ofThis.size(); ++i)
        if (i == from)
          ofThis[i] = overlay->first.surface().vertices();
        else if (i == to)
          ofThis[i] = overlay->second.vertices();
        else if (parameters.path == MorphPath::ShapeModel)
          ofThis[i] = remesh(surfaces[i], overlay->first.positions()).landmarks;
      base.emplace(overlay->first);
    }
    const std::vector<Points>& points = isUnion ? ofThis : landmarks;
    const int first = parameters.ends && pair == 0 ? 0 : 1,
              last = parameters.steps + (parameters.ends ? 1 : 0);
    for (int step = first; step <= last; ++step) {
      const double share = static_cast<double>(step) / (parameters.steps + 1);
      Points vertices;
      if (step == 0 || step > parameters.steps) {
        vertices = points[step == 0 ? from : to];  // to the last bit
      } else {
        const Eigen::VectorXd weights =
            pathWeights(parameters.path, closed, count, static_cast<double>(pair) + share);
        vertices = Points::Zero(points[from].rows(), 3);
        for (size_t i = 0; i < points.size(); ++i)
          if (const double weight = weights[static_cast<Eigen::Index>(i)]; weight != 0)
            vertices += weight * points[i];
      }
      const double volume = enclosedVolume(vertices, base->faces());
      std::optional<MappedSurface> shape;
      if (volume > nothing * std::min(volumes[from], volumes[to]))
        shape = shapeOf(*base, std::move(vertices));
      result.shapes.push_back({from, to, share, std::move(shape), volume});
    }
    const double done = static_cast<double>(++finished) / pairs;
    if (std::this_thread::get_id() == caller) report(progress, done);
    return result;
  });

  Morph morph;
  for (OfPair& one : made) {
    std::move(one.shapes.begin(), one.shapes.end(), std::back_inserter(morph.shapes));
    if (isUnion) morph.crossings.push_back(one.crossings);
  }
  return morph;
}

}  // namespace sphere_propagation
