// SPDX-License-Identifier: GPL-3.0-only
#include "filter_sphere_propagation/reporting.h"

namespace sphere_propagation {

std::string describeMap(const std::string& label, const ClosedSurface& surface,
                        const MapMeasures& measures) {
  std::string line = label + ": " + counted(surface.vertexCount(), "vertex", "vertices") + ", " +
                     counted(measures.certificate.flippedFaces, "flipped face", "flipped faces") +
                     ", area ratio sd " + shortNumber(measures.areaRatioSd) + ", angle error " +
                     shortNumber(measures.angleErrorMean) + " degrees";
  if (!measures.certificate.valid()) line += "; NOT VALID: " + measures.certificate.reason();
  return line;
}

MapFigures::MapFigures(size_t layers) {
  for (Eigen::VectorXd* figure :
       {&flippedFaces_, &areaRatioSd_, &areaLogMean_, &angleErrorMean_, &seconds_})
    *figure = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(layers));
}

void MapFigures::set(size_t layer, const MapMeasures& measures, double seconds) {
  const auto i = static_cast<Eigen::Index>(layer);
  flippedFaces_[i] = static_cast<double>(measures.certificate.flippedFaces);
  areaRatioSd_[i] = measures.areaRatioSd;
  areaLogMean_[i] = measures.areaLogMean;
  angleErrorMean_[i] = measures.angleErrorMean;
  seconds_[i] = seconds;
}

void MapFigures::addTo(host::Outputs& outputs) const {
  outputs["flipped_faces"] = flippedFaces_;
  outputs["area_ratio_sd"] = areaRatioSd_;
  outputs["area_log_mean"] = areaLogMean_;
  outputs["angle_error_mean"] = angleErrorMean_;
  outputs["seconds"] = seconds_;
}

std::string mapFiguresInfo() {
  return "<b>flipped_faces</b>: faces that are not positively oriented on the sphere (0 in a valid "
         "map); <b>area_ratio_sd</b>: standard deviation over the faces of share of the sphere / "
         "share of the surface (0: area-preserving); <b>area_log_mean</b>: mean |ln| of that "
         "ratio; <b>angle_error_mean</b>: mean |corner angle on the sphere - corner angle on the "
         "mesh| in degrees; <b>seconds</b>. Faces smaller than 1e-5 of the mean area count for "
         "flipped_faces only.";
}

std::string paperReference() {
  return "See:<br><i>Matthias Kirschner and Stefan Wesarg</i><br><b>\"Propagation of shape "
         "parameterisation for the construction of a statistical shape model of the left "
         "ventricle\"</b><br>Eurographics Workshop on Visual Computing for Biology and Medicine, "
         "2010.<br>";
}

}  // namespace sphere_propagation
