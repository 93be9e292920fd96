// SPDX-License-Identifier: GPL-3.0-only
// Drives MeshLab's GUI from within, for the tests: preloaded into the process (LD_PRELOAD), it
// knows nothing of MeshLab and so serves every version that uses Qt 5. It reads commands, one JSON
// object per line, from the socket that GUI_AGENT_SOCKET names, and answers each with one line;
// gui.py is the other end.
//
// Commands find widgets as the user does, by what is written on them, and click with mouse events
// that go through the application's event filters. Whatever may open a dialog is done after the
// answer: a dialog runs an event loop of its own, in which the agent goes on answering.

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <QAbstractButton>
#include <QAction>
#include <QApplication>
#include <QComboBox>
#include <QDialog>
#include <QDockWidget>
#include <QFileDialog>
#include <QJsonArray>
#include <QJsonDocument>
#include <QJsonObject>
#include <QLabel>
#include <QLineEdit>
#include <QListWidget>
#include <QMenu>
#include <QMessageBox>
#include <QMouseEvent>
#include <QPixmap>
#include <QPlainTextEdit>
#include <QScreen>
#include <QSocketNotifier>
#include <QTextDocumentFragment>
#include <QTimer>
#include <QTreeWidget>
#include <algorithm>
#include <cstring>
#include <utility>

namespace {

QString plain(QString text) {
  if (Qt::mightBeRichText(text))
    return QTextDocumentFragment::fromHtml(text).toPlainText().simplified();
  return text.remove('&').simplified();
}

QString textOf(const QWidget* widget) {
  if (const auto* button = qobject_cast<const QAbstractButton*>(widget))
    return plain(button->text());
  if (const auto* label = qobject_cast<const QLabel*>(widget)) return plain(label->text());
  if (const auto* edit = qobject_cast<const QLineEdit*>(widget)) return edit->text();
  if (const auto* box = qobject_cast<const QComboBox*>(widget)) return box->currentText();
  return widget->isWindow() ? plain(widget->windowTitle()) : QString();
}

/// The window or the dock that a widget is in: a filter's dialog is a dock, which may lie in the
/// main window.
QWidget* frameOf(const QWidget* widget) {
  for (QWidget* w = const_cast<QWidget*>(widget); w != nullptr; w = w->parentWidget())
    if (w->isWindow() || qobject_cast<QDockWidget*>(w) != nullptr) return w;
  return widget->window();
}
QString titleAround(const QWidget* widget) { return plain(frameOf(widget)->windowTitle()); }

QWidgetList visibleWidgets() {
  QWidgetList found;
  for (QWidget* widget : QApplication::allWidgets())
    if (widget->isVisible()) found << widget;
  // As they lie on the screen, so that answers do not depend on addresses.
  const auto place = [](const QWidget* w) {
    const QPoint p = w->mapToGlobal(QPoint(0, 0));
    return std::make_pair(p.y(), p.x());
  };
  std::stable_sort(found.begin(), found.end(),
                   [&](const QWidget* a, const QWidget* b) { return place(a) < place(b); });
  return found;
}

QJsonObject describe(const QWidget* widget) {
  QJsonObject o{{"class", widget->metaObject()->className()},
                {"text", textOf(widget)},
                {"tooltip", plain(widget->toolTip())},
                {"enabled", widget->isEnabled()},
                {"window", titleAround(widget)}};
  const QPoint corner = widget->mapToGlobal(QPoint(0, 0));
  o["place"] = QJsonArray{corner.x(), corner.y(), widget->width(), widget->height()};
  if (const auto* label = qobject_cast<const QLabel*>(widget))
    o["clipped"] = label->wordWrap() && label->heightForWidth(label->width()) > label->height();
  if (const auto* button = qobject_cast<const QAbstractButton*>(widget))
    o["checked"] = button->isChecked();
  if (const auto* box = qobject_cast<const QComboBox*>(widget)) {
    QJsonArray items;
    for (int i = 0; i < box->count(); ++i) items << box->itemText(i);
    o["items"] = items;
  }
  return o;
}

QJsonArray menuEntries() {
  QJsonArray entries;
  for (const QWidget* widget : QApplication::allWidgets())
    if (const auto* menu = qobject_cast<const QMenu*>(widget))
      for (const QAction* action : menu->actions())
        if (!action->isSeparator())
          entries << QJsonObject{{"menu", plain(menu->title())},
                                 {"text", plain(action->text())},
                                 {"enabled", action->isEnabled()},
                                 {"tooltip", plain(action->toolTip())}};
  return entries;
}

QAction* findAction(const QString& text) {
  QAction* found = nullptr;
  for (QWidget* widget : QApplication::allWidgets())
    for (QAction* action : widget->actions())
      if (plain(action->text()) == text && (found == nullptr || !found->isEnabled()))
        found = action;
  return found;
}

QWidget* findWidget(const QJsonObject& command) {
  const QByteArray type = command["class"].toString("QWidget").toUtf8();
  const QString text = command["text"].toString(), tooltip = command["tooltip"].toString();
  int skip = command["index"].toInt(0);
  for (QWidget* widget : visibleWidgets()) {
    if (!widget->inherits(type.constData())) continue;
    if (command.contains("text") && textOf(widget) != text) continue;
    if (command.contains("tooltip") && plain(widget->toolTip()) != tooltip) continue;
    if (command.contains("window") && titleAround(widget) != command["window"].toString()) continue;
    if (skip-- == 0) return widget;
  }
  return nullptr;
}

/// The first field to the right of this label, which may go on with a remark in brackets; on its
/// height and in its window, which has this title.
QWidget* fieldOf(const QString& label, const QString& window) {
  const QWidgetList widgets = visibleWidgets();
  for (const QWidget* l : widgets) {
    const QString text = textOf(l);
    if (!l->inherits("QLabel") || (text != label && !text.startsWith(label + " (")) ||
        titleAround(l) != window)
      continue;
    const QPoint at = l->mapToGlobal(l->rect().center());
    QWidget* best = nullptr;
    for (QWidget* w : widgets) {
      if (frameOf(w) != frameOf(l)) continue;
      if (!w->inherits("QLineEdit") && !w->inherits("QComboBox") && !w->inherits("QCheckBox"))
        continue;
      const QRect place(w->mapToGlobal(QPoint(0, 0)), w->size());
      if (place.left() < at.x() || place.top() > at.y() || place.bottom() < at.y()) continue;
      if (best == nullptr || place.left() < best->mapToGlobal(QPoint(0, 0)).x()) best = w;
    }
    if (best != nullptr) return best;
  }
  return nullptr;
}

void clickAt(QWidget* widget, const QPoint& at) {
  const QPoint global = widget->mapToGlobal(at);
  for (const QEvent::Type type : {QEvent::MouseButtonPress, QEvent::MouseButtonRelease}) {
    const Qt::MouseButtons held = type == QEvent::MouseButtonPress ? Qt::LeftButton : Qt::NoButton;
    QApplication::postEvent(
        widget, new QMouseEvent(type, at, global, Qt::LeftButton, held, Qt::NoModifier));
  }
}

void click(QWidget* widget) { clickAt(widget, widget->rect().center()); }

/// The cell of a list of rows that shows this text.
bool clickCell(const QString& text) {
  for (QWidget* widget : visibleWidgets())
    if (auto* tree = qobject_cast<QTreeWidget*>(widget))
      for (int i = 0; i < tree->topLevelItemCount(); ++i)
        for (int column = 0; column < tree->columnCount(); ++column) {
          QTreeWidgetItem* item = tree->topLevelItem(i);
          if (item->text(column) != text) continue;
          tree->scrollToItem(item);
          clickAt(tree->viewport(), tree->visualRect(tree->model()->index(i, column)).center());
          return true;
        }
  return false;
}

QJsonObject set(QWidget* widget, const QJsonValue& value) {
  if (auto* edit = qobject_cast<QLineEdit*>(widget)) {
    edit->setText(value.toString());
    Q_EMIT edit->textEdited(edit->text());
    Q_EMIT edit->editingFinished();
  } else if (auto* box = qobject_cast<QComboBox*>(widget)) {
    const int index = box->findText(value.toString());
    if (index < 0) return {{"error", "no such entry"}};
    box->setCurrentIndex(index);
    Q_EMIT box->activated(index);
  } else if (auto* button = qobject_cast<QAbstractButton*>(widget)) {
    if (button->isChecked() != value.toBool()) button->click();
  } else {
    return {{"error", "cannot be set"}};
  }
  return {};
}

void collectItems(const QTreeWidgetItem* item, QJsonArray& rows) {
  QJsonArray columns;
  for (int c = 0; c < item->columnCount(); ++c) columns << item->text(c);
  rows << columns;
  for (int i = 0; i < item->childCount(); ++i) collectItems(item->child(i), rows);
}

QJsonObject lists() {
  QJsonArray lines, rows;
  for (const QWidget* widget : QApplication::allWidgets()) {
    if (const auto* list = qobject_cast<const QListWidget*>(widget))
      for (int i = 0; i < list->count(); ++i) lines << list->item(i)->text();
    if (const auto* edit = qobject_cast<const QPlainTextEdit*>(widget))
      for (const QString& line : edit->toPlainText().split('\n')) lines << line;
    if (const auto* tree = qobject_cast<const QTreeWidget*>(widget))
      for (int i = 0; i < tree->topLevelItemCount(); ++i) collectItems(tree->topLevelItem(i), rows);
  }
  return {{"lines", lines}, {"rows", rows}};
}

QJsonObject answer(const QJsonObject& command) {
  const QString what = command["do"].toString();
  if (what == "widgets") {
    QJsonArray found;
    for (const QWidget* widget : visibleWidgets()) found << describe(widget);
    return {{"widgets", found}};
  }
  if (what == "menus") return {{"entries", menuEntries()}};
  if (what == "lists") return lists();
  if (what == "picture") {
    const QJsonArray part = command["part"].toArray();  // left, top, width, height; none: all
    QScreen* screen = QApplication::primaryScreen();
    const QPixmap picture = part.isEmpty() ? screen->grabWindow(0)
                                           : screen->grabWindow(0, part[0].toInt(), part[1].toInt(),
                                                                part[2].toInt(), part[3].toInt());
    const bool saved = picture.save(command["file"].toString());
    return saved ? QJsonObject{} : QJsonObject{{"error", "the picture could not be written"}};
  }
  if (what == "fill screen") {
    for (QWidget* widget : QApplication::topLevelWidgets())
      if (widget->inherits("QMainWindow"))
        widget->setGeometry(QApplication::primaryScreen()->geometry());
    return {};
  }
  if (what == "trigger") {
    QAction* action = findAction(command["text"].toString());
    if (action == nullptr) return {{"error", "no such action"}};
    if (!action->isEnabled()) return {{"error", "the action is disabled"}};
    QTimer::singleShot(0, action, &QAction::trigger);
    return {};
  }
  if (what == "choose file") {
    for (QWidget* widget : QApplication::topLevelWidgets())
      if (auto* dialog = qobject_cast<QFileDialog*>(widget);
          dialog != nullptr && dialog->isVisible() &&
          (!command.contains("title") || dialog->windowTitle() == command["title"].toString())) {
        // Both at once: what the dialog learns of its folder in between may fill in another name.
        QTimer::singleShot(0, dialog, [dialog, file = command["file"].toString()] {
          dialog->findChild<QLineEdit*>()->setText(file);
          QMetaObject::invokeMethod(dialog, "accept");
        });
        return {};
      }
    return {{"error", "no file dialog of that title is open"}};
  }
  if (what == "click cell")
    return clickCell(command["text"].toString()) ? QJsonObject{}
                                                 : QJsonObject{{"error", "no such cell"}};
  if (what == "click" || what == "set") {
    QWidget* widget = command.contains("label")
                          ? fieldOf(command["label"].toString(), command["window"].toString())
                          : findWidget(command);
    if (widget == nullptr) return {{"error", "no such widget"}};
    if (what == "set") return set(widget, command["value"]);
    click(widget);
    return {};
  }
  return {{"error", "unknown command"}};
}

class Agent : public QObject {
 public:
  explicit Agent(const char* path) {
    listener_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path, sizeof address.sun_path - 1);
    if (bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 ||
        listen(listener_, 1) != 0)
      qFatal("GUI agent: cannot listen at %s", path);
    connect(new QSocketNotifier(listener_, QSocketNotifier::Read, this),
            &QSocketNotifier::activated, this, [this] { accept(); });
  }

 private:
  void accept() {
    const int connection = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    auto* notifier = new QSocketNotifier(connection, QSocketNotifier::Read, this);
    connect(notifier, &QSocketNotifier::activated, this, [this, notifier, connection] {
      char buffer[65536];
      const ssize_t count = read(connection, buffer, sizeof buffer);
      if (count <= 0) {
        close(connection);
        notifier->setEnabled(false);
        notifier->deleteLater();
        return;
      }
      received_ += QByteArray(buffer, static_cast<int>(count));
      for (int end = received_.indexOf('\n'); end >= 0; end = received_.indexOf('\n')) {
        const QByteArray line = received_.left(end);
        received_.remove(0, end + 1);
        QByteArray reply = QJsonDocument(answer(QJsonDocument::fromJson(line).object()))
                               .toJson(QJsonDocument::Compact);
        reply += '\n';
        for (const char* at = reply.constData(); at < reply.constData() + reply.size();) {
          const ssize_t written =
              write(connection, at, static_cast<size_t>(reply.constData() + reply.size() - at));
          if (written <= 0) break;
          at += written;
        }
      }
    });
  }

  int listener_ = -1;
  QByteArray received_;
};

void start() {
  const char* path = std::getenv("GUI_AGENT_SOCKET");
  if (path == nullptr || qobject_cast<QApplication*>(QCoreApplication::instance()) == nullptr)
    return;
  new Agent(path);  // lives as long as the process
}

}  // namespace

Q_COREAPP_STARTUP_FUNCTION(start)
