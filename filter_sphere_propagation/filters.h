// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The filters of the plugin, in the order in which a user needs them.

#include <memory>
#include <vector>

#include "host/filter.h"

namespace sphere_propagation {

std::unique_ptr<host::Filter> makePhantomFilter();       ///< Beating ventricle phantom
std::unique_ptr<host::Filter> makeRootFilter();          ///< Spherical parameterise root
std::unique_ptr<host::Filter> makeAnchorFilter();        ///< Load anchors
std::unique_ptr<host::Filter> makePropagationFilter();   ///< Propagate parameterisation to layers
std::unique_ptr<host::Filter> makeGroupwiseFilter();     ///< Optimise parameterisations groupwise
std::unique_ptr<host::Filter> makeRemeshingFilter();     ///< Remesh by icosphere
std::unique_ptr<host::Filter> makeEvaluationFilter();    ///< Evaluate spherical parameterisation
std::unique_ptr<host::Filter> makeSphereLayersFilter();  ///< Show parameterisation as sphere layers
std::unique_ptr<host::Filter> makeColorFilter();         ///< Colour by spherical parameterisation
std::unique_ptr<host::Filter> makeMorphFilter();         ///< Morph between layers
std::unique_ptr<host::Filter> makeShapeModelFilter();    ///< Build statistical shape model
std::unique_ptr<host::Filter> makeFitFilter();           ///< Fit shape model
std::unique_ptr<host::Filter> makePreparationFilter();   ///< Prepare surface
std::unique_ptr<host::Filter> makeLayoutFilter();        ///< Lay layers side by side

/// All of them.
std::vector<std::unique_ptr<host::Filter>> makeFilters();

}  // namespace sphere_propagation
