// SPDX-License-Identifier: GPL-3.0-only
// Groups and data sets stand side by side under their ids, and are linked from their groups.

#include "vcg_ext/base/text.h"
#include "vcg_ext/model/export/hdf5.h"

namespace sphere_propagation {
namespace {

constexpr const char* floatJson = R"({"class": "H5T_FLOAT", "base": "H5T_IEEE_F32LE"})";
constexpr const char* integerJson = R"({"class": "H5T_INTEGER", "base": "H5T_STD_I32LE"})";
constexpr const char* stringJson =
    R"({"class": "H5T_STRING", "charSet": "H5T_CSET_UTF8", "strPad": "H5T_STR_NULLTERM", "length": "H5T_VARIABLE"})";
constexpr const char* scalarShape = R"({"class": "H5S_SCALAR"})";

std::string identifier(int number) {
  const std::string digits = std::to_string(number);
  return "\"00000000-0000-4000-8000-" + std::string(12 - digits.size(), '0') + digits + "\"";
}

std::string shapeOf(const Hdf5Data& data) {
  if (data.extents.empty()) return scalarShape;
  std::string dims;
  for (const Eigen::Index extent : data.extents)
    dims += (dims.empty() ? "" : ", ") + std::to_string(extent);
  return R"({"class": "H5S_SIMPLE", "dims": [)" + dims + "]}";
}

/// Lists of lists, as the extents say; one line per innermost list.
void writeValues(ExactText& text, const Hdf5Data& data, size_t axis, size_t& next) {
  if (axis == data.extents.size()) {
    text << data.values[next++];
    return;
  }
  const bool innermost = axis + 1 == data.extents.size();
  text << "[";
  for (Eigen::Index i = 0; i < data.extents[axis]; ++i) {
    if (i > 0) text << (innermost ? ", " : ",\n");
    writeValues(text, data, axis + 1, next);
  }
  text << "]";
}

class Document {
 public:
  std::string text(const Hdf5Group& root) {
    add(root, "", next_++);
    return R"({"apiVersion": "1.1.1", "root": )" + identifier(0) + ",\n\"groups\": {\n" + groups_ +
           "},\n\"datasets\": {\n" + data_ + "}}\n";
  }

 private:
  static std::string attribute(const std::string& name, const std::string& value) {
    std::string text = R"({"name": ")";
    text.append(name).append(R"(", "type": )").append(stringJson);
    return text.append(R"(, "shape": )")
        .append(scalarShape)
        .append(R"(, "value": ")")
        .append(value)
        .append("\"}");
  }

  static std::string link(const std::string& name, const std::string& collection, int id) {
    std::string text = R"({"class": "H5L_TYPE_HARD", "title": ")";
    text.append(name).append(R"(", "collection": ")").append(collection);
    return text.append(R"(", "id": )").append(identifier(id)).append("}");
  }

  void add(const Hdf5Group& group, const std::string& path, int id) {
    std::string attributes, links;
    const auto below = [&path](const std::string& name) {
      return std::string(path).append("/").append(name);
    };
    for (const auto& [name, value] : group.attributes)
      attributes.append(attributes.empty() ? "" : ", ").append(attribute(name, value));
    for (const Hdf5Group& inner : group.groups) {
      links += (links.empty() ? "" : ", ") + link(inner.name, "groups", next_);
      add(inner, below(inner.name), next_++);
    }
    for (const Hdf5Data& data : group.data) {
      links += (links.empty() ? "" : ", ") + link(data.name, "datasets", next_);
      addData(data, below(data.name), next_++);
    }
    groups_ += (groups_.empty() ? "" : ",\n") + identifier(id) + R"(: {"alias": [")" +
               (path.empty() ? "/" : path) + R"("], "attributes": [)" + attributes +
               R"(], "links": [)" + links + "]}";
  }

  void addData(const Hdf5Data& data, const std::string& path, int id) {
    ExactText values;
    size_t next = 0;
    writeValues(values, data, 0, next);
    const std::string type = data.integers ? integerJson : floatJson;
    data_ += (data_.empty() ? "" : ",\n") + identifier(id) + R"(: {"alias": [")" + path +
             R"("], "type": )" + type + R"(, "shape": )" + shapeOf(data) + R"(, "value": )" +
             values.str() + "}";
  }

  std::string groups_, data_;
  int next_ = 0;
};

}  // namespace

std::string hdf5Json(const Hdf5Group& root) { return Document().text(root); }

}  // namespace sphere_propagation
