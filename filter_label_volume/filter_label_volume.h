// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The plugin that reads label volumes: MeshLab's face of vcg_ext/volume and of ITK's readers.

#include "host/plugin.h"

class FilterLabelVolume : public sphere_propagation::host::Plugin {
  Q_OBJECT
  MESHLAB_PLUGIN_IID_EXPORTER(HOST_PLUGIN_IID)
  Q_INTERFACES(HOST_PLUGIN_INTERFACE)

 public:
  FilterLabelVolume();
};
