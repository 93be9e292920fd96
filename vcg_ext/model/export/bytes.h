// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The bytes of a file, from numbers with the lowest byte first, on any machine.

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

namespace sphere_propagation {

/// A string that numbers are appended to.
class Bytes {
 public:
  /// The lowest `count` bytes of a whole number.
  Bytes& put(std::uint64_t value, int count) {
    for (int i = 0; i < count; ++i) bytes_ += static_cast<char>(value >> (8 * i) & 0xff);
    return *this;
  }
  /// IEEE 754, 8 bytes.
  Bytes& put(double value) {
    std::uint64_t bits = 0;
    static_assert(sizeof bits == sizeof value, "IEEE 754");
    std::memcpy(&bits, &value, sizeof value);
    return put(bits, 8);
  }
  Bytes& put(const std::string& text) {
    bytes_ += text;
    return *this;
  }
  /// Zeros up to a length, or to the next multiple of 8.
  Bytes& fill(size_t length) {
    bytes_.resize(std::max(length, bytes_.size()), '\0');
    return *this;
  }
  Bytes& align() { return fill((bytes_.size() + 7) / 8 * 8); }

  void reserve(size_t length) { bytes_.reserve(length); }
  size_t size() const { return bytes_.size(); }
  const std::string& str() const& { return bytes_; }
  std::string str() && { return std::move(bytes_); }

 private:
  std::string bytes_;
};

}  // namespace sphere_propagation
