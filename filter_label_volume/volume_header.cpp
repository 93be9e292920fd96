// SPDX-License-Identifier: GPL-3.0-only
#include "filter_label_volume/volume_header.h"

#include <zlib.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>

#include "vcg_ext/base/error.h"
#include "vcg_ext/base/text.h"

namespace sphere_propagation {
namespace {

namespace fs = std::filesystem;

constexpr double maxData = 4.0 * 1024 * 1024 * 1024;  // bytes
constexpr double maxDeflation = 1032;                 // zlib cannot do better
constexpr size_t longestTextHeader = 1 << 20;

[[noreturn]] void fail(const std::string& what) { throw VolumeError(what); }

std::string bytes(double count) {
  if (count >= 1e6) return shortNumber(count / 1e6) + " MB";
  return std::to_string(static_cast<std::int64_t>(count)) + " bytes";
}

/// Checks a list of sizes, takes trailing ones of 1 off, and fills 3 entries at least.
std::vector<std::int64_t> checkedSize(std::vector<std::int64_t> size) {
  std::string text;
  for (const std::int64_t n : size) text += (text.empty() ? "" : " x ") + std::to_string(n);
  for (const std::int64_t n : size)
    if (n < 1) fail("the volume has no voxels: its size is " + text);
  if (size.size() < 3)
    fail("it is an image of " + std::to_string(size.size()) +
         " dimensions; label volumes have 3 or 4");
  while (size.size() > 3 && size.back() == 1) size.pop_back();
  if (size.size() > 4)
    fail("it has " + std::to_string(size.size()) + " dimensions (" + text +
         "); label volumes have 3, or 4 with time");
  for (int axis = 0; axis < 3; ++axis)
    if (size[static_cast<size_t>(axis)] > 32767)
      fail("the size " + text + " is beyond what can be read (32767 per axis)");
  if (size.size() == 4 && size[3] > 10000)
    fail("there are " + std::to_string(size[3]) + " phases; the most are 10000");
  return size;
}

double product(const std::vector<std::int64_t>& size) {
  double count = 1;
  for (const std::int64_t n : size) count *= static_cast<double>(n);
  return count;
}

/// The data claimed by the head against what the file holds. offset: where the data begin.
void compare(double claimed, double present, bool compressed, std::vector<std::string>& notes) {
  if (claimed > maxData)
    fail("the data take " + bytes(claimed) + "; the most that is read is 4 GB: crop the volume");
  if (compressed && claimed > present * maxDeflation)
    fail("the header claims " + bytes(claimed) + " of voxels, but the file can hold at most " +
         bytes(present * maxDeflation) + " of them: it is truncated or its header is wrong");
  if (!compressed && claimed > present)
    fail("the header claims " + bytes(claimed) + " of voxels, but the file holds " +
         bytes(present) + " of them: it is truncated or its header is wrong");
  if (!compressed && present > claimed)
    notes.push_back("the file holds " + bytes(present - claimed) +
                    " more than its header says; they are ignored");
}

double sizeOfFile(const fs::path& path) {
  std::error_code error;
  const auto size = fs::file_size(path, error);
  if (error) fail("the file \"" + path.u8string() + "\" with its voxels cannot be read");
  return static_cast<double>(size);
}

// ---------------------------------------------------------------- NIfTI

/// Reads numbers of a head, whichever way round their bytes are.
class Fields {
 public:
  Fields(const unsigned char* data, bool swapped) : data_(data), swapped_(swapped) {}
  bool swapped() const { return swapped_; }
  template <class T>
  T get(size_t offset) const {
    std::array<unsigned char, sizeof(T)> raw{};
    std::copy_n(data_ + offset, sizeof(T), raw.begin());
    if (swapped_) std::reverse(raw.begin(), raw.end());
    T value{};
    std::memcpy(&value, raw.data(), sizeof(T));
    return value;
  }

 private:
  const unsigned char* data_;
  bool swapped_;
};

/// A file that may be compressed by gzip.
class GzipFile {
 public:
  explicit GzipFile(const std::string& name) : file_(gzopen(name.c_str(), "rb"), &gzclose) {
    if (!file_) fail("it cannot be opened");
    gzbuffer(file_.get(), 1 << 17);
  }
  size_t read(unsigned char* to, size_t count) {
    const int got = gzread(file_.get(), to, static_cast<unsigned>(count));
    return got < 0 ? 0 : static_cast<size_t>(got);
  }
  bool compressed() { return gzdirect(file_.get()) == 0; }

 private:
  std::unique_ptr<gzFile_s, int (*)(gzFile)> file_;
};

VoxelType niftiType(int code) {
  switch (code) {
    case 2:
      return VoxelType::Uint8;
    case 4:
      return VoxelType::Int16;
    case 8:
      return VoxelType::Int32;
    case 16:
      return VoxelType::Float;
    case 64:
      return VoxelType::Double;
    case 256:
      return VoxelType::Int8;
    case 512:
      return VoxelType::Uint16;
    case 768:
      return VoxelType::Uint32;
    case 1024:
      return VoxelType::Int64;
    case 1280:
      return VoxelType::Uint64;
    case 1:
      fail(
          "its voxels are single bits (NIfTI data type 1), which cannot be read: convert them to "
          "bytes");
    default:
      fail("its voxels are no whole or real numbers (NIfTI data type " + std::to_string(code) +
           "): colours and complex numbers are no labels");
  }
}

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

/// Whether the axes are at right angles, as ITK wants them.
bool isSheared(const Eigen::Matrix4d& matrix) {
  const Eigen::Matrix3d axes = matrix.topLeftCorner<3, 3>().colwise().normalized();
  return !((axes.transpose() * axes - Eigen::Matrix3d::Identity()).cwiseAbs().array() < 1e-6)
              .all();  // true for NaN
}

/// How much a unit of the head is in millimetres.
double niftiUnit(const Fields& f, bool second) {
  const int unit = (second ? f.get<std::int32_t>(500) : f.get<unsigned char>(123)) & 7;
  return unit == 1 ? 1000 : unit == 3 ? 0.001 : 1;
}

/// R. W. Cox et al., NIfTI-1 and NIfTI-2 data formats: methods 3 (sform), 2 (qform) and 1.
Eigen::Matrix4d niftiMatrix(const Fields& f, bool second, std::vector<std::string>& notes) {
  const auto real = [&](size_t one, size_t two, size_t index) {
    return second ? f.get<double>(two + 8 * index)
                  : static_cast<double>(f.get<float>(one + 4 * index));
  };
  const int qform = second ? f.get<std::int32_t>(344) : f.get<std::int16_t>(252);
  const int sform = second ? f.get<std::int32_t>(348) : f.get<std::int16_t>(254);
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  if (sform > 0) {
    for (size_t i = 0; i < 12; ++i)
      matrix(static_cast<Eigen::Index>(i / 4), static_cast<Eigen::Index>(i % 4)) =
          real(280, 400, i);
  } else {
    Vector3 spacing;
    for (size_t i = 0; i < 3; ++i) spacing[static_cast<Eigen::Index>(i)] = real(76, 104, i + 1);
    if (qform > 0) {
      const double b = real(256, 352, 0), c = real(256, 352, 1), d = real(256, 352, 2);
      const double rest = 1 - b * b - c * c - d * d;
      Eigen::Quaterniond q(std::sqrt(std::max(rest, 0.0)), b, c, d);
      matrix.topLeftCorner<3, 3>() = q.normalized().toRotationMatrix();
      if (real(76, 104, 0) < 0) matrix.col(2) *= -1;
      for (size_t i = 0; i < 3; ++i) matrix(static_cast<Eigen::Index>(i), 3) = real(268, 376, i);
    } else {
      notes.emplace_back(
          "the file does not say where it lies: its axes are taken for right, anterior and "
          "superior");
    }
    for (int i = 0; i < 3; ++i) matrix.col(i) *= std::fabs(spacing[i]);
  }
  matrix.topRows<3>() *= niftiUnit(f, second);
  return matrix;
}

/// Whether the columns of the matrix are as long as the spacings that the head names besides.
bool agreesWithPixdim(const Fields& f, bool second, const Eigen::Matrix4d& matrix) {
  for (size_t i = 0; i < 3; ++i) {
    const double named =
        niftiUnit(f, second) * std::fabs(second ? f.get<double>(112 + 8 * i)
                                                : static_cast<double>(f.get<float>(80 + 4 * i)));
    const double length = matrix.col(static_cast<Eigen::Index>(i)).head<3>().norm();
    if (!(std::fabs(named - length) <= 1e-5 * length)) return false;
  }
  return true;
}

/// The file of the same name without ".gz" beside a packed one, which ITK reads in its place; empty
/// where there is none.
std::string unpackedTwin(const std::string& name) {
  const fs::path path = fs::u8path(name);
  if (path.extension() != ".gz") return "";
  const fs::path twin = path.parent_path() / path.stem();
  std::error_code error;
  return fs::exists(twin, error) ? twin.u8string() : "";
}

VolumeHeader readNifti(const std::string& name) {
  GzipFile file(name);
  std::array<unsigned char, 540> head{};
  const size_t got = file.read(head.data(), head.size());
  Fields f(head.data(), false);
  auto length = f.get<std::int32_t>(0);
  if (length != 348 && length != 540) {
    f = Fields(head.data(), true);
    length = f.get<std::int32_t>(0);
  }
  const bool second = length == 540;
  if (got < static_cast<size_t>(second ? 540 : 348)) fail("it ends within its header");
  if (length != 348 && length != 540) fail("it is no NIfTI file, though its name says so");
  VolumeHeader header;
  header.format = VolumeFormat::Nifti;
  const auto dimension = [&](size_t i) -> std::int64_t {
    return second ? f.get<std::int64_t>(16 + 8 * i) : f.get<std::int16_t>(40 + 2 * i);
  };
  const std::int64_t dimensions = dimension(0);
  if (dimensions < 1 || dimensions > 7)
    fail("its header is broken: it claims " + std::to_string(dimensions) + " dimensions");
  for (size_t i = 1; i <= static_cast<size_t>(dimensions); ++i) header.size.push_back(dimension(i));
  header.size = checkedSize(std::move(header.size));
  const double offset = second ? static_cast<double>(f.get<std::int64_t>(168))
                               : static_cast<double>(f.get<float>(108));
  if (!(offset >= 0 && offset < 1e9))
    fail("its header is broken: the voxels begin at byte " + std::to_string(offset));
  header.type = niftiType(f.get<std::int16_t>(second ? 12 : 70));
  const double claimed = product(header.size) * static_cast<double>(bytesOf(header.type));
  header.voxelsBegin = static_cast<std::int64_t>(offset);
  header.toRas = niftiMatrix(f, second, header.notes);
  const bool oddMatrix = isSheared(*header.toRas) || !agreesWithPixdim(f, second, *header.toRas);
  const std::string twin = unpackedTwin(name);
  // ITK takes NaN for 0 where voxels are real numbers.
  const bool real = header.type == VoxelType::Float || header.type == VoxelType::Double;
  header.unusual = oddMatrix || !twin.empty() || real;
  header.swapped = f.swapped();
  const double slope = second ? f.get<double>(176) : static_cast<double>(f.get<float>(112));
  const double shift = second ? f.get<double>(184) : static_cast<double>(f.get<float>(116));
  if (slope != 0 && (slope != 1 || shift != 0)) {
    if (oddMatrix)
      fail(
          "its matrix is sheared, or disagrees with its pixdim, and its voxels are scaled "
          "(scl_slope), which are not read together");
    if (!twin.empty())
      fail("beside it lies \"" + twin +
           "\", which would be read in its place, since its voxels are scaled (scl_slope): move "
           "one of the two");
    header.unusual = real;
    if (real) {
      header.slope = slope;
      header.shift = shift;
    }
  }

  const double onDisk = sizeOfFile(fs::u8path(name));
  if (!file.compressed()) {
    compare(claimed, onDisk - offset, false, header.notes);
  } else {
    compare(claimed, onDisk, true, header.notes);
    std::vector<unsigned char> buffer(1 << 17);
    double present = static_cast<double>(got);
    for (size_t more = 1; more > 0 && present < offset + claimed;
         present += static_cast<double>(more))
      more = file.read(buffer.data(), buffer.size());
    if (present < offset + claimed)
      fail("it is truncated: " + bytes(present) + " can be unpacked of the " +
           bytes(offset + claimed) + " that its header claims");
  }
  return header;
}

// ---------------------------------------------------------------- heads of text

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

std::string trimmed(const std::string& text) {
  const size_t first = text.find_first_not_of(" \t\r"), last = text.find_last_not_of(" \t\r");
  return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

struct TextHead {
  std::map<std::string, std::string> fields;  // by lower-case name
  double end = 0;                             // where the data begin when they are in the same file

  std::string at(const std::string& name) const {
    const auto found = fields.find(name);
    return found == fields.end() ? "" : found->second;
  }
  std::vector<std::int64_t> numbers(const std::string& name) const {
    std::istringstream text(at(name));
    std::vector<std::int64_t> found;
    for (std::int64_t n = 0; text >> n;) found.push_back(n);
    return found;
  }
};

/// Lines "name<separator>value" until an empty one or until the name `last`.
TextHead readText(const std::string& name, char separator, const std::string& last) {
  std::ifstream file(fs::u8path(name), std::ios::binary);
  std::string text(longestTextHeader, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<size_t>(file.gcount()));
  TextHead head;
  for (size_t at = 0; at < text.size();) {
    size_t end = text.find('\n', at);
    if (end == std::string::npos) end = text.size();
    const std::string line = trimmed(text.substr(at, end - at));
    at = end + 1;
    head.end = static_cast<double>(std::min(at, text.size()));
    if (line.empty()) break;
    const size_t split = line.find(separator);
    if (line[0] == '#' || split == std::string::npos) continue;
    std::string value = line.substr(split + 1);
    if (!value.empty() && value[0] == '=') value.erase(0, 1);  // NRRD's own key:=value
    const std::string key = lower(trimmed(line.substr(0, split)));
    head.fields[key] = trimmed(value);
    if (key == last) break;
  }
  return head;
}

void compareWithData(VolumeHeader& header, const TextHead& head, const std::string& name,
                     const std::string& dataFile, double voxelBytes, bool compressed, bool text) {
  const bool inside = dataFile.empty();
  if (!inside && (dataFile.find('%') != std::string::npos || lower(dataFile).rfind("list", 0) == 0))
    fail("its voxels are spread over several files, which is not read: convert it to one file");
  const fs::path data =
      inside ? fs::u8path(name) : fs::u8path(name).parent_path() / fs::u8path(dataFile);
  double present = sizeOfFile(data);
  if (inside) present -= head.end;
  // A number as text takes two characters at least.
  compare(product(header.size) * (text ? 2 : voxelBytes), present, compressed, header.notes);
  if (text) header.notes.clear();
}

VolumeHeader readMeta(const std::string& name) {
  const TextHead head = readText(name, '=', "elementdatafile");
  VolumeHeader header;
  header.format = VolumeFormat::Meta;
  const auto dimensions = head.numbers("ndims");
  const auto size = head.numbers("dimsize");
  if (dimensions.size() != 1 || head.at("elementdatafile").empty())
    fail("it is no MetaImage file, or its header is broken");
  if (static_cast<std::int64_t>(size.size()) != dimensions[0])
    fail("its header is broken: NDims is " + std::to_string(dimensions[0]) + ", but DimSize has " +
         std::to_string(size.size()) + " numbers");
  header.size = checkedSize(size);
  const auto channels = head.numbers("elementnumberofchannels");
  if (!channels.empty() && channels[0] != 1)
    fail("it holds " + std::to_string(channels[0]) +
         " numbers per voxel: colours and vectors are no labels");
  static const std::map<std::string, double> types{
      {"met_uchar", 1},      {"met_char", 1},      {"met_ushort", 2}, {"met_short", 2},
      {"met_uint", 4},       {"met_int", 4},       {"met_ulong", 4},  {"met_long", 4},
      {"met_ulong_long", 8}, {"met_long_long", 8}, {"met_float", 4},  {"met_double", 8}};
  const auto type = types.find(lower(head.at("elementtype")));
  if (type == types.end())
    fail("its voxels are of the type \"" + head.at("elementtype") + "\", which is no label's");
  const std::string data = head.at("elementdatafile");
  const bool compressed = lower(head.at("compresseddata")) == "true";
  if (compressed) {  // ITK leaves out without a word what is not there
    const auto length = head.numbers("compresseddatasize");
    if (length.size() != 1)
      fail("its header lacks CompressedDataSize, without which its voxels cannot be read");
    if (lower(data) == "local" &&
        sizeOfFile(fs::u8path(name)) - head.end < static_cast<double>(length[0]))
      fail("it is truncated: its header claims " + bytes(static_cast<double>(length[0])) +
           " of compressed voxels");
  }
  compareWithData(header, head, name, lower(data) == "local" ? "" : data, type->second, compressed,
                  lower(head.at("binarydata")) == "false");
  return header;
}

/// NRRD knows C's names of a type, however long, and those with a number of bits; 0 for other ones.
double nrrdBytes(const std::string& type) {
  std::istringstream words(type);
  std::string name;
  for (std::string word; words >> word;)
    if (word != "signed" && word != "unsigned" && (word != "int" || name.empty())) name += word;
  if (name.size() > 2 && name.substr(name.size() - 2) == "_t") name.resize(name.size() - 2);
  if (name[0] == 'u') name.erase(0, 1);
  static const std::map<std::string, double> sizes{
      {"char", 1},  {"int8", 1},     {"short", 2}, {"int16", 2}, {"int", 4},
      {"int32", 4}, {"longlong", 8}, {"int64", 8}, {"float", 4}, {"double", 8}};
  const auto found = sizes.find(name);
  return found == sizes.end() ? 0 : found->second;
}

VolumeHeader readNrrd(const std::string& name) {
  TextHead head = readText(name, ':', "");
  VolumeHeader header;
  header.format = VolumeFormat::Nrrd;
  const auto dimensions = head.numbers("dimension");
  std::vector<std::int64_t> size = head.numbers("sizes");
  if (dimensions.size() != 1 || static_cast<std::int64_t>(size.size()) != dimensions[0])
    fail("its header is broken: the fields \"dimension\" and \"sizes\" do not agree");
  std::istringstream text(head.at("kinds"));
  std::vector<std::string> kinds;
  for (std::string kind; text >> kind;) kinds.push_back(lower(kind));
  // A list of volumes is phases, as 3D Slicer's sequences have it; its segmentations use the same
  // for overlapping labels.
  const auto isSpace = [](const std::string& kind) { return kind == "domain" || kind == "space"; };
  if (size.size() == 4 && kinds.size() == 4) {
    const bool first = !isSpace(kinds[0]), last = !first && !isSpace(kinds[3]);
    const std::string& kind = first ? kinds[0] : kinds[3];
    if ((first || last) && (kind != "list" || head.fields.count("segment0_id") != 0))
      fail(kind == "time" ? "its axis of the kind \"time\" is not read: write \"list\" instead "
                            "into its header (kinds)"
                          : "it holds several numbers per voxel, of the kind \"" + kind +
                                "\": overlapping segments, colours and vectors are no labels");
    if (first) std::rotate(size.begin(), size.begin() + 1, size.end());
    header.phasesFirst = (first || last) && size[3] > 1;  // ITK brings a list to the front
  }
  header.size = checkedSize(size);
  const double voxelBytes = nrrdBytes(lower(head.at("type")));
  if (voxelBytes == 0)
    fail("its voxels are of the type \"" + head.at("type") + "\", which is no label's");
  const std::string encoding = lower(head.at("encoding"));
  std::string data = head.at("data file");
  if (data.empty()) data = head.at("datafile");
  compareWithData(
      header, head, name, data, voxelBytes,
      encoding == "gzip" || encoding == "gz" || encoding == "bzip2" || encoding == "bz2",
      encoding == "ascii" || encoding == "text" || encoding == "txt" || encoding == "hex");
  return header;
}

bool endsWith(const std::string& text, const std::string& ending) {
  return text.size() >= ending.size() &&
         text.compare(text.size() - ending.size(), ending.size(), ending) == 0;
}

}  // namespace

VolumeHeader readVolumeHeader(const std::string& fileName) {
  std::error_code error;
  const fs::path path = fs::u8path(fileName);
  if (!fs::exists(path, error)) fail("there is no such file");
  if (!fs::is_regular_file(path, error)) fail("it is no file");
  if (!std::ifstream(path)) fail("it cannot be opened");
  const std::string name = lower(path.filename().u8string());
  VolumeHeader header;
  if (endsWith(name, ".nii") || endsWith(name, ".nii.gz"))
    header = readNifti(fileName);
  else if (endsWith(name, ".nrrd") || endsWith(name, ".nhdr"))
    header = readNrrd(fileName);
  else if (endsWith(name, ".mha") || endsWith(name, ".mhd"))
    header = readMeta(fileName);
  else
    fail(
        "its name ends in none of .nii, .nii.gz, .nrrd, .nhdr, .mha, .mhd, the formats that are "
        "read");
  header.voxels = static_cast<std::int64_t>(product(header.size));
  if (header.toRas && !header.toRas->allFinite())
    fail("its place in space is not finite: its affine matrix holds NaN or infinite numbers");
  return header;
}

std::vector<char> readNiftiVoxels(const std::string& fileName, const VolumeHeader& header) {
  GzipFile file(fileName);
  std::vector<unsigned char> skipped(static_cast<size_t>(header.voxelsBegin));
  const size_t size = bytesOf(header.type);
  std::vector<char> voxels(static_cast<size_t>(header.voxels) * size);
  file.read(skipped.data(), skipped.size());
  constexpr size_t chunk = 1 << 24;
  for (size_t at = 0; at < voxels.size();) {
    const size_t wanted = std::min(chunk, voxels.size() - at);
    if (file.read(reinterpret_cast<unsigned char*>(voxels.data()) + at, wanted) != wanted)
      fail("it is truncated");
    at += wanted;
  }
  if (header.swapped)
    for (auto voxel = voxels.begin(); voxel != voxels.end();
         voxel += static_cast<std::ptrdiff_t>(size))
      std::reverse(voxel, voxel + static_cast<std::ptrdiff_t>(size));
  return voxels;
}

}  // namespace sphere_propagation
