// SPDX-License-Identifier: GPL-3.0-only
#include "filter_sphere_propagation/filters.h"

namespace sphere_propagation {

std::vector<std::unique_ptr<host::Filter>> makeFilters() {
  std::vector<std::unique_ptr<host::Filter>> filters;
  filters.push_back(makePhantomFilter());
  filters.push_back(makePreparationFilter());
  filters.push_back(makeRootFilter());
  filters.push_back(makeAnchorFilter());
  filters.push_back(makePropagationFilter());
  filters.push_back(makeGroupwiseFilter());
  filters.push_back(makeRemeshingFilter());
  filters.push_back(makeEvaluationFilter());
  filters.push_back(makeSphereLayersFilter());
  filters.push_back(makeColorFilter());
  filters.push_back(makeMorphFilter());
  filters.push_back(makeShapeModelFilter());
  filters.push_back(makeFitFilter());
  filters.push_back(makeLayoutFilter());
  return filters;
}

}  // namespace sphere_propagation
