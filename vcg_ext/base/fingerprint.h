// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A number that stands for a content: the same on every machine and in every run, and hardly ever
/// the same for two contents.

#include <cstdint>
#include <cstring>
#include <string>

namespace sphere_propagation {

/// Collects what belongs to a content, in order. The mixing step is the finaliser of SplitMix64 (G.
/// L. Steele, D. Lea and C. H. Flood, Fast splittable pseudorandom number generators, OOPSLA 2014).
class Fingerprint {
 public:
  void add(std::uint64_t word) {
    state_ += word + 0x9e3779b97f4a7c15ULL;
    state_ = (state_ ^ (state_ >> 30)) * 0xbf58476d1ce4e5b9ULL;
    state_ = (state_ ^ (state_ >> 27)) * 0x94d049bb133111ebULL;
    state_ ^= state_ >> 31;
  }
  void add(int number) { add(static_cast<std::uint64_t>(number)); }
  void add(double number) {
    number += 0.0;  // -0 is 0
    std::uint64_t bits = 0;
    std::memcpy(&bits, &number, sizeof bits);
    add(bits);
  }
  void add(const std::string& text) {
    for (const char c : text) add(static_cast<std::uint64_t>(static_cast<unsigned char>(c)));
    add(static_cast<std::uint64_t>(text.size()));
  }

  /// 1 to 2^24 - 1, which a float holds exactly: two contents share it in one case of 16 million.
  int short24() const {
    const int top = static_cast<int>(state_ >> 40);
    return top != 0 ? top : 1;
  }

 private:
  std::uint64_t state_ = 0;
};

}  // namespace sphere_propagation
