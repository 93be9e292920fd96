// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Shape models that were written to a file, read again.

#include <string>

#include "vcg_ext/model/shape_model.h"

namespace sphere_propagation {

/// A model as model_export.h writes it to NumPy's .npz, and as numpy.savez does: an archive of
/// arrays that is not compressed, with mean (#N by 3), modes (#M by #N by 3), eigenvalues (#M),
/// faces (#F by 3), scores (#K by #M; may be missing) and lid (one for each landmark that there
/// was; may be missing), of any kind of number, row by row. Names of shapes are not in it;
/// totalVariance is the sum of its eigenvalues.
///
/// Throws ParameterError, which names the file and what is wrong with it.
ShapeModel readModel(const std::string& file);

}  // namespace sphere_propagation
