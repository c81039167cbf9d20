// MappedFile: the bytes of a file, mapped into memory read-only. A pipe or device, which cannot be mapped, is read
// whole.
#pragma once
#include <span>
#include <string>
#include <vector>

namespace isopach {

class MappedFile {
 public:
  /// Throws InputError, one line, if there is no such file, it is a folder, may not be read, or is empty.
  explicit MappedFile(const std::string& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  [[nodiscard]] std::span<const char> bytes() const { return bytes_; }

 private:
  void read_stream(int descriptor, const std::string& path);

  std::span<const char> bytes_;
  void* mapping_ = nullptr;
  std::vector<char> copy_;  // only for what cannot be mapped
};

}  // namespace isopach
