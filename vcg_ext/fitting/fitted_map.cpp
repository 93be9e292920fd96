// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/fitting/fitted_map.h"

#include <optional>
#include <utility>

#include "vcg_ext/mesh/icosphere.h"
#include "vcg_ext/root_map/root_map.h"

namespace sphere_propagation {
namespace {

/// The mean as a surface, if it is one.
std::optional<ClosedSurface> closedMean(const FittingModel& model) {
  try {
    return ClosedSurface(model.mean(), model.faces(), "mean shape");
  } catch (const SurfaceError&) {
    return std::nullopt;
  }
}

}  // namespace

bool hasMap(const FittingModel& model) {
  return icosphereFrequency(model.mean().rows(), model.faces()) || closedMean(model);
}

PropagatedLayer mapOfFit(const FittingModel& model, const ModelFit& fit,
                         const ClosedSurface& surface, ThreadPool& pool, const Progress& progress) {
  const auto onSphere = [&]() -> Points {
    if (const auto frequency = icosphereFrequency(model.mean().rows(), model.faces()))
      return icosphere(*frequency).vertices;
    const std::optional<ClosedSurface> mean = closedMean(model);
    if (!mean)
      throw ParameterError(
          "The landmarks of the model are not a closed surface, so the surface gets no map from "
          "them.");
    RootMapParameters parameters;
    parameters.threads = pool.threads();
    return makeRootMap(*mean, parameters).map.positions();
  };
  const MappedSurface root(ClosedSurface(fit.landmarks, model.faces(), "fitted shape"), onSphere());
  const Sequence both({root.surface(), surface});
  Propagation propagated = propagate(both, root, star(2, 0), pool, {}, progress);
  return std::move(propagated.layers[1]);
}

}  // namespace sphere_propagation
