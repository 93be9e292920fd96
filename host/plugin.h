// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A MeshLab plugin made of host::Filter objects. A plugin derives from host::Plugin, passes its
/// filters, and adds Qt's declarations; the rest is the same for every host:
///   class MyPlugin : public host::Plugin {
///     Q_OBJECT
///     MESHLAB_PLUGIN_IID_EXPORTER(HOST_PLUGIN_IID)
///     Q_INTERFACES(HOST_PLUGIN_INTERFACE)
///    public:
///     MyPlugin() : Plugin("MyPlugin", makeMyFilters()) {}
///   };
///   MESHLAB_PLUGIN_NAME_EXPORTER(MyPlugin)
///
/// Whatever differs between the hosts' interfaces is in the folders meshlab_2025/ and
/// meshlab_2020/.

#ifdef HOST_IS_MESHLAB_2020
#include "host/meshlab_2020/plugin.h"
#else
#include "host/meshlab_2025/plugin.h"
#endif
