// Bytes in memory under a name that GDAL can open.
#pragma once
#include <span>
#include <string>

namespace isopach {

/// The file is there while this lives, which must be no longer than the bytes.
class GdalMemoryFile {
 public:
  explicit GdalMemoryFile(std::span<const char> bytes);
  ~GdalMemoryFile();
  GdalMemoryFile(const GdalMemoryFile&) = delete;
  GdalMemoryFile& operator=(const GdalMemoryFile&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace isopach
