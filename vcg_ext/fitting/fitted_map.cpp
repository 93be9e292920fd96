// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/fitting/fitted_map.h"

#include <utility>

#include "vcg_ext/mesh/icosphere.h"

namespace sphere_propagation {

bool hasMap(const FittingModel& model) {
  return icosphereFrequency(model.mean().rows(), model.faces()).has_value();
}

PropagatedLayer mapOfFit(const FittingModel& model, const ModelFit& fit,
                         const ClosedSurface& surface, int threads, const Progress& progress) {
  const std::optional<int> frequency = icosphereFrequency(model.mean().rows(), model.faces());
  if (!frequency)
    throw ParameterError(
        "The landmarks of the model are no whole icosphere, so the surface gets no map from them.");
  const MappedSurface root(ClosedSurface(fit.landmarks, model.faces(), "fitted shape"),
                           icosphere(*frequency).vertices);
  const Sequence both({root.surface(), surface});
  PropagationParameters parameters;
  parameters.threads = threads;
  Propagation propagated = propagate(both, root, star(2, 0), parameters, progress);
  return std::move(propagated.layers[1]);
}

}  // namespace sphere_propagation
