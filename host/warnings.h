// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// What deserves a look, for scripts. They get no log, and of values numbers alone: so the warnings
/// of a run are one more key of what a filter returns, as the bytes of a text.

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "host/message.h"

namespace sphere_propagation::host {

/// The key; absent where there is nothing to say.
constexpr const char* warningsKey = "warnings";

/// Of remarks the warnings and the notes, in their order, as JSON in UTF-8, one byte a number:
///   [{"kind": "Warning", "message": "anotherPose", "layer": "phase 3", "layers": ["phase 3"],
///     "subject": "phase 3", "text": "it lies in ..."}]
/// kind: Warning or Note; message: its name in the catalogue; layers: the names of all that it is
/// about, none where that is the result as a whole; layer: the name where it is one, else empty;
/// subject: how the log calls them before the text, empty where the text names them itself. Nothing
/// where there are none.
std::optional<Eigen::VectorXd> encodedWarnings(const std::vector<Remark>& remarks);

}  // namespace sphere_propagation::host
