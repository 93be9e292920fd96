// SPDX-License-Identifier: GPL-3.0-only
#include "filter_label_volume/header_checks.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <limits>
#include <locale>
#include <sstream>

#include "vcg_ext/base/text.h"

namespace sphere_propagation {
namespace {

namespace fs = std::filesystem;

constexpr double maxData = 4.0 * 1024 * 1024 * 1024;  // bytes
constexpr double maxDeflation = 1032;                 // zlib cannot do better
constexpr size_t longestTextHeader = 1 << 20;
constexpr std::int64_t longestAxis = 32767, maxPhases = 10000;

}  // namespace

size_t bytesOf(VoxelType type) {
  switch (type) {
    case VoxelType::Int8:
    case VoxelType::Uint8:
      return 1;
    case VoxelType::Int16:
    case VoxelType::Uint16:
      return 2;
    case VoxelType::Int32:
    case VoxelType::Uint32:
    case VoxelType::Float:
      return 4;
    default:
      return 8;
  }
}

std::string bytesInWords(double count) {
  if (count >= 1e6) return shortNumber(count / 1e6) + " MB";
  return std::to_string(static_cast<std::int64_t>(count)) + " bytes";
}

void setSize(VolumeHeader& header, const std::vector<std::int64_t>& axes) {
  setSize(header, axes, {0, 1, 2});
}

void setSize(VolumeHeader& header, const std::vector<std::int64_t>& axes,
             const std::vector<size_t>& spatial) {
  std::string text;
  for (const std::int64_t n : axes) text += (text.empty() ? "" : " x ") + std::to_string(n);
  for (const std::int64_t n : axes)
    if (n < 1) refuse(volume_messages::noVoxels, text);
  if (axes.size() < 3) refuse(volume_messages::fewDimensions, axes.size());
  std::vector<size_t> others;  // with more than one entry
  for (size_t axis = 0; axis < axes.size(); ++axis)
    if (axes[axis] > 1 && std::find(spatial.begin(), spatial.end(), axis) == spatial.end())
      others.push_back(axis);
  if (others.size() > 1) refuse(volume_messages::manyDimensions, 3 + others.size(), text);
  for (size_t i = 0; i < 3; ++i)
    if (axes[spatial[i]] > longestAxis) refuse(volume_messages::tooLongAxis, text);
  if (!others.empty() && axes[others[0]] > maxPhases)
    refuse(volume_messages::tooManyPhases, axes[others[0]]);
  std::vector<std::int64_t> strides(axes.size(), 1);
  for (size_t axis = 1; axis < axes.size(); ++axis)
    strides[axis] = strides[axis - 1] * axes[axis - 1];
  for (size_t i = 0; i < 3; ++i) {
    header.size[i] = axes[spatial[i]];
    header.strides[i] = strides[spatial[i]];
  }
  header.size[3] = others.empty() ? 1 : axes[others[0]];
  header.strides[3] = others.empty() ? 0 : strides[others[0]];
}

void compareWithFile(VolumeHeader& header, double claimed, double present, bool compressed) {
  if (claimed > maxData) refuse(volume_messages::tooLarge, bytesInWords(claimed));
  if (compressed && claimed > present * maxDeflation)
    refuse(volume_messages::claimsMoreThanPacked, bytesInWords(claimed),
           bytesInWords(present * maxDeflation));
  if (!compressed && claimed > present)
    refuse(volume_messages::claimsMore, bytesInWords(claimed), bytesInWords(present));
  if (!compressed && present > claimed)
    header.remarks.push_back(
        host::remarkOn("", volume_messages::moreThanClaimed, bytesInWords(present - claimed)));
}

double sizeOfFile(const fs::path& path) {
  std::error_code error;
  const auto size = fs::file_size(path, error);
  if (error) refuse(volume_messages::voxelFileNotRead, path.u8string());
  return static_cast<double>(size);
}

double unitByName(std::string name) {
  name = lowerCase(trimmed(name));
  // Micro, in UTF-8 (two characters look so) and in Latin 1.
  for (const char* micro : {"\xc2\xb5", "\xce\xbc", "\xb5"})
    if (name.rfind(micro, 0) == 0) name.replace(0, std::string(micro).size(), "u");
  // "millimetres", "micro-meter": as "millimeter", "micrometer".
  name.erase(std::remove_if(name.begin(), name.end(),
                            [](char c) { return c == '-' || c == '_' || c == ' ' || c == '.'; }),
             name.end());
  if (name.size() > 2 && name.back() == 's') name.pop_back();
  if (const size_t at = name.find("metre"); at != std::string::npos) name.replace(at, 5, "meter");
  static const std::map<std::string, double> units{{"", 1},
                                                   {"???", 1},
                                                   {"?", 1},
                                                   {"none", 1},
                                                   {"mm", 1},
                                                   {"millimeter", 1},
                                                   {"um", 1e-3},
                                                   {"micron", 1e-3},
                                                   {"micrometer", 1e-3},
                                                   {"nm", 1e-6},
                                                   {"nanometer", 1e-6},
                                                   {"cm", 10},
                                                   {"centimeter", 10},
                                                   {"dm", 100},
                                                   {"decimeter", 100},
                                                   {"m", 1000},
                                                   {"meter", 1000},
                                                   {"in", 25.4},
                                                   {"inch", 25.4},
                                                   {"inche", 25.4}};
  const auto found = units.find(name);
  return found == units.end() ? 0 : found->second;
}

std::string lowerCase(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

std::string trimmed(const std::string& text) {
  const size_t first = text.find_first_not_of(" \t\r"), last = text.find_last_not_of(" \t\r");
  return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

std::string TextHeader::at(const std::string& name) const {
  const auto found = fields.find(name);
  return found == fields.end() ? "" : found->second;
}

std::string TextHeader::firstOf(const std::vector<std::string>& names) const {
  for (const std::string& name : names)
    if (const auto found = fields.find(name); found != fields.end()) return found->second;
  return "";
}

std::vector<std::int64_t> TextHeader::wholeNumbers(const std::string& name) const {
  std::istringstream text(at(name));
  text.imbue(std::locale::classic());
  std::vector<std::int64_t> found;
  for (std::int64_t n = 0; text >> n;) found.push_back(n);
  return found;
}

TextHeader readTextHeader(const std::string& name, char separator, const std::string& last) {
  std::ifstream file(fs::u8path(name), std::ios::binary);
  std::string text(longestTextHeader, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<size_t>(file.gcount()));
  TextHeader head;
  for (size_t at = 0; at < text.size();) {
    size_t end = text.find('\n', at);
    if (end == std::string::npos) end = text.size();
    const std::string line = trimmed(text.substr(at, end - at));
    at = end + 1;
    head.end = static_cast<double>(std::min(at, text.size()));
    if (line.empty()) break;
    const size_t split = line.find(separator);
    if (line[0] == '#' || split == std::string::npos) continue;
    const std::string key = lowerCase(trimmed(line.substr(0, split)));
    const std::string value = line.substr(split + 1);
    if (separator == ':' && !value.empty() && value[0] == '=') {
      head.pairs[key] = value.substr(1);
      continue;
    }
    head.fields[key] = trimmed(value);
    if (key == last) break;
  }
  return head;
}

double realNumber(const std::string& field, const std::string& word) {
  std::istringstream text(word);
  text.imbue(std::locale::classic());
  double number = 0;
  if (text >> number && text.peek() == std::istringstream::traits_type::eof()) return number;
  std::string special = lowerCase(word);
  const bool negative = !special.empty() && special[0] == '-';
  if (!special.empty() && (negative || special[0] == '+')) special.erase(0, 1);
  if (special.rfind("nan", 0) == 0) return std::numeric_limits<double>::quiet_NaN();
  if (special.rfind("inf", 0) == 0)
    return (negative ? -1 : 1) * std::numeric_limits<double>::infinity();
  refuse(volume_messages::brokenField, field, word);
}

std::vector<double> realNumbers(const std::string& field, const std::string& text) {
  std::vector<double> numbers;
  for (size_t at = text.find_first_not_of(" \t,()"); at < text.size();) {
    const size_t end = std::min(text.find_first_of(" \t,()", at), text.size());
    numbers.push_back(realNumber(field, text.substr(at, end - at)));
    at = text.find_first_not_of(" \t,()", end);
  }
  return numbers;
}

void compareWithData(VolumeHeader& header, const TextHeader& head, const std::string& name,
                     const std::string& dataFile, bool compressed, bool text) {
  const bool inside = dataFile.empty();
  if (!inside &&
      (dataFile.find('%') != std::string::npos || lowerCase(dataFile).rfind("list", 0) == 0))
    refuse(volume_messages::severalFiles);
  const fs::path data =
      inside ? fs::u8path(name) : fs::u8path(name).parent_path() / fs::u8path(dataFile);
  double present = sizeOfFile(data);
  if (inside) present -= head.end;
  const auto numbers = static_cast<double>(header.voxels());
  const double claimed = text ? 2 * numbers - 1  // digits with a blank between them
                              : numbers * static_cast<double>(bytesOf(header.type));
  const std::vector<host::Remark> before = header.remarks;
  compareWithFile(header, claimed, present, compressed);
  if (text) header.remarks = before;  // digits and blanks may be as many as they like
}

}  // namespace sphere_propagation
