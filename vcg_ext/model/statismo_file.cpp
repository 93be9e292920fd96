// HDF5/JSON (the HDF Group's hdf5-json, version 1.1): groups and data sets under ids, linked from their groups.

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "vcg_ext/model/exact_text.h"
#include "vcg_ext/model/model_formats.h"

namespace sphere_propagation {
namespace {

using Matrix = Eigen::MatrixXd;

/// The object's id: a UUID that depends on nothing but the order, so that the same model gives the same file.
std::string identifier(int number) {
  std::string digits = std::to_string(number);
  return "\"00000000-0000-4000-8000-" + std::string(12 - digits.size(), '0') + digits + "\"";
}

constexpr const char* floatType = R"({"class": "H5T_FLOAT", "base": "H5T_IEEE_F32LE"})";
constexpr const char* integerType = R"({"class": "H5T_INTEGER", "base": "H5T_STD_I32LE"})";
constexpr const char* stringType =
    R"({"class": "H5T_STRING", "charSet": "H5T_CSET_UTF8", "strPad": "H5T_STR_NULLTERM", "length": "H5T_VARIABLE"})";

std::string numberShape(std::initializer_list<Eigen::Index> extents) {
  std::string dims;
  for (const Eigen::Index extent : extents) dims += (dims.empty() ? "" : ", ") + std::to_string(extent);
  return R"({"class": "H5S_SIMPLE", "dims": [)" + dims + "]}";
}

constexpr const char* scalarShape = R"({"class": "H5S_SCALAR"})";

template <class Row>
std::string list(const Row& row) {
  ExactText text;
  text << "[";
  for (Eigen::Index i = 0; i < row.size(); ++i) text << (i > 0 ? ", " : "") << row[i];
  text << "]";
  return text.str();
}

template <class Rows>
std::string table(const Rows& rows) {
  std::string text = "[";
  for (Eigen::Index r = 0; r < rows.rows(); ++r) text += (r > 0 ? ",\n" : "") + list(rows.row(r));
  return text + "]";
}

class Document {
 public:
  struct Group {
    std::string path;
    int id;
    std::string attributes, links;
  };

  Document() { groups_.push_back({"", 0, "", ""}); }

  /// parent: index of its group. Returns the new group's.
  size_t addGroup(size_t parent, const std::string& name) {
    link(parent, name, "groups", next_);
    groups_.push_back({groups_[parent].path + "/" + name, next_++, "", ""});
    return groups_.size() - 1;
  }

  void addAttribute(size_t group, const std::string& name, const std::string& value) {
    std::string& all = groups_[group].attributes;
    all += (all.empty() ? "" : ", ") + (R"({"name": ")" + name + R"(", "type": )") + stringType + R"(, "shape": )" +
           scalarShape + R"(, "value": ")" + value + "\"}";
  }

  void addData(size_t group, const std::string& name, const std::string& type, const std::string& shape,
               const std::string& value) {
    link(group, name, "datasets", next_);
    data_ += (data_.empty() ? "" : ",\n") + identifier(next_++) + R"(: {"alias": [")" + groups_[group].path + "/" +
             name + R"("], "type": )" + type + R"(, "shape": )" + shape + R"(, "value": )" + value + "}";
  }

  std::string text() const {
    std::string groups;
    for (const Group& g : groups_)
      groups += (groups.empty() ? "" : ",\n") + identifier(g.id) + R"(: {"alias": [")" +
                (g.path.empty() ? "/" : g.path) + R"("], "attributes": [)" + g.attributes + R"(], "links": [)" +
                g.links + "]}";
    return R"({"apiVersion": "1.1.1", "root": )" + identifier(0) + ",\n\"groups\": {\n" + groups +
           "},\n\"datasets\": {\n" + data_ + "}}\n";
  }

 private:
  void link(size_t group, const std::string& name, const std::string& collection, int id) {
    std::string& all = groups_[group].links;
    all += (all.empty() ? "" : ", ") + (R"({"class": "H5L_TYPE_HARD", "title": ")" + name + R"(", "collection": ")") +
           collection + R"(", "id": )" + identifier(id) + "}";
  }

  std::vector<Group> groups_;
  std::string data_;
  int next_ = 1;
};

}  // namespace

std::string statismoFile(const ShapeModel& model) {
  const Eigen::Index landmarks = model.mean.rows(), modes = model.modeCount(), shapes = model.scores.rows();
  Document document;
  const size_t root = 0;
  const size_t version = document.addGroup(root, "version");
  document.addData(version, "majorVersion", integerType, scalarShape, "0");
  document.addData(version, "minorVersion", integerType, scalarShape, "9");

  const size_t group = document.addGroup(root, "model");
  document.addData(group, "mean", floatType, numberShape({3 * landmarks}),
                   list(Eigen::Map<const Eigen::VectorXd>(model.mean.data(), 3 * landmarks)));
  document.addData(group, "pcaBasis", floatType, numberShape({3 * landmarks, modes}), table(model.modes));
  document.addData(group, "pcaVariance", floatType, numberShape({modes}), list(model.eigenvalues));
  document.addData(group, "noiseVariance", floatType, numberShape({1}), "[0]");

  const size_t representer = document.addGroup(root, "representer");
  document.addAttribute(representer, "name", "itkStandardMeshRepresenter");
  document.addAttribute(representer, "version/majorVersion", "0");
  document.addAttribute(representer, "version/minorVersion", "9");
  document.addAttribute(representer, "datasetType", "POLYGON_MESH");
  document.addData(representer, "points", floatType, numberShape({3, landmarks}), table(model.mean.transpose()));
  document.addData(representer, "cells", integerType, numberShape({3, model.faces.rows()}),
                   table(model.faces.transpose()));

  const size_t info = document.addGroup(root, "modelinfo");
  const Eigen::VectorXd deviations = model.eigenvalues.cwiseSqrt();
  const Matrix scores = deviations.cwiseInverse().asDiagonal() * model.scores.transpose();
  document.addData(info, "scores", floatType, numberShape({modes, shapes}), table(scores));
  return document.text();
}

}  // namespace sphere_propagation
