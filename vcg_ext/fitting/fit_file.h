// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// A fitted shape with all that is known of how certain it is, as a file.

#include <string>

#include "vcg_ext/fitting/model_fit.h"

namespace sphere_propagation {

/// Whether the file can be written: .npz, in a folder that exists, no folder itself. Throws
/// ExportError.
void requireFitFile(const std::string& path);

/// NumPy's .npz: landmarks N x 3, sd N, covariance N x 3 x 3, scores M, score_sd M, pose 4 x 4
/// (from the model's frame to the surface's), noise, surface_distance, faces F x 3. path: UTF-8.
/// What is there already is replaced only when the new file is complete. Throws ExportError.
void exportFit(const std::string& path, const FittingModel& model, const ModelFit& fit);

}  // namespace sphere_propagation
