// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Numbers as bytes, the lowest first, on any machine.

#include <cstdint>
#include <cstring>
#include <string>

namespace sphere_propagation {

inline void appendLittleEndian(std::string& bytes, std::uint64_t value, int count) {
  for (int i = 0; i < count; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xff);
}

inline void appendLittleEndian(std::string& bytes, double value) {
  std::uint64_t bits = 0;
  static_assert(sizeof bits == sizeof value, "IEEE 754");
  std::memcpy(&bits, &value, sizeof value);
  appendLittleEndian(bytes, bits, 8);
}

}  // namespace sphere_propagation
