// SPDX-License-Identifier: GPL-3.0-only
// Headers of MetaImage: itk.org/Wiki/MetaIO/Documentation.

#include <cmath>
#include <map>
#include <sstream>

#include "filter_label_volume/header_checks.h"

namespace sphere_propagation {
namespace {

VoxelType metaType(const std::string& name) {
  static const std::map<std::string, VoxelType> types{
      {"met_uchar", VoxelType::Uint8},       {"met_char", VoxelType::Int8},
      {"met_ushort", VoxelType::Uint16},     {"met_short", VoxelType::Int16},
      {"met_uint", VoxelType::Uint32},       {"met_int", VoxelType::Int32},
      {"met_ulong", VoxelType::Uint32},      {"met_long", VoxelType::Int32},
      {"met_ulong_long", VoxelType::Uint64}, {"met_long_long", VoxelType::Int64},
      {"met_float", VoxelType::Float},       {"met_double", VoxelType::Double}};
  const auto type = types.find(lowerCase(name));
  if (type == types.end()) refuse(volume_messages::noLabelTypeNamed, name);
  return type->second;
}

/// MetaIO looks at the first letter.
bool saysYes(const std::string& value) {
  return !value.empty() && (value[0] == 'T' || value[0] == 't' || value[0] == '1');
}

/// Whether three letters, as "RAI", can stand for the directions of the axes in
/// left-posterior-superior. Programs differ in whether they name where an axis comes from, as ITK,
/// or where it goes to, as the format's page.
bool canStandFor(const std::string& letters, const Eigen::Matrix3d& axes) {
  if (letters.size() < 3) return true;
  int from = 0, to = 0;
  for (size_t axis = 0; axis < 3; ++axis) {
    const size_t side = std::string("RLAPIS").find(letters[axis]);
    if (side == std::string::npos) return true;  // "???"
    Eigen::Index row = 0;
    axes.col(static_cast<Eigen::Index>(axis)).cwiseAbs().maxCoeff(&row);
    if (row != static_cast<Eigen::Index>(side / 2)) return false;
    const bool towards =
        axes(row, static_cast<Eigen::Index>(axis)) > 0;  // left, posterior, superior
    ++((side % 2 == 0) == towards ? from : to);
  }
  return from == 3 || to == 3;
}

void placeMeta(VolumeHeader& header, const TextHeader& head, size_t dimensions) {
  const auto numbers = [&](const std::vector<std::string>& names, size_t count) {
    const std::string text = head.firstOf(names);
    std::vector<double> found = realNumbers(names[0], text);
    if (!text.empty() && found.size() < count) refuse(volume_messages::brokenField, names[0], text);
    return found;
  };
  const std::vector<double> spacing = numbers({"elementspacing", "elementsize"}, dimensions),
                            offset = numbers({"origin", "offset", "position"}, dimensions),
                            matrix = numbers({"transformmatrix", "rotation", "orientation"},
                                             dimensions * dimensions);
  const std::string name = head.at("distanceunits");
  double unit = unitByName(name);
  if (unit == 0) {
    header.remarks.push_back(host::remarkOn("", volume_messages::unknownUnit, name));
    unit = 1;
  }
  Eigen::Matrix4d toLps = Eigen::Matrix4d::Identity();
  for (size_t axis = 0; axis < 3; ++axis) {
    const auto column = static_cast<Eigen::Index>(axis);
    for (size_t row = 0; row < 3 && !matrix.empty(); ++row)
      toLps(static_cast<Eigen::Index>(row), column) = matrix[axis * dimensions + row];
    if (!offset.empty()) toLps(column, 3) = offset[axis];
  }
  const std::string letters = head.at("anatomicalorientation");
  if (!canStandFor(letters, toLps.topLeftCorner<3, 3>()))
    header.remarks.push_back(host::remarkOn("", volume_messages::orientationContradicts, letters));
  if (spacing.empty()) header.remarks.push_back(host::remarkOn("", volume_messages::noSpacing, 3));
  for (size_t axis = 0; axis < 3 && !spacing.empty(); ++axis)
    toLps.col(static_cast<Eigen::Index>(axis)) *= spacing[axis];
  toLps.topRows<3>() *= unit;
  header.toRas.topRows<2>() = -toLps.topRows<2>();
  header.toRas.row(2) = toLps.row(2);
}

}  // namespace

VolumeHeader readMetaHeader(const std::string& name) {
  const TextHeader head = readTextHeader(name, '=', "elementdatafile");
  VolumeHeader header;
  header.format = VolumeFormat::Meta;
  const auto dimensions = head.wholeNumbers("ndims");
  const auto size = head.wholeNumbers("dimsize");
  const std::string data = head.at("elementdatafile");
  if (dimensions.size() != 1 || data.empty()) refuse(volume_messages::noMetaImage);
  if (static_cast<std::int64_t>(size.size()) != dimensions[0])
    refuse(volume_messages::brokenMetaSize, dimensions[0], size.size());
  setSize(header, size);
  const auto channels = head.wholeNumbers("elementnumberofchannels");
  if (!channels.empty() && channels[0] != 1) refuse(volume_messages::severalNumbers, channels[0]);
  header.type = metaType(head.at("elementtype"));
  placeMeta(header, head, size.size());
  const bool inside = lowerCase(data) == "local", compressed = saysYes(head.at("compresseddata"));
  if (compressed) {  // ITK leaves out without a word what is not there
    const auto length = head.wholeNumbers("compresseddatasize");
    if (length.size() != 1) refuse(volume_messages::noCompressedSize);
    if (inside &&
        sizeOfFile(std::filesystem::u8path(name)) - head.end < static_cast<double>(length[0]))
      refuse(volume_messages::truncatedCompressed, bytesInWords(static_cast<double>(length[0])));
  }
  compareWithData(header, head, name, inside ? "" : data, compressed,
                  !head.at("binarydata").empty() && !saysYes(head.at("binarydata")));
  return header;
}

}  // namespace sphere_propagation
