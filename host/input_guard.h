// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Keeps the user's hands off the GUI while a filter runs. MeshLab's progress callback runs the
/// event loop, so that a click could start the filter again, or close the layers that it works on.

#include <QObject>

namespace sphere_propagation::host {

/// As long as it lives, the application gets no mouse, keyboard or close events; it still draws
/// itself. Does nothing where there is no GUI.
class InputGuard : public QObject {
 public:
  InputGuard();
  bool eventFilter(QObject* receiver, QEvent* event) override;
};

}  // namespace sphere_propagation::host
