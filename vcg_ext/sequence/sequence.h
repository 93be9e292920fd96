// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The surfaces that get corresponding maps, each prepared once for all steps.

#include <vector>

#include "vcg_ext/base/thread_pool.h"
#include "vcg_ext/mesh/closed_surface.h"
#include "vcg_ext/registration/prepared_surface.h"

namespace sphere_propagation {

/// Surfaces by number, from 0: in time order where time matters. What one step computes of a
/// surface (normals, axes, closest-point trees) is there for the next.
/// Immutable, and cheap to copy: copies share what they hold.
class Sequence {
 public:
  Sequence(const std::vector<ClosedSurface>& surfaces);  // a list of surfaces is one

  int size() const { return static_cast<int>(surfaces_.size()); }
  const PreparedSurface& operator[](int i) const { return surfaces_[static_cast<size_t>(i)]; }
  const ClosedSurface& surface(int i) const { return (*this)[i].surface(); }
  const std::string& name(int i) const { return surface(i).name(); }

  /// The same sequence with another surface in place i.
  Sequence with(int i, ClosedSurface surface) const;

  /// Prepares all surfaces, several at once.
  void prepare(ThreadPool& pool) const;

 private:
  std::vector<PreparedSurface> surfaces_;
};

}  // namespace sphere_propagation
