// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// What the last line of a filter's log tells: what there is now, what was left out because it is
/// hidden, and which filter comes next.

#include <string>
#include <vector>

#include "host/filter.h"

namespace sphere_propagation {

/// Of the layers of these kinds those that are hidden, as a part of a sentence: "; hidden, left
/// out: "endo_09"". Empty where there are none.
std::string hiddenLeftOut(const host::Layers& layers, const std::vector<host::LayerKind>& kinds);
inline std::string hiddenLeftOut(const host::Layers& layers, host::LayerKind kind) {
  return hiddenLeftOut(layers, std::vector<host::LayerKind>{kind});
}

/// "Next: Remesh by icosphere.": what comes next where this many of the visible surfaces have a
/// map.
std::string nextFilter(const host::Layers& layers, size_t mapped);

/// What layers of this kind are to be shown beside when a filter makes them: everything that is
/// visible, but for layers of this kind, whose place the new ones take, and of the model, which
/// stands last.
Eigen::AlignedBox3d shownBeside(const host::Layers& layers, host::LayerKind kind);

}  // namespace sphere_propagation
