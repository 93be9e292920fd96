// SPDX-License-Identifier: GPL-3.0-only
#include "benchmarks/ply.h"

#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace sphere_propagation::benchmark {
namespace {

struct Property {
  std::string name, type;
  size_t offset;
};

size_t sizeOf(const std::string& type) {
  static const std::map<std::string, size_t> sizes{
      {"char", 1},  {"uchar", 1},   {"int8", 1},   {"uint8", 1},  {"short", 2}, {"ushort", 2},
      {"int16", 2}, {"uint16", 2},  {"int", 4},    {"uint", 4},   {"int32", 4}, {"uint32", 4},
      {"float", 4}, {"float32", 4}, {"double", 8}, {"float64", 8}};
  return sizes.at(type);
}

template <class Value>
Value valueAt(const char* bytes) {
  Value value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

template <class Value>
void put(std::string& bytes, Value value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

PlyMesh readPly(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string line, element, format;
  std::vector<Property> properties;
  Eigen::Index vertexCount = 0, faceCount = 0;
  size_t vertexSize = 0;
  while (std::getline(file, line) && line.rfind("end_header", 0) != 0) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "format") words >> format;
    if (word == "element") {
      words >> element;
      words >> (element == "vertex" ? vertexCount : faceCount);
    }
    if (word == "property" && element == "vertex") {
      std::string type, name;
      words >> type >> name;
      properties.push_back({name, type, vertexSize});
      vertexSize += sizeOf(type);
    } else if (word == "property" && line.rfind("property list uchar int ", 0) != 0 &&
               line.rfind("property list uint8 int32 ", 0) != 0) {
      throw std::runtime_error(path + ": not a plain triangle mesh");
    }
  }
  if (!file || format != "binary_little_endian")
    throw std::runtime_error(path + ": no binary PLY file");

  std::vector<char> bytes(vertexSize * static_cast<size_t>(vertexCount));
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  const auto column = [&](const std::string& name, Points& to, int k) {
    for (const Property& property : properties) {
      if (property.name != name) continue;
      to.conservativeResize(vertexCount, 3);
      for (Eigen::Index v = 0; v < vertexCount; ++v) {
        const char* at = bytes.data() + static_cast<size_t>(v) * vertexSize + property.offset;
        to(v, k) = sizeOf(property.type) == 8 ? valueAt<double>(at)
                                              : static_cast<double>(valueAt<float>(at));
      }
    }
  };
  PlyMesh mesh;
  for (int k = 0; k < 3; ++k) {
    column({"xyz"[k]}, mesh.vertices, k);
    column(std::string("p") + "xyz"[k], mesh.map, k);
  }
  constexpr size_t faceSize = 13;
  bytes.resize(faceSize * static_cast<size_t>(faceCount));
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!file) throw std::runtime_error(path + ": ends too early");
  mesh.faces.resize(faceCount, 3);
  for (Eigen::Index f = 0; f < faceCount; ++f)
    for (int k = 0; k < 3; ++k)
      mesh.faces(f, k) = valueAt<std::int32_t>(bytes.data() + faceSize * static_cast<size_t>(f) +
                                               1 + 4 * static_cast<size_t>(k));
  return mesh;
}

void writePly(const std::string& path, const PlyMesh& mesh) {
  std::ostringstream header;
  header << "ply\nformat binary_little_endian 1.0\nelement vertex " << mesh.vertices.rows()
         << "\nproperty float x\nproperty float y\nproperty float z\n";
  if (mesh.map.rows() > 0) header << "property double px\nproperty double py\nproperty double pz\n";
  header << "element face " << mesh.faces.rows()
         << "\nproperty list uchar int vertex_indices\nend_header\n";
  std::string bytes = header.str();
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    for (int k = 0; k < 3; ++k) put(bytes, static_cast<float>(mesh.vertices(v, k)));
    if (mesh.map.rows() > 0)
      for (int k = 0; k < 3; ++k) put(bytes, mesh.map(v, k));
  }
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f) {
    put<std::uint8_t>(bytes, 3);
    for (int k = 0; k < 3; ++k) put(bytes, static_cast<std::int32_t>(mesh.faces(f, k)));
  }
  std::ofstream(path, std::ios::binary)
      .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace sphere_propagation::benchmark
