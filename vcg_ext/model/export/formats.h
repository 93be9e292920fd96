// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// The content of the files of model_export.h, one function per format. Nothing here touches a
/// disk.

#include <string>

#include "vcg_ext/model/shape_model.h"

namespace sphere_propagation {

/// NumPy's archive: an uncompressed zip of .npy arrays (NumPy Enhancement Proposal 1, format 1.0).
/// Throws ExportError where an array takes more than the 4 GB that such a zip can hold.
std::string npzFile(const ShapeModel& model);

/// statismo 0.9 (M. Luethi et al., Statismo - a framework for PCA based statistical models, 2012)
/// as HDF5: model/mean 3N, model/pcaBasis 3N x M (orthonormal), model/pcaVariance M,
/// model/noiseVariance, representer/points 3 x N and cells 3 x F; modelinfo/scores M x K in
/// standard deviations. 32-bit floats, which scalismo and statismo want.
std::string statismoFile(const ShapeModel& model);

/// The same as HDF5/JSON: declared as 32-bit floats, too, but written with all digits.
std::string statismoJson(const ShapeModel& model);

/// ShapeWorks: "x y z" per line.
std::string particlesFile(const Points& landmarks);

/// Binary little-endian PLY of doubles: x, y, z of the mean and mode_m_x, mode_m_y, mode_m_z of
/// each mode; the eigenvalues in comments "eigenvalue m VALUE".
std::string plyFile(const ShapeModel& model);

/// "shape,mode_1,mode_2,...", then one row per shape (RFC 4180).
std::string scoresTable(const ShapeModel& model);

}  // namespace sphere_propagation
