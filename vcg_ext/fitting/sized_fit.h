// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Whether a surface has another size than the fit was held to.

#include "vcg_ext/fitting/model_fit.h"

namespace sphere_propagation {

struct SizedFit {
  double advantage =
      0;             ///< logarithm of the ratio of posteriors, of its own size over the held one
  double scale = 1;  ///< that size, as a multiple of the mean's
};

/// The surface fitted once more from where `fit` brought the model, with its size sought and with
/// its size held, to a part of the landmarks and samples: for models that were built without size,
/// which cannot show another one but by shapes that are wrong. parameters: of `fit`, whose anchors
/// count.
SizedFit fitOfOwnSize(const FittingModel& model, const FittingTarget& target, const ModelFit& fit,
                      const ModelFitParameters& parameters, ThreadPool& pool);

}  // namespace sphere_propagation
