// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// MeshLab's window, where there is one: PyMeshLab and meshlabserver have none.

class QAction;

namespace sphere_propagation::host {

/// For what makes the first layers. In an empty project MeshLab disables the entries of each menu
/// but "Create New Mesh Layer", one menu after the other (MainWindow::updateSubFiltersMenu), and
/// with "Mesh Layer" the entries that both have.
void keepEnabled(QAction& action);

/// Whether somebody looks on.
bool hasWindow();

/// Brings all visible layers into view, as Ctrl+H does, once MeshLab has taken in what a filter
/// changed.
void showEverything();

}  // namespace sphere_propagation::host
