// SPDX-License-Identifier: GPL-3.0-only
#include "host/warnings.h"

#include <QJsonArray>
#include <QJsonDocument>
#include <QJsonObject>

namespace sphere_propagation::host {
namespace {

/// Empty: no matter for scripts.
QString kindOf(const Remark& remark) {
  switch (remark.kind) {
    case Message::Kind::Warning:
    case Message::Kind::LayerWarning:
      return "Warning";
    case Message::Kind::Note:
      return "Note";
    default:
      return {};
  }
}

}  // namespace

std::optional<Eigen::VectorXd> encodedWarnings(const std::vector<Remark>& remarks) {
  QJsonArray list;
  for (const Remark& remark : remarks)
    if (const QString kind = kindOf(remark); !kind.isEmpty()) {
      QJsonArray layers;
      for (const std::string& layer : remark.layers) layers.append(QString::fromStdString(layer));
      const QJsonValue only = layers.size() == 1 ? layers.first() : QJsonValue(QString());
      list.append(QJsonObject{{"kind", kind},
                              {"message", QString::fromStdString(remark.name)},
                              {"layer", only},
                              {"layers", layers},
                              {"subject", QString::fromStdString(remark.subject)},
                              {"text", QString::fromStdString(remark.text)}});
    }
  if (list.isEmpty()) return std::nullopt;
  const QByteArray text = QJsonDocument(list).toJson(QJsonDocument::Compact);
  Eigen::VectorXd bytes(text.size());
  for (int i = 0; i < text.size(); ++i) bytes[i] = static_cast<unsigned char>(text[i]);
  return bytes;
}

}  // namespace sphere_propagation::host
