// SPDX-License-Identifier: GPL-3.0-only
#include "filter_sphere_propagation/filter_sphere_propagation.h"

FilterSpherePropagation::FilterSpherePropagation()
    : Plugin("FilterSpherePropagation", sphere_propagation::makeFilters()) {}

MESHLAB_PLUGIN_NAME_EXPORTER(FilterSpherePropagation)
