// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The texts of messages.def as constants of their names, and all of them.

#include <array>

#include "host/message.h"

namespace sphere_propagation::host::messages {

#define MESSAGE(name, kind, text) inline constexpr Message name{#name, Message::Kind::kind, text};
#include "host/messages.def"
#undef MESSAGE

inline constexpr std::array all{
#define MESSAGE(name, kind, text) name,
#include "host/messages.def"
#undef MESSAGE
};

}  // namespace sphere_propagation::host::messages
