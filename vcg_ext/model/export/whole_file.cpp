// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/model/export/whole_file.h"

#include <cerrno>
#include <fstream>
#include <system_error>

#include "vcg_ext/base/error.h"

namespace sphere_propagation {

namespace fs = std::filesystem;

void writeWhole(const fs::path& path, const std::string& content) {
  fs::path part = path;
  part += ".part";
  errno = 0;
  std::ofstream file(part, std::ios::binary | std::ios::trunc);
  file.write(content.data(), static_cast<std::streamsize>(content.size()));
  file.close();
  std::error_code error(errno, std::generic_category());
  if (file.good()) {
    fs::rename(part, path, error);
    if (!error) return;
  }
  std::error_code ignored;
  fs::remove(part, ignored);
  throw ExportError(Finding(Fault::NotWritten, path.u8string())
                        .saying(error ? error.message() : std::string("writing failed")));
}

}  // namespace sphere_propagation
