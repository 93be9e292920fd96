// SPDX-License-Identifier: GPL-3.0-only
#include "filter_sphere_propagation/filter_sphere_propagation.h"

#include "filter_sphere_propagation/messages.h"

FilterSpherePropagation::FilterSpherePropagation()
    : Plugin("FilterSpherePropagation", sphere_propagation::makeFilters(),
             {sphere_propagation::messages::all.begin(), sphere_propagation::messages::all.end()}) {
}

MESHLAB_PLUGIN_NAME_EXPORTER(FilterSpherePropagation)

#include "moc_filter_sphere_propagation.cpp"  // Qt's part of the class
