// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// What the dialogs of MeshLab 2020.09 lack. A dialog of that version knows no advanced parameters,
/// and takes a path from the file chooser only: one that is typed into the field is shown and not
/// read. The plugin is in the same process, so it finds the dialog among Qt's widgets once that
/// stands, by the names of their classes. Where none is found, as in meshlabserver, which has no
/// window, nothing is done, and MeshLab does what it always does.

#include <QObject>
#include <QString>
#include <map>
#include <vector>

class QDockWidget;
class QWidget;

namespace sphere_propagation::host {

class Dialog {
 public:
  /// One line of the dialog, in the order of MeshLab's list of parameters.
  struct Row {
    QString parameter;
    bool advanced = false;
    bool file = false;
  };

  /// To be called when MeshLab asks for a filter's parameters, which it does just before it makes
  /// the dialog. title: the filter's name. Advanced parameters are then folded away, and the dialog
  /// is brought onto the screen.
  void expect(const QString& title, std::vector<Row> rows);

  /// The paths that stood in the dialog's fields when Apply was pressed, by parameter. Empty where
  /// the filter is run from somewhere else.
  std::map<QString, QString> pathsAtApply(const QString& title) const;

 private:
  void arrange(const QString& title, const std::vector<Row>& rows);

  QObject context_;  // what was connected ends with it
  QString applied_;  // the dialog whose Apply is pressed
  std::map<QString, QString> paths_;
};

}  // namespace sphere_propagation::host
