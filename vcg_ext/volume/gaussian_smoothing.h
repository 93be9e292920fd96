// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Smoothing of scalar images.

#include "vcg_ext/volume/grid.h"

namespace sphere_propagation {

/// Convolves the grid with a Gaussian, axis by axis. The kernel is sampled, cut off at `truncate`
/// standard deviations (rounded to whole samples) and sums to one; beyond its border the grid is
/// mirrored (... c b a | a b c ...). These are the conventions of scipy.ndimage.gaussian_filter,
/// mode "reflect".
///
/// standardDeviation: in samples, >= 0 (0 does nothing); truncate: > 0, default 4; their product at
/// most 10000. Throws ParameterError when they are outside these ranges.
void smoothGaussian(ScalarGrid& grid, double standardDeviation, double truncate = 4);

}  // namespace sphere_propagation
