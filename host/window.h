// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// MeshLab's window, where there is one: PyMeshLab and meshlabserver have none.

namespace sphere_propagation::host {

/// Whether somebody looks on.
bool hasWindow();

/// Brings all visible layers into view, as Ctrl+H does, once MeshLab has taken in what a filter
/// changed.
void showEverything();

}  // namespace sphere_propagation::host
