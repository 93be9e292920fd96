// SPDX-License-Identifier: GPL-3.0-only
#include <string>
#include <utility>
#include <vector>

#include "vcg_ext/model/export/formats.h"
#include "vcg_ext/model/export/hdf5.h"

namespace sphere_propagation {
namespace {

template <class Derived>
std::vector<double> values(const Eigen::DenseBase<Derived>& rows) {
  std::vector<double> all;
  all.reserve(static_cast<size_t>(rows.size()));
  for (Eigen::Index r = 0; r < rows.rows(); ++r)
    for (Eigen::Index c = 0; c < rows.cols(); ++c) all.push_back(static_cast<double>(rows(r, c)));
  return all;
}

/// model/mean, pcaBasis, ...; representer/points, cells; modelinfo/scores: docs/shape_model.md.
Hdf5Group statismoTree(const ShapeModel& model) {
  const Eigen::Index landmarks = model.mean.rows(), modes = model.modeCount(),
                     shapes = model.scores.rows();
  const Eigen::MatrixXd scores =
      model.eigenvalues.cwiseSqrt().cwiseInverse().asDiagonal() * model.scores.transpose();
  Hdf5Group version{
      "version", {}, {}, {{"majorVersion", {}, true, {0}}, {"minorVersion", {}, true, {9}}}};
  Hdf5Group pca{"model",
                {},
                {},
                {{"mean", {3 * landmarks}, false, values(model.mean)},
                 {"pcaBasis", {3 * landmarks, modes}, false, values(model.modes)},
                 {"pcaVariance", {modes}, false, values(model.eigenvalues)},
                 {"noiseVariance", {1}, false, {0}}}};
  Hdf5Group representer{
      "representer",
      {{"name", "itkStandardMeshRepresenter"},
       {"version/majorVersion", "0"},
       {"version/minorVersion", "9"},
       {"datasetType", "POLYGON_MESH"}},
      {},
      {{"points", {3, landmarks}, false, values(model.mean.transpose())},
       {"cells", {3, model.faces.rows()}, true, values(model.faces.transpose())}}};
  Hdf5Group info{"modelinfo", {}, {}, {{"scores", {modes, shapes}, false, values(scores)}}};
  return {
      "", {}, {std::move(version), std::move(pca), std::move(representer), std::move(info)}, {}};
}

}  // namespace

std::string statismoFile(const ShapeModel& model) { return hdf5File(statismoTree(model)); }

std::string statismoJson(const ShapeModel& model) { return hdf5Json(statismoTree(model)); }

}  // namespace sphere_propagation
