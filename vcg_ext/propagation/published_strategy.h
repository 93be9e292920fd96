// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Method As published: the steps of the paper, from surface to surface.

#include "vcg_ext/propagation/published/published_propagation.h"
#include "vcg_ext/propagation/strategy.h"

namespace sphere_propagation {

class PublishedStrategy : public PropagationStrategy {
 public:
  explicit PublishedStrategy(const PublishedParameters& parameters) : parameters_(parameters) {}
  Propagation propagate(const PropagationTask& task, const Progress& progress) const override;

 private:
  PublishedParameters parameters_;
};

}  // namespace sphere_propagation
