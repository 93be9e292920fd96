// SPDX-License-Identifier: GPL-3.0-only
#include "host/window.h"

#include <QAction>
#include <QApplication>
#include <QTimer>
#include <QWidget>

namespace sphere_propagation::host {
namespace {

QWidget* findWindow() {
  if (qobject_cast<QApplication*>(QCoreApplication::instance()) == nullptr) return nullptr;
  for (QWidget* widget : QApplication::topLevelWidgets())
    if (widget->inherits("MainWindow") && widget->isVisible()) return widget;
  return nullptr;
}

}  // namespace

void keepEnabled(QAction& action) {
  QObject::connect(&action, &QAction::changed, &action, [&action] {
    if (!action.isEnabled()) action.setEnabled(true);
  });
}

bool hasWindow() { return findWindow() != nullptr; }

void showEverything() {
  QWidget* window = findWindow();
  if (window == nullptr) return;
  QTimer::singleShot(0, window, [window] {
    for (QAction* action : window->findChildren<QAction*>())
      if (QString(action->text()).remove('&') == "Reset Trackball" && action->isEnabled())
        return action->trigger();
  });
}

}  // namespace sphere_propagation::host
