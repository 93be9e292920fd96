// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Numbers that fall off like exp(-r^2) have products below 1e-38, which single precision can only
/// hold as denormal numbers: some processors take a hundred times as long for these.

namespace sphere_propagation {

/// An expression: a matrix of floats, those below 2^-63 as zeros, so that no product of two others
/// is denormal.
template <class Floats>
auto withoutTiny(const Floats& numbers) {
  constexpr float tiny = 1.0F / (1LL << 62) / 2;
  return numbers.unaryExpr([](float x) { return x < tiny && x > -tiny ? 0.0F : x; });
}

}  // namespace sphere_propagation
