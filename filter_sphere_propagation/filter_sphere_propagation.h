// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The plugin: MeshLab's face of vcg_ext. One file per filter; see filters.h.

#include "filter_sphere_propagation/filters.h"
#include "host/plugin.h"

class FilterSpherePropagation : public sphere_propagation::host::Plugin {
  Q_OBJECT
  MESHLAB_PLUGIN_IID_EXPORTER(HOST_PLUGIN_IID)
  Q_INTERFACES(HOST_PLUGIN_INTERFACE)

 public:
  FilterSpherePropagation();
};
