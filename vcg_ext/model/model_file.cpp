// SPDX-License-Identifier: GPL-3.0-only
// A zip whose members are stored (PKWARE's APPNOTE 6.3), with arrays of NumPy's format (NumPy
// Enhancement Proposal 1). Whatever a file says of its sizes is checked against its length.

#include "vcg_ext/model/model_file.h"

#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include "vcg_ext/base/error.h"
#include "vcg_ext/mesh/surface_geometry.h"

namespace sphere_propagation {
namespace {

class ArchiveReader {
 public:
  explicit ArchiveReader(const std::string& file) : file_(file) {
    errno = 0;
    std::ifstream stream(std::filesystem::u8path(file), std::ios::binary);
    if (!stream)
      fail(std::string("it cannot be read: ") + (errno ? std::strerror(errno) : "no such file"));
    std::ostringstream all;
    all << stream.rdbuf();
    bytes_ = all.str();
    readDirectory();
  }

  [[noreturn]] void fail(const std::string& why) const {
    throw ParameterError("\"" + file_ + "\" is not a shape model: " + why + ".");
  }

  struct Array {
    std::vector<Eigen::Index> shape;
    std::vector<double> values;      // row by row
    std::vector<std::string> texts;  // in place of values, where it is an array of these
  };

  std::optional<Array> array(const std::string& name) const {
    const auto found = members_.find(name + ".npy");
    if (found == members_.end()) return std::nullopt;
    return arrayOf(name, found->second);
  }

 private:
  std::uint64_t number(std::string_view bytes, size_t at, size_t count) const {
    if (at > bytes.size() || bytes.size() - at < count) fail("it is damaged, or cut short");
    std::uint64_t value = 0;
    for (size_t i = count; i-- > 0;)
      value = value << 8U | static_cast<unsigned char>(bytes[at + i]);
    return value;
  }

  std::string_view part(size_t at, size_t count) const {
    if (at > bytes_.size() || bytes_.size() - at < count) fail("it is damaged, or cut short");
    return std::string_view(bytes_).substr(at, count);
  }

  void readDirectory() {
    constexpr size_t endSize = 22;
    const size_t end = bytes_.rfind("PK\x05\x06");
    if (bytes_.compare(0, 4, "PK\x03\x04") != 0 || end == std::string::npos ||
        bytes_.size() - end < endSize)
      fail("it is no archive of NumPy (.npz)");
    const std::uint64_t count = number(bytes_, end + 10, 2);
    auto at = static_cast<size_t>(number(bytes_, end + 16, 4));
    for (std::uint64_t i = 0; i < count; ++i) {
      if (part(at, 4) != "PK\x01\x02") fail("it is damaged, or cut short");
      const std::uint64_t method = number(bytes_, at + 10, 2);
      const auto size = static_cast<size_t>(number(bytes_, at + 20, 4)),
                 nameSize = static_cast<size_t>(number(bytes_, at + 28, 2)),
                 extra = static_cast<size_t>(number(bytes_, at + 30, 2)),
                 comment = static_cast<size_t>(number(bytes_, at + 32, 2)),
                 local = static_cast<size_t>(number(bytes_, at + 42, 4));
      const std::string name(part(at + 46, nameSize));
      if (method != 0)
        fail(
            "it is compressed. numpy.savez writes archives that are not (read it in Python with "
            "read_model, which gives the model to the filter)");
      const size_t content =
          local + 30 +
          static_cast<size_t>(number(bytes_, local + 26, 2) + number(bytes_, local + 28, 2));
      members_[name] = part(content, size);
      at += 46 + nameSize + extra + comment;
    }
  }

  /// What stands behind 'key': in an array's header.
  std::string entry(const std::string& header, const std::string& key) const {
    size_t at = header.find("'" + key + "'");
    if (at == std::string::npos) return "";
    at = header.find(':', at);
    if (at == std::string::npos) return "";
    at = header.find_first_not_of(' ', at + 1);
    if (at == std::string::npos) return "";
    const char last = header[at] == '(' ? ')' : ',';
    return header.substr(at, header.find(last, at) - at);
  }

  Array arrayOf(const std::string& name, std::string_view member) const {
    if (member.substr(0, 6) != std::string_view("\x93NUMPY", 6))
      fail("its array \"" + name + "\" is none");
    const size_t width = number(member, 6, 1) == 1 ? 2 : 4;
    const auto length = static_cast<size_t>(number(member, 8, width));
    const size_t begin = 8 + width;
    if (member.size() - begin < length) fail("it is damaged, or cut short");
    const std::string header(member.substr(begin, length));
    const std::string_view data = member.substr(begin + length);
    if (entry(header, "fortran_order") != "False")
      fail("its array \"" + name + "\" lies column by column: numpy.ascontiguousarray turns it");
    Array array;
    const std::string extents = entry(header, "shape");
    if (extents.empty() || extents[0] != '(') fail("its array \"" + name + "\" has no shape");
    std::istringstream shape(extents.substr(1));
    std::uint64_t count = 1;
    for (std::string extent; std::getline(shape, extent, ',');) {
      const size_t digit = extent.find_first_of("0123456789");
      if (digit == std::string::npos) continue;
      const std::uint64_t rows = std::strtoull(extent.c_str() + digit, nullptr, 10);
      array.shape.push_back(static_cast<Eigen::Index>(rows));
      if (rows > 0 && count > data.size() / rows) fail("it is damaged, or cut short");
      count *= rows;
    }
    const std::string type = entry(header, "descr");
    if (type.size() > 3 && type.compare(0, 3, "'<U") == 0) {
      array.texts = textsOf(data, std::strtoull(type.c_str() + 3, nullptr, 10), count);
      return array;
    }
    array.values.reserve(count);
    const auto size = static_cast<size_t>(type.size() == 5 ? type[3] - '0' : 0);
    const char kind = type.size() == 5 ? type[2] : ' ';
    const bool known = type.size() == 5 && (type[1] == '<' || type[1] == '|') &&
                       ((kind == 'f' && (size == 4 || size == 8)) ||
                        ((kind == 'i' || kind == 'u' || kind == 'b') &&
                         (size == 1 || size == 2 || size == 4 || size == 8)));
    if (!known) fail("its array \"" + name + "\" is of type " + type + ", which is not read");
    if (data.size() < count * size) fail("it is damaged, or cut short");
    for (size_t i = 0; i < count; ++i)
      array.values.push_back(valueOf(number(data, i * size, size), kind, size));
    return array;
  }

  /// UTF-32, so many letters each, zeros behind the last; as UTF-8.
  std::vector<std::string> textsOf(std::string_view data, std::uint64_t letters,
                                   std::uint64_t count) const {
    if (letters > 0 && count > data.size() / 4 / letters) fail("it is damaged, or cut short");
    std::vector<std::string> texts;
    for (std::uint64_t i = 0; i < count; ++i) {
      std::string text;
      for (std::uint64_t k = 0; k < letters; ++k) {
        const std::uint64_t code = number(data, 4 * (i * letters + k), 4);
        if (code == 0) break;
        addUtf8(text, code);
      }
      texts.push_back(std::move(text));
    }
    return texts;
  }

  static void addUtf8(std::string& text, std::uint64_t code) {
    const auto put = [&text](std::uint64_t byte) { text += static_cast<char>(byte); };
    if (code < 0x80) {
      put(code);
      return;
    }
    const int more = code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
    constexpr std::uint64_t first[]{0, 0xC0, 0xE0, 0xF0};
    put(first[more] | (code >> (6 * more)));
    for (int k = more - 1; k >= 0; --k) put(0x80 | ((code >> (6 * k)) & 0x3F));
  }

  static double valueOf(std::uint64_t bits, char kind, size_t size) {
    if (kind == 'f' && size == 8) {
      double value = 0;
      std::memcpy(&value, &bits, sizeof value);
      return value;
    }
    if (kind == 'f') {
      const auto low = static_cast<std::uint32_t>(bits);
      float value = 0;
      std::memcpy(&value, &low, sizeof value);
      return value;
    }
    if (kind != 'i') return static_cast<double>(bits);
    const unsigned shift = 64 - 8 * static_cast<unsigned>(size);
    return static_cast<double>(static_cast<std::int64_t>(bits << shift) >> shift);
  }

  std::string file_, bytes_;
  std::map<std::string, std::string_view> members_;
};

void readNotes(const ArchiveReader& archive, ShapeModel& model) {
  if (const auto noise = archive.array("noise_variance")) {
    if (noise->values.size() != 1 || !(noise->values[0] >= 0) || std::isinf(noise->values[0]))
      archive.fail("its noise variance is not a number from 0");
    model.noiseVariance = noise->values[0];
  }
  const auto names = archive.array("anchor_names"), landmarks = archive.array("anchor_landmarks");
  if (!names && !landmarks) return;
  if (!names || !landmarks || names->texts.size() != landmarks->values.size())
    archive.fail("its anchor_names are not as many texts as its anchor_landmarks are numbers");
  for (size_t i = 0; i < names->texts.size(); ++i) {
    const double landmark = landmarks->values[i];
    if (!(landmark >= 0 && landmark < static_cast<double>(model.mean.rows())))
      archive.fail("an anchor names a landmark that is not there");
    model.landmarkNames[names->texts[i]] = static_cast<Eigen::Index>(landmark);
  }
}

}  // namespace

ShapeModel readModel(const std::string& file) {
  const ArchiveReader archive(file);
  using Array = ArchiveReader::Array;
  const auto needed = [&](const std::string& name) {
    std::optional<Array> array = archive.array(name);
    if (!array) archive.fail("it has no array \"" + name + "\"");
    return std::move(*array);
  };
  const Array mean = needed("mean"), modes = needed("modes"), eigenvalues = needed("eigenvalues"),
              faces = needed("faces");
  const std::optional<Array> scores = archive.array("scores"), lid = archive.array("lid");
  using Shape = std::vector<Eigen::Index>;
  const Eigen::Index landmarks = mean.shape.empty() ? 0 : mean.shape[0],
                     count = eigenvalues.shape.empty() ? 0 : eigenvalues.shape[0];
  const bool fit = landmarks > 0 && mean.shape == Shape{landmarks, 3} &&
                   eigenvalues.shape == Shape{count} && modes.shape == Shape{count, landmarks, 3} &&
                   faces.shape.size() == 2 && faces.shape[1] == 3 && faces.shape[0] > 0 &&
                   (!scores || (scores->shape.size() == 2 && scores->shape[1] == count));
  if (!fit) archive.fail("its arrays do not fit together");
  for (const Array* array : {&mean, &modes, &eigenvalues})
    for (const double value : array->values)
      if (!std::isfinite(value)) archive.fail("some of its numbers are infinite or NaN");
  ShapeModel model;
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  model.mean = Eigen::Map<const Points>(mean.values.data(), landmarks, 3);
  model.faces.resize(faces.shape[0], 3);
  for (Eigen::Index i = 0; i < model.faces.size(); ++i) {
    const double corner = faces.values[static_cast<size_t>(i)];
    if (!(corner >= 0 && corner < static_cast<double>(landmarks)))
      archive.fail("a face names a landmark that is not there");
    model.faces.data()[i] = static_cast<int>(corner);
  }
  model.modes = Eigen::Map<const RowMajor>(modes.values.data(), count, 3 * landmarks).transpose();
  model.eigenvalues = Eigen::Map<const Eigen::VectorXd>(eigenvalues.values.data(), count);
  if (!(faceAreas(model.mean, model.faces).sum() > 0)) archive.fail("its mean has no area");
  if (count > 0 && model.eigenvalues.minCoeff() < 0) archive.fail("an eigenvalue is negative");
  model.totalVariance = model.eigenvalues.sum();
  model.scores.resize(0, count);
  if (scores) {
    for (const double value : scores->values)
      if (!std::isfinite(value)) archive.fail("some of its numbers are infinite or NaN");
    model.scores = Eigen::Map<const RowMajor>(scores->values.data(), scores->shape[0], count);
  }
  for (Eigen::Index k = 0; k < model.scores.rows(); ++k)
    model.names.push_back("shape " + std::to_string(k));
  readNotes(archive, model);
  if (lid)
    for (const double mark : lid->values) model.leftOut.push_back(mark != 0);
  return model;
}

}  // namespace sphere_propagation
