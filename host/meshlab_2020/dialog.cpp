// SPDX-License-Identifier: GPL-3.0-only
// MeshLab's stdpardialog and richparameterlistframe, seen from outside: a floating dock with a
// frame, in which parameter i fills row i of a grid (label, field or a line of widgets, help).

#include "host/meshlab_2020/dialog.h"

#include <QApplication>
#include <QDockWidget>
#include <QGridLayout>
#include <QLineEdit>
#include <QPushButton>
#include <QScreen>
#include <QTimer>
#include <algorithm>
#include <utility>

namespace sphere_propagation::host {
namespace {

QDockWidget* findDialog(const QString& title) {
  for (QWidget* widget : QApplication::allWidgets())
    if (widget->inherits("MeshlabStdDialog") && widget->isVisible() &&
        widget->windowTitle() == title)
      return qobject_cast<QDockWidget*>(widget);
  return nullptr;
}

template <class Visit>
void eachWidget(QLayoutItem* item, const Visit& visit) {
  if (item == nullptr) return;
  if (QWidget* widget = item->widget()) visit(widget);
  if (QLayout* layout = item->layout())
    for (int i = 0; i < layout->count(); ++i) eachWidget(layout->itemAt(i), visit);
}

/// Label and field of a row; its help as well where it is to be hidden, which the Help button
/// shows.
void showRow(const QGridLayout& grid, int row, bool shown) {
  for (int column = 0; column < (shown ? 2 : grid.columnCount()); ++column)
    eachWidget(grid.itemAtPosition(row, column),
               [shown](QWidget* widget) { widget->setVisible(shown); });
}

QPushButton* findButton(const QWidget& dialog, const QString& text) {
  for (QPushButton* button : dialog.findChildren<QPushButton*>())
    if (button->text() == text) return button;
  return nullptr;
}

/// As large as what it shows, and on the screen.
void fit(QDockWidget& dialog, QWidget& frame) {
  frame.setMinimumSize(0, 0);
  frame.layout()->activate();
  frame.setMinimumSize(frame.layout()->sizeHint());
  QWidget& content = *dialog.widget();
  content.setMinimumSize(0, 0);
  content.layout()->invalidate();
  content.layout()->activate();
  content.adjustSize();
  // The help is wrapped: its height follows from the width, which a size hint guesses.
  const QSize hint = content.sizeHint();
  const int height = content.layout()->totalHeightForWidth(hint.width());
  content.setMinimumSize(hint.width(), std::max(hint.height(), height));
  dialog.setMinimumSize(content.minimumSize());  // and its title above that
  dialog.adjustSize();
  const QScreen* screen = QApplication::primaryScreen();
  if (!dialog.isFloating() || screen == nullptr) return;
  const QRect room = screen->availableGeometry(), outside = dialog.frameGeometry();
  const int x = std::min(outside.left(), room.right() - outside.width()),
            y = std::min(outside.top(), room.bottom() - outside.height());
  dialog.move(std::max(x, room.left()), std::max(y, room.top()));
}

}  // namespace

void Dialog::expect(const QString& title, std::vector<Row> rows) {
  if (qobject_cast<QApplication*>(QCoreApplication::instance()) == nullptr) return;
  QTimer::singleShot(0, &context_, [this, title, rows = std::move(rows)] { arrange(title, rows); });
}

void Dialog::arrange(const QString& title, const std::vector<Row>& rows) {
  QDockWidget* dialog = findDialog(title);
  if (dialog == nullptr || dialog->widget() == nullptr || dialog->widget()->layout() == nullptr)
    return;
  QWidget* frame = nullptr;
  for (QWidget* widget : dialog->findChildren<QWidget*>())
    if (widget->inherits("RichParameterListFrame")) frame = widget;
  auto* grid = frame != nullptr ? qobject_cast<QGridLayout*>(frame->layout()) : nullptr;
  constexpr const char* arranged = "sphere_propagation_arranged";
  if (grid == nullptr || frame->property(arranged).toBool()) return;
  if (grid->rowCount() != static_cast<int>(rows.size())) return;
  frame->setProperty(arranged, true);

  std::vector<int> advanced;
  std::map<QString, QLineEdit*> files;
  for (int row = 0; row < grid->rowCount(); ++row) {
    const Row& parameter = rows[static_cast<size_t>(row)];
    if (parameter.advanced) advanced.push_back(row);
    if (parameter.file)
      eachWidget(grid->itemAtPosition(row, 1), [&](QWidget* widget) {
        if (auto* edit = qobject_cast<QLineEdit*>(widget)) files[parameter.parameter] = edit;
      });
  }

  if (!advanced.empty()) {
    auto* fold = new QPushButton("Advanced parameters", frame);
    fold->setFlat(true);
    fold->setCheckable(true);
    grid->addWidget(fold, grid->rowCount(), 0, 1, 2);
    fold->show();  // what is not shown takes no room
    const auto show = [dialog, frame, grid, advanced](bool shown) {
      for (const int row : advanced) showRow(*grid, row, shown);
      fit(*dialog, *frame);
    };
    QObject::connect(fold, &QPushButton::toggled, frame, show);
    if (QPushButton* help = findButton(*dialog, "Help"))  // shows the help of all, fold or not
      QObject::connect(help, &QPushButton::clicked, frame, [fold, show] {
        if (!fold->isChecked()) show(false);
      });
    show(false);
  } else {
    fit(*dialog, *frame);
  }

  if (QPushButton* apply = findButton(*dialog, "Apply"); apply != nullptr && !files.empty()) {
    // MeshLab runs the filter within "clicked", to which it was connected before we are.
    QObject::connect(apply, &QPushButton::pressed, &context_, [this, title, files] {
      applied_ = title;
      paths_.clear();
      for (const auto& [name, edit] : files) paths_[name] = edit->text();
    });
    QObject::connect(apply, &QPushButton::clicked, &context_, [this] { applied_.clear(); });
  }
}

std::map<QString, QString> Dialog::pathsAtApply(const QString& title) const {
  if (applied_ != title) return {};
  return paths_;
}

}  // namespace sphere_propagation::host
