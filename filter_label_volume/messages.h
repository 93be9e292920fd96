// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The texts of messages.def as constants of their names, all of them, and how a file is refused.

#include <array>

#include "host/message.h"
#include "vcg_ext/base/error.h"

namespace sphere_propagation {
namespace volume_messages {

#define MESSAGE(name, kind, text) \
  inline constexpr host::Message name{#name, host::Message::Kind::kind, text};
#include "filter_label_volume/messages.def"
#undef MESSAGE

inline constexpr std::array all{
#define MESSAGE(name, kind, text) name,
#include "filter_label_volume/messages.def"
#undef MESSAGE
};

}  // namespace volume_messages

/// Throws VolumeError with what a message says of a file.
template <class... Values>
[[noreturn]] void refuse(const host::Message& message, const Values&... values) {
  throw VolumeError(host::said(message, values...));
}

}  // namespace sphere_propagation
