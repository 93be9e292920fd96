// SPDX-License-Identifier: GPL-3.0-only
#include "host/input_guard.h"

#include <QApplication>
#include <QEvent>
#include <QThread>

namespace sphere_propagation::host {

InputGuard::InputGuard() {
  auto* application = qobject_cast<QApplication*>(QCoreApplication::instance());
  if (application != nullptr && application->thread() == QThread::currentThread())
    application->installEventFilter(this);  // a filter that is destroyed is removed
}

bool InputGuard::eventFilter(QObject*, QEvent* event) {
  switch (event->type()) {
    case QEvent::MouseButtonPress:
    case QEvent::MouseButtonRelease:
    case QEvent::MouseButtonDblClick:
    case QEvent::KeyPress:
    case QEvent::KeyRelease:
    case QEvent::ShortcutOverride:
    case QEvent::Shortcut:
    case QEvent::Wheel:
    case QEvent::ContextMenu:
    case QEvent::TabletPress:
    case QEvent::TouchBegin:
    case QEvent::DragEnter:
    case QEvent::Drop:
      return true;
    case QEvent::Close:
      event->ignore();
      return true;
    default:
      return false;
  }
}

}  // namespace sphere_propagation::host
