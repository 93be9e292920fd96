// SPDX-License-Identifier: GPL-3.0-only
// Headers of NRRD: teem.sourceforge.net/nrrd/format.html. ITK 5.2 reads the space
// left-anterior-superior as another one, converts no units, and knows no axis of time.

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <sstream>

#include "filter_label_volume/header_checks.h"

namespace sphere_propagation {
namespace {

constexpr double notGiven = std::numeric_limits<double>::quiet_NaN();

struct NrrdAxis {
  std::int64_t size = 1;
  std::string kind;
  std::optional<std::vector<double>> direction;  // none: it has none in space
  double spacing = notGiven, low = notGiven, high = notGiven;
  bool node = false;  // low and high are those of the outer voxels' centres, not of their faces
  std::string unit;
};

/// What the format calls the spaces, and the short names.
struct Space {
  const char* name;
  const char* shortName;
  int dimensions;
  Vector3 toRas;  // signs
  enum class Says { Sides, NoSides, LeftHanded } says;
};

const Space* spaceCalled(const std::string& name) {
  using Says = Space::Says;
  static const std::array<Space, 12> spaces{{
      {"right-anterior-superior", "ras", 3, {1, 1, 1}, Says::Sides},
      {"left-anterior-superior", "las", 3, {-1, 1, 1}, Says::Sides},
      {"left-posterior-superior", "lps", 3, {-1, -1, 1}, Says::Sides},
      {"right-anterior-superior-time", "rast", 4, {1, 1, 1}, Says::Sides},
      {"left-anterior-superior-time", "last", 4, {-1, 1, 1}, Says::Sides},
      {"left-posterior-superior-time", "lpst", 4, {-1, -1, 1}, Says::Sides},
      {"scanner-xyz", "scanner-xyz", 3, {-1, -1, 1}, Says::NoSides},
      {"scanner-xyz-time", "scanner-xyz-time", 4, {-1, -1, 1}, Says::NoSides},
      {"3d-right-handed", "3d-right-handed", 3, {-1, -1, 1}, Says::NoSides},
      {"3d-left-handed", "3d-left-handed", 3, {-1, -1, 1}, Says::LeftHanded},
      {"3d-right-handed-time", "3d-right-handed-time", 4, {-1, -1, 1}, Says::NoSides},
      {"3d-left-handed-time", "3d-left-handed-time", 4, {-1, -1, 1}, Says::LeftHanded},
  }};
  for (const Space& space : spaces)
    if (name == space.name || name == space.shortName) return &space;
  return nullptr;
}

/// NRRD knows C's names of a type, however long, and those with a number of bits.
std::optional<VoxelType> nrrdType(const std::string& type) {
  std::istringstream words(type);
  std::string name;
  for (std::string word; words >> word;)
    if (word != "signed" && word != "unsigned" && (word != "int" || name.empty())) name += word;
  if (name.size() > 2 && name.substr(name.size() - 2) == "_t") name.resize(name.size() - 2);
  bool isUnsigned = type.rfind("unsigned", 0) == 0;
  if (!name.empty() && name[0] == 'u') {
    name.erase(0, 1);
    isUnsigned = true;
  }
  if (name == "float") return VoxelType::Float;
  if (name == "double") return VoxelType::Double;
  if (name == "char" || name == "int8") return isUnsigned ? VoxelType::Uint8 : VoxelType::Int8;
  if (name == "short" || name == "int16") return isUnsigned ? VoxelType::Uint16 : VoxelType::Int16;
  if (name == "int" || name == "int32") return isUnsigned ? VoxelType::Uint32 : VoxelType::Int32;
  if (name == "longlong" || name == "int64")
    return isUnsigned ? VoxelType::Uint64 : VoxelType::Int64;
  return std::nullopt;
}

/// Words, of which those in quotes may hold blanks.
std::vector<std::string> words(const std::string& text) {
  std::vector<std::string> found;
  for (size_t at = text.find_first_not_of(" \t"); at < text.size();
       at = text.find_first_not_of(" \t", at)) {
    const bool quoted = text[at] == '"';
    const size_t begin = at + (quoted ? 1 : 0);
    const size_t end = std::min(text.find_first_of(quoted ? "\"" : " \t", begin), text.size());
    found.push_back(text.substr(begin, end - begin));
    at = std::min(end + (quoted ? 1 : 0), text.size());
  }
  return found;
}

/// "(1,0,0) none (0,1,0)": a vector per axis, where it has one.
std::vector<std::optional<std::vector<double>>> directionsIn(const std::string& text) {
  std::vector<std::optional<std::vector<double>>> found;
  for (size_t at = text.find_first_not_of(" \t"); at < text.size();
       at = text.find_first_not_of(" \t", at)) {
    if (text[at] == '(') {
      const size_t end = text.find(')', at);
      if (end == std::string::npos) refuse(volume_messages::brokenField, "space directions", text);
      found.emplace_back(realNumbers("space directions", text.substr(at, end - at)));
      at = end + 1;
    } else {
      found.emplace_back();
      at = std::min(text.find_first_of(" \t(", at), text.size());
    }
  }
  return found;
}

/// The numbers of a field that has one per axis; NaN where it has none.
std::vector<double> perAxis(const TextHeader& head, const std::vector<std::string>& names,
                            size_t axes) {
  std::vector<double> numbers = realNumbers(names[0], head.firstOf(names));
  numbers.resize(axes, notGiven);
  return numbers;
}

std::vector<NrrdAxis> axesOf(const TextHeader& head) {
  const auto dimensions = head.wholeNumbers("dimension");
  const auto sizes = head.wholeNumbers("sizes");
  if (dimensions.size() != 1 || static_cast<std::int64_t>(sizes.size()) != dimensions[0])
    refuse(volume_messages::brokenNrrdSize);
  const std::vector<std::string> kinds = words(lowerCase(head.at("kinds"))),
                                 units = words(head.at("units")),
                                 centers =
                                     words(lowerCase(head.firstOf({"centers", "centerings"})));
  const auto directions =
      directionsIn(lowerCase(head.firstOf({"space directions", "spacedirections"})));
  const std::vector<double> spacings = perAxis(head, {"spacings"}, sizes.size()),
                            lows = perAxis(head, {"axis mins", "axismins"}, sizes.size()),
                            highs = perAxis(head, {"axis maxs", "axismaxs"}, sizes.size());
  std::vector<NrrdAxis> axes(sizes.size());
  for (size_t i = 0; i < axes.size(); ++i) {
    NrrdAxis& axis = axes[i];
    axis.size = sizes[i];
    if (i < kinds.size() && kinds[i] != "???" && kinds[i] != "none") axis.kind = kinds[i];
    if (i < directions.size()) axis.direction = directions[i];
    axis.spacing = spacings[i];
    axis.low = lows[i];
    axis.high = highs[i];
    axis.node = i < centers.size() && centers[i] == "node";
    if (i < units.size()) axis.unit = units[i];
  }
  return axes;
}

bool isKindOfSpace(const std::string& kind) {
  return kind.empty() || kind == "domain" || kind == "space";
}

/// Which axes are those of space, the first three of them. Those of the format's kinds for time,
/// lists and what a voxel has several numbers of are none, nor are those without a direction where
/// others have one.
std::vector<size_t> spatialAxes(const std::vector<NrrdAxis>& axes) {
  const bool directed = std::any_of(
      axes.begin(), axes.end(), [](const NrrdAxis& axis) { return axis.direction.has_value(); });
  const auto inSpace = [](const NrrdAxis& axis) {  // the fourth number is time
    for (size_t row = 0; axis.direction && row < std::min<size_t>(3, axis.direction->size()); ++row)
      if ((*axis.direction)[row] != 0) return true;
    return false;
  };
  std::vector<size_t> spatial;
  for (size_t i = 0; i < axes.size(); ++i) {
    const NrrdAxis& axis = axes[i];
    const bool named = isKindOfSpace(axis.kind) || (axis.kind == "time" && axes.size() == 3);
    const bool placed = !directed || (axis.direction && (axes.size() == 3 || inSpace(axis)));
    if (named && placed && spatial.size() < 3) spatial.push_back(i);
  }
  return spatial;
}

/// Phases are a list of volumes, as 3D Slicer's sequences have it, or run in time; its
/// segmentations use the same for overlapping labels.
void requirePhases(const TextHeader& head, const std::vector<NrrdAxis>& axes,
                   const std::vector<size_t>& spatial) {
  for (size_t i = 0; i < axes.size(); ++i) {
    const std::string& kind = axes[i].kind;
    if (axes[i].size == 1 || std::find(spatial.begin(), spatial.end(), i) != spatial.end())
      continue;
    const bool overlapping = kind == "list" && head.pairs.count("segment0_id") != 0;
    if (overlapping || !(isKindOfSpace(kind) || kind == "list" || kind == "time"))
      refuse(volume_messages::severalNumbersOfKind, kind);
  }
}

/// In mm; says where the unit is not known.
double unitIn(const std::string& unit, std::vector<host::Remark>& remarks) {
  const double millimetres = unitByName(unit);
  if (millimetres > 0) return millimetres;
  const host::Remark said = host::remarkOn("", volume_messages::unknownUnit, unit);
  if (std::none_of(remarks.begin(), remarks.end(),
                   [&](const host::Remark& other) { return other.text == said.text; }))
    remarks.push_back(said);
  return 1;
}

/// Without directions: along the axes of the space.
void placeByAxes(VolumeHeader& header, const std::vector<NrrdAxis>& axes,
                 const std::vector<size_t>& spatial) {
  bool placed = true;
  int unknown = 0;
  for (size_t i = 0; i < 3; ++i) {
    const NrrdAxis& axis = axes[spatial[i]];
    const auto n = static_cast<double>(axis.size), steps = axis.node ? n - 1 : n;
    double spacing = axis.spacing;
    if (!std::isfinite(spacing) && std::isfinite(axis.high - axis.low) && axis.high != axis.low &&
        steps > 0)
      spacing = (axis.high - axis.low) / steps;
    if (!std::isfinite(spacing)) {
      spacing = 1;
      ++unknown;
    }
    placed = placed && std::isfinite(axis.low);
    const double unit = unitIn(axis.unit, header.remarks);
    const auto at = static_cast<Eigen::Index>(i);
    header.toRas(at, at) = unit * spacing;
    header.toRas(at, 3) = unit * (axis.low + (axis.node ? 0 : spacing / 2));
  }
  if (unknown > 0)
    header.remarks.push_back(host::remarkOn("", volume_messages::noSpacing, unknown));
  if (!placed) header.toRas.col(3).head<3>().setZero();
}

void placeNrrd(VolumeHeader& header, const TextHeader& head, const std::vector<NrrdAxis>& axes,
               const std::vector<size_t>& spatial) {
  const std::string name = lowerCase(head.at("space"));
  const Space* const space = spaceCalled(name);
  const bool directed = axes[spatial[0]].direction.has_value();
  if (directed) {
    for (size_t i = 0; i < 3; ++i) {
      const std::vector<double>& direction = *axes[spatial[i]].direction;
      for (size_t row = 0; row < 3; ++row)
        header.toRas(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(i)) =
            row < direction.size() ? direction[row] : 0;
    }
  } else {
    placeByAxes(header, axes, spatial);
  }
  const std::vector<double> origin =
      realNumbers("space origin", head.firstOf({"space origin", "spaceorigin"}));
  for (size_t row = 0; row < 3 && origin.size() >= 3; ++row)
    header.toRas(static_cast<Eigen::Index>(row), 3) = std::isnan(origin[row]) ? 0 : origin[row];
  const std::vector<std::string> units = words(head.firstOf({"space units", "spaceunits"}));
  for (size_t row = 0; row < std::min<size_t>(3, units.size()); ++row)
    header.toRas.row(static_cast<Eigen::Index>(row)) *= unitIn(units[row], header.remarks);

  if (space == nullptr)
    header.remarks.push_back(name.empty() ? host::remarkOn("", volume_messages::noPlaceLps)
                                          : host::remarkOn("", volume_messages::noSides, name));
  else if (space->says == Space::Says::NoSides)
    header.remarks.push_back(host::remarkOn("", volume_messages::noSides, name));
  else if (space->says == Space::Says::LeftHanded)
    header.remarks.push_back(host::remarkOn("", volume_messages::leftHanded, name));
  const Vector3 signs = space == nullptr ? Vector3(-1, -1, 1) : space->toRas;
  header.toRas.topRows<3>() = signs.asDiagonal() * header.toRas.topRows<3>();
}

}  // namespace

VolumeHeader readNrrdHeader(const std::string& name) {
  const TextHeader head = readTextHeader(name, ':', "");
  VolumeHeader header;
  header.format = VolumeFormat::Nrrd;
  const std::vector<NrrdAxis> axes = axesOf(head);
  const std::vector<size_t> spatial = spatialAxes(axes);
  if (axes.size() >= 3) requirePhases(head, axes, spatial);
  if (spatial.size() < 3)
    refuse(volume_messages::fewDimensions, std::min(axes.size(), spatial.size()));
  std::vector<std::int64_t> sizes;
  for (const NrrdAxis& axis : axes) sizes.push_back(axis.size);
  setSize(header, sizes, spatial);
  const std::optional<VoxelType> type = nrrdType(lowerCase(head.at("type")));
  if (!type) refuse(volume_messages::noLabelTypeNamed, head.at("type"));
  header.type = *type;
  placeNrrd(header, head, axes, spatial);
  const std::string encoding = lowerCase(head.at("encoding"));
  if (encoding == "bzip2" || encoding == "bz2") refuse(volume_messages::packedByBzip2);
  compareWithData(
      header, head, name, head.firstOf({"data file", "datafile"}),
      encoding == "gzip" || encoding == "gz",
      encoding == "ascii" || encoding == "text" || encoding == "txt" || encoding == "hex");
  return header;
}

}  // namespace sphere_propagation
