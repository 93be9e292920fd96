// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Which surface each landmark layer was made of, also when both were saved, loaded and called
/// otherwise since then.

#include <optional>
#include <vector>

#include "host/layers.h"

namespace sphere_propagation {

/// For each landmark layer the number of its surface in `surfaces`; nothing where there is none.
/// Told by the name that "Remesh by icosphere" gives, whatever file endings follow; else by
/// geometry: all landmarks lie on the surface, but for the rounding of files. Of several surfaces
/// that fit, the first that no other layer came from.
///
/// Damaged surfaces are known by their names alone.
std::vector<std::optional<size_t>> landmarkSources(const std::vector<host::Layer>& landmarks,
                                                   const std::vector<host::Layer>& surfaces);

}  // namespace sphere_propagation
