// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Shape models that were written to a file, read again.

#include <string>

#include "vcg_ext/model/shape_model.h"

namespace sphere_propagation {

/// A model as model_export.h writes it to NumPy's .npz, and as numpy.savez does: an archive of
/// arrays that is not compressed, with mean (#N by 3), modes (#M by #N by 3), eigenvalues (#M),
/// faces (#F by 3), of any kind of number, row by row; and where they are there scores (#K by #M),
/// lid (one for each landmark that there was), noise_variance (one number), and anchor_names
/// (texts) with anchor_landmarks (as many numbers), the landmarks that have names. Names of shapes
/// are not in it; totalVariance is the sum of its eigenvalues.
///
/// Throws ParameterError, which names the file and what is wrong with it.
ShapeModel readModel(const std::string& file);

}  // namespace sphere_propagation
