// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/sequence/sequence.h"

#include <utility>

namespace sphere_propagation {

Sequence::Sequence(const std::vector<ClosedSurface>& surfaces) {
  surfaces_.reserve(surfaces.size());
  for (const ClosedSurface& surface : surfaces) surfaces_.emplace_back(surface);
}

Sequence Sequence::with(int i, ClosedSurface surface) const {
  Sequence other = *this;
  other.surfaces_[static_cast<size_t>(i)] = PreparedSurface(std::move(surface));
  return other;
}

void Sequence::prepare(ThreadPool& pool) const {
  pool.forEach(size(), [this](int i) { (*this)[i].prepare(); });
}

}  // namespace sphere_propagation
