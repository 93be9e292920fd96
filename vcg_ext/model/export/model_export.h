// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Shape models as files that other programs read. docs/shape_model.md describes the layouts.

#include <string>
#include <vector>

#include "vcg_ext/model/shape_model.h"

namespace sphere_propagation {

/// The endings that exportModel knows, for texts: ".npz, .json, ...".
std::string modelFileEndings();

/// Whether `path` can be written: an ending that is known, in a folder that exists, no folder
/// itself. To be asked before a long computation. Throws ExportError.
void requireExportable(const std::string& path);

/// Writes the model; the ending (in any case) chooses the format:
///
/// - .npz: NumPy: mean N x 3, modes M x N x 3, eigenvalues M, scores K x M (doubles), faces F x 3
///   (ints), lid; where landmarks have names, anchor_names (texts) and anchor_landmarks
/// - .h5: statismo's layout as HDF5, 32-bit floats: for statismo, scalismo and whatever reads HDF5
/// - .json: the same as HDF5/JSON, which scalismo reads
/// - .particles: ShapeWorks: the mean, and beside it one file per shape, NAME_000.particles and so
///   on, as aligned
/// - .ply: the mean, with the modes as vertex properties mode_1_x, mode_1_y, mode_1_z, ...
/// - .csv: the scores, one row per shape
///
/// Numbers have 17 digits where they are text. A file that is there already is replaced only when
/// the new one is complete.
///
/// path: UTF-8; aligned: the shapes that the model was built from. Returns the files written.
/// Throws ExportError as requireExportable does, and when writing fails.
std::vector<std::string> exportModel(const std::string& path, const ShapeModel& model,
                                     const TrainingSet& aligned);

}  // namespace sphere_propagation
