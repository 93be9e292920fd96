// SPDX-License-Identifier: GPL-3.0-only
// NIfTI-1, NIfTI-2 and Analyze 7.5, whole: one reader for all of their files, since ITK's knows no
// shears, no NIfTI-2, no compressed .nii, takes NaN for 0, scales by an intercept without a slope,
// and prefers the qform.
//
// R. W. Cox et al., A (sort of) new image data format standard: NIfTI-1, 2004; NIfTI-2 Data Format,
// nifti.nimh.nih.gov. Mayo Clinic, ANALYZE 7.5 file format.

#include <zlib.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <memory>

#include "filter_label_volume/header_checks.h"

namespace sphere_propagation {
namespace {

namespace fs = std::filesystem;

constexpr size_t firstLength = 348, secondLength = 540;  // of the headers
constexpr double sizesDiffer = 0.02;                     // of voxels, as a logarithm
constexpr size_t extensionLength = 4;                    // behind them in single files, at least

/// Reads numbers of a header, whichever way round their bytes are.
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
    if (!file_) refuse(volume_messages::notOpened);
    gzbuffer(file_.get(), 1 << 17);
  }
  size_t read(unsigned char* to, size_t count) {
    const int got = gzread(file_.get(), to, static_cast<unsigned>(count));
    int error = Z_OK;
    gzerror(file_.get(), &error);
    if (error == Z_DATA_ERROR) refuse(volume_messages::packedDamaged);
    return got < 0 ? 0 : static_cast<size_t>(got);
  }
  bool compressed() { return gzdirect(file_.get()) == 0; }

 private:
  std::unique_ptr<gzFile_s, int (*)(gzFile)> file_;
};

enum class Version { First, Second, Analyze };

/// The header as it stands in the file.
struct RawHeader {
  std::array<unsigned char, secondLength> bytes{};
  Version version = Version::First;
  bool swapped = false;
  bool inPair = false;  ///< its magic says that the voxels are in another file

  Fields fields() const { return {bytes.data(), swapped}; }
  bool second() const { return version == Version::Second; }
  /// A number that is a float in the first version and a double in the second.
  double real(size_t one, size_t two, size_t index = 0) const {
    return second() ? fields().get<double>(two + 8 * index)
                    : static_cast<double>(fields().get<float>(one + 4 * index));
  }
};

RawHeader readRawHeader(const std::string& name) {
  RawHeader raw;
  const size_t got = GzipFile(name).read(raw.bytes.data(), raw.bytes.size());
  const auto isLength = [](std::int32_t n) {
    return n == static_cast<std::int32_t>(firstLength) ||
           n == static_cast<std::int32_t>(secondLength);
  };
  raw.swapped = !isLength(raw.fields().get<std::int32_t>(0));
  const auto length = raw.fields().get<std::int32_t>(0);
  const bool second = length == static_cast<std::int32_t>(secondLength);
  if (got < (second ? secondLength : firstLength)) refuse(volume_messages::endsInHeader);
  if (!isLength(length)) refuse(volume_messages::noNifti);
  const std::string magic(reinterpret_cast<const char*>(raw.bytes.data()) + (second ? 4 : 344), 3);
  raw.inPair = magic == "ni1" || magic == "ni2";
  if (second)
    raw.version = Version::Second;
  else if (!raw.inPair && magic != "n+1")
    raw.version = Version::Analyze;
  return raw;
}

VoxelType typeOf(int code, Version version) {
  if (version == Version::Analyze) {  // SPM's additions
    if (code == 130) return VoxelType::Int8;
    if (code == 132) return VoxelType::Uint16;
    if (code == 136) return VoxelType::Uint32;
  }
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
      refuse(volume_messages::singleBits);
    default:
      refuse(volume_messages::noNumbers, code);
  }
}

/// Whether the fifth axis holds the numbers of one voxel: vectors, matrices, colours, points.
bool isVector(const RawHeader& raw) {
  if (raw.version == Version::Analyze) return false;
  const int intent =
      raw.second() ? raw.fields().get<std::int32_t>(504) : raw.fields().get<std::int16_t>(68);
  return (intent >= 1004 && intent <= 1010) || (intent >= 2003 && intent <= 2004);
}

void readSize(VolumeHeader& header, const RawHeader& raw) {
  const Fields f = raw.fields();
  const auto entry = [&](size_t i) -> std::int64_t {
    return raw.second() ? f.get<std::int64_t>(16 + 8 * i) : f.get<std::int16_t>(40 + 2 * i);
  };
  const std::int64_t dimensions = entry(0);
  if (dimensions < 1 || dimensions > 7) refuse(volume_messages::brokenDimensions, dimensions);
  std::vector<std::int64_t> axes;
  for (size_t i = 1; i <= static_cast<size_t>(dimensions); ++i)
    axes.push_back(i > 3 && entry(i) == 0 ? 1 : entry(i));  // what is not used
  setSize(header, axes);
  if (axes.size() > 4 && axes[4] > 1 && isVector(raw))
    refuse(volume_messages::severalNumbers, axes[4]);
}

/// How much a unit of the header is in millimetres.
double unitOf(const RawHeader& raw) {
  if (raw.version == Version::Analyze) return 1;
  const int unit =
      (raw.second() ? raw.fields().get<std::int32_t>(500) : raw.fields().get<unsigned char>(123)) &
      7;
  return unit == 1 ? 1000 : unit == 3 ? 0.001 : 1;
}

/// Method 3 of the format.
Eigen::Matrix4d sformMatrix(const RawHeader& raw) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  for (size_t i = 0; i < 12; ++i)
    matrix(static_cast<Eigen::Index>(i / 4), static_cast<Eigen::Index>(i % 4)) =
        raw.real(280, 400, i);
  return matrix;
}

/// Method 2, and without a place in space method 1.
Eigen::Matrix4d qformMatrix(const RawHeader& raw, bool placed) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  if (placed) {
    const double b = raw.real(256, 352, 0), c = raw.real(256, 352, 1), d = raw.real(256, 352, 2);
    const double rest = 1 - b * b - c * c - d * d;
    const Eigen::Quaterniond q(std::sqrt(std::max(rest, 0.0)), b, c, d);
    matrix.topLeftCorner<3, 3>() = q.normalized().toRotationMatrix();
    if (raw.real(76, 104) < 0) matrix.col(2) *= -1;
    for (size_t i = 0; i < 3; ++i) matrix(static_cast<Eigen::Index>(i), 3) = raw.real(268, 376, i);
  }
  for (size_t i = 0; i < 3; ++i)
    matrix.col(static_cast<Eigen::Index>(i)) *= std::fabs(raw.real(76, 104, i + 1));
  return matrix;
}

/// What there is to say where the two say different things: other programs believe the other one.
void compareForms(const Eigen::Matrix4d& sform, const Eigen::Matrix4d& qform,
                  VolumeHeader& header) {
  const double s = sform.topLeftCorner<3, 3>().determinant(),
               q = qform.topLeftCorner<3, 3>().determinant();
  if (!std::isfinite(s * q) || s == 0 || q == 0) return;
  if (s * q < 0) {
    header.remarks.push_back(host::remarkOn("", volume_messages::formsMirror));
  } else if (std::fabs(std::log(s / q)) > sizesDiffer) {
    header.remarks.push_back(
        host::remarkOn("", volume_messages::formsDifferInSize, std::fabs(s), std::fabs(q)));
  } else {
    double apart = 0;  // of corners
    for (int corner = 0; corner < 8; ++corner) {
      Eigen::Vector4d voxel(0, 0, 0, 1);
      for (size_t i = 0; i < 3; ++i)
        if ((corner >> i & 1) != 0)
          voxel[static_cast<Eigen::Index>(i)] = static_cast<double>(header.size[i] - 1);
      apart = std::max(apart, ((sform - qform) * voxel).norm());
    }
    if (apart > std::cbrt(std::fabs(s)))
      header.remarks.push_back(host::remarkOn("", volume_messages::formsDiffer, apart));
  }
}

Eigen::Matrix4d niftiMatrix(const RawHeader& raw, VolumeHeader& header) {
  const Fields f = raw.fields();
  const int qform = raw.second() ? f.get<std::int32_t>(344) : f.get<std::int16_t>(252);
  const int sform = raw.second() ? f.get<std::int32_t>(348) : f.get<std::int16_t>(254);
  Eigen::Matrix4d byQuaternion = qformMatrix(raw, qform > 0);
  byQuaternion.topRows<3>() *= unitOf(raw);
  if (sform <= 0) {
    if (qform <= 0) header.remarks.push_back(host::remarkOn("", volume_messages::noPlaceRas));
    return byQuaternion;
  }
  Eigen::Matrix4d matrix = sformMatrix(raw);
  matrix.topRows<3>() *= unitOf(raw);
  if (qform > 0) compareForms(matrix, byQuaternion, header);
  return matrix;
}

/// As SPM has it: x to the left, and the origin in SPM's field, else in the middle of the volume.
Eigen::Matrix4d analyzeMatrix(const RawHeader& raw, const VolumeHeader& header) {
  Vector3 origin, middle;
  bool inside = true, any = false;
  for (size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    const int voxel = raw.fields().get<std::int16_t>(253 + 2 * i);  // from 1 on
    const auto n = static_cast<int>(header.size[i]);
    origin[axis] = voxel - 1;
    middle[axis] = (n - 1) / 2.0;
    any = any || voxel != 0;
    inside = inside && voxel > -n && voxel < 2 * n;
  }
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  for (size_t i = 0; i < 3; ++i)
    matrix.col(static_cast<Eigen::Index>(i)) *= std::fabs(raw.real(76, 104, i + 1));
  matrix.col(0) *= -1;
  matrix.col(3).head<3>() = -matrix.topLeftCorner<3, 3>() * (any && inside ? origin : middle);
  return matrix;
}

/// Whether a name ends so, whatever its case, before a ".gz" that may follow.
bool hasEnding(const fs::path& path, const std::string& ending) {
  const bool packed = lowerCase(path.extension().u8string()) == ".gz";
  return lowerCase((packed ? path.stem() : path).extension().u8string()) == ending;
}

/// The file with the other ending that lies beside one of a pair; throws VolumeError where there is
/// none.
std::string partnerOf(const fs::path& path, const std::string& ending) {
  const bool packed = lowerCase(path.extension().u8string()) == ".gz";
  const fs::path stem = packed ? path.stem().stem() : path.stem();
  std::string upper = ending;
  std::transform(upper.begin(), upper.end(), upper.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  std::error_code error;
  for (const std::string& end : {ending, ending + ".gz", upper, upper + ".gz", upper + ".GZ"}) {
    fs::path partner = path.parent_path() / stem;
    partner += end;
    if (fs::is_regular_file(partner, error)) return partner.u8string();
  }
  refuse(volume_messages::noPartner, stem.u8string() + ending);
}

/// The files of the header and of the voxels, the same one in single files.
struct Files {
  std::string header, voxels;
};

Files filesOf(const std::string& name) {
  const fs::path path = fs::u8path(name);
  if (hasEnding(path, ".hdr")) return {name, partnerOf(path, ".img")};
  if (!hasEnding(path, ".img")) return {name, name};
  // Some programs write whole NIfTI files of this ending.
  unsigned char start[firstLength]{};
  if (GzipFile(name).read(start, firstLength) == firstLength &&
      (std::memcmp(start + 344, "n+1", 4) == 0 || std::memcmp(start + 4, "n+2", 4) == 0))
    return {name, name};
  return {partnerOf(path, ".hdr"), name};
}

}  // namespace

VolumeHeader readNiftiHeader(const std::string& name) {
  const Files files = filesOf(name);
  const bool single = files.header == files.voxels;
  RawHeader raw = readRawHeader(files.header);
  // A .nii without the magic number is read as what its name says.
  if (raw.version == Version::Analyze && single) raw.version = Version::First;
  VolumeHeader header;
  header.format = VolumeFormat::Nifti;
  header.voxelFile = files.voxels;
  header.swapped = raw.swapped;
  readSize(header, raw);
  header.type = typeOf(raw.fields().get<std::int16_t>(raw.second() ? 12 : 70), raw.version);
  if (raw.version == Version::Analyze) {
    header.toRas = analyzeMatrix(raw, header);
    header.remarks.push_back(host::remarkOn("", volume_messages::analyzeSides));
  } else {
    header.toRas = niftiMatrix(raw, header);
  }
  // Scaled only by a slope that is a number other than 0; what is no number shifts nothing.
  const double slope = raw.real(112, 176), shift = raw.real(116, 184);
  if (std::isfinite(slope) && slope != 0) {
    header.slope = slope;
    header.shift = std::isfinite(shift) ? shift : 0;
  }

  double begin = raw.second() ? static_cast<double>(raw.fields().get<std::int64_t>(168))
                              : static_cast<double>(raw.fields().get<float>(108));
  if (!(begin >= 0 && begin < 1e9)) refuse(volume_messages::brokenBegin, begin);
  if (single)  // 0 stands for the least that is possible
    begin = std::max(begin, static_cast<double>((raw.second() ? secondLength : firstLength) +
                                                (begin == 0 ? extensionLength : 0)));
  header.voxelsBegin = static_cast<std::int64_t>(begin);
  const double claimed =
      static_cast<double>(header.voxels()) * static_cast<double>(bytesOf(header.type));
  const double onDisk = sizeOfFile(fs::u8path(files.voxels));
  GzipFile voxels(files.voxels);
  unsigned char byte = 0;
  voxels.read(&byte, 1);
  const bool packed = voxels.compressed();
  compareWithFile(header, claimed, packed ? onDisk : onDisk - begin, packed);
  return header;
}

std::vector<char> readNiftiVoxels(const VolumeHeader& header) {
  GzipFile file(header.voxelFile);
  constexpr size_t chunk = 1 << 24;
  const auto begin = static_cast<size_t>(header.voxelsBegin);
  const size_t size = bytesOf(header.type), wanted = static_cast<size_t>(header.voxels()) * size;
  std::vector<char> voxels;
  const auto truncated = [&](size_t got) {
    if (file.compressed())
      refuse(volume_messages::truncatedPacked, bytesInWords(static_cast<double>(got)),
             bytesInWords(static_cast<double>(begin + wanted)));
    refuse(volume_messages::claimsMore, bytesInWords(static_cast<double>(wanted)),
           bytesInWords(static_cast<double>(voxels.size())));
  };
  std::vector<unsigned char> skipped(std::min(begin, chunk));
  for (size_t at = 0; at < begin;) {
    const size_t got = file.read(skipped.data(), std::min(begin - at, chunk));
    if (got == 0) truncated(at);
    at += got;
  }
  // Memory is asked for as the file brings what it claims.
  while (voxels.size() < wanted) {
    const size_t at = voxels.size(), more = std::min(wanted - at, std::max(chunk, at));
    voxels.resize(at + more);
    size_t got = 0;
    for (size_t part = 1; part > 0 && got < more; got += part)
      part = file.read(reinterpret_cast<unsigned char*>(voxels.data()) + at + got,
                       std::min(more - got, chunk));
    if (got < more) {
      voxels.resize(at + got);
      truncated(begin + at + got);
    }
  }
  if (header.swapped)
    for (auto voxel = voxels.begin(); voxel != voxels.end();
         voxel += static_cast<std::ptrdiff_t>(size))
      std::reverse(voxel, voxel + static_cast<std::ptrdiff_t>(size));
  return voxels;
}

}  // namespace sphere_propagation
