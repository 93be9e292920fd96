// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// Just enough of mesh files for the examples: reads triangles from OFF, and from PLY as text or as
/// little-endian bytes; writes OFF. Whatever else the files hold is skipped.

#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "vcg_ext/mesh/closed_surface.h"

namespace example {

/// What a number is in a PLY file, and how many bytes it takes there.
inline size_t sizeOf(const std::string& type) {
  if (type == "double" || type == "float64") return 8;
  if (type == "short" || type == "ushort" || type == "int16" || type == "uint16") return 2;
  return type.find("char") != std::string::npos || type.find("int8") != std::string::npos ? 1 : 4;
}

inline double readNumber(std::istream& file, const std::string& type, bool text) {
  double number = 0;
  if (text) {
    file >> number;
    return number;
  }
  char bytes[8] = {};
  file.read(bytes, static_cast<std::streamsize>(sizeOf(type)));
  const auto as = [&bytes](auto value) {
    std::memcpy(&value, bytes, sizeof value);
    return static_cast<double>(value);
  };
  if (type[0] == 'd' || type == "float64") return as(double());
  if (type[0] == 'f') return as(float());
  if (sizeOf(type) == 4) return as(int());
  return sizeOf(type) == 2 ? as(short()) : as(static_cast<unsigned char>(0));
}

/// Throws std::runtime_error where the file is none of these, and SurfaceError where the mesh is no
/// closed surface.
inline sphere_propagation::ClosedSurface readSurface(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string line, word, element;
  std::getline(file, line);
  const bool ply = line.rfind("ply", 0) == 0;
  bool text = true;
  Eigen::Index vertexCount = 0, faceCount = 0;
  std::vector<std::string> types, names;  // of the numbers of a vertex
  std::string countType, indexType;
  if (ply) {
    while (std::getline(file, line) && line.rfind("end_header", 0) != 0) {
      std::istringstream words(line);
      words >> word;
      if (word == "format") {
        words >> word;
        text = word == "ascii";
      } else if (word == "element") {
        words >> element >> (element == "vertex" ? vertexCount : faceCount);
      } else if (word == "property" && element == "vertex") {
        words >> types.emplace_back() >> names.emplace_back();
      } else if (word == "property" && element == "face") {
        words >> word >> countType >> indexType;
      }
    }
  } else {
    file >> vertexCount >> faceCount >> word;
    names = {"x", "y", "z"};
    types = {"", "", ""};
  }

  sphere_propagation::Points vertices(vertexCount, 3);
  for (Eigen::Index v = 0; v < vertexCount; ++v)
    for (size_t i = 0; i < names.size(); ++i) {
      const double number = readNumber(file, types[i], text);
      for (int k = 0; k < 3; ++k)
        if (names[i] == std::string(1, "xyz"[k])) vertices(v, k) = number;
    }
  sphere_propagation::Triangles faces(faceCount, 3);
  for (Eigen::Index f = 0; f < faceCount; ++f) {
    if (readNumber(file, countType, text) != 3)
      throw std::runtime_error(path + ": not made of triangles");
    for (int k = 0; k < 3; ++k) faces(f, k) = static_cast<int>(readNumber(file, indexType, text));
  }
  if (!file) throw std::runtime_error(path + ": no PLY or OFF file, or not all of it");
  return {std::move(vertices), std::move(faces), path};
}

inline void writeOff(const std::string& path, const sphere_propagation::Points& vertices,
                     const sphere_propagation::Triangles& faces) {
  std::ofstream file(path);
  file.precision(9);
  file << "OFF\n" << vertices.rows() << ' ' << faces.rows() << " 0\n";
  for (Eigen::Index v = 0; v < vertices.rows(); ++v) file << vertices.row(v) << '\n';
  for (Eigen::Index f = 0; f < faces.rows(); ++f) file << "3 " << faces.row(f) << '\n';
  if (!file.flush()) throw std::runtime_error(path + ": cannot be written");
}

}  // namespace example
