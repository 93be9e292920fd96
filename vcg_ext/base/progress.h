// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// How a long computation tells how far it is.

#include <functional>
#include <utility>

namespace sphere_propagation {

/// Called now and then, from the thread that called the algorithm, with the share done (0 to 1,
/// never decreasing). Empty: nobody listens.
using Progress = std::function<void(double fraction)>;

/// The part [from, to] of `whole`, as the progress of one step of it.
inline Progress part(const Progress& whole, double from, double to) {
  if (!whole) return {};
  return [whole, from, to](double fraction) { whole(from + fraction * (to - from)); };
}

/// Reports to `progress` if anybody listens.
inline void report(const Progress& progress, double fraction) {
  if (progress) progress(fraction);
}

}  // namespace sphere_propagation
