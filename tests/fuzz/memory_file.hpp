// Bytes behind a path, without a disk: for readers that open files by name.
#pragma once
#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <span>
#include <string>

namespace isopach::fuzz {

/// One file, overwritten by every input. Regular, so what is read is bytes of exactly its size.
class MemoryFile {
 public:
  MemoryFile() : file_(memfd_create("fuzz", 0)), path_("/proc/self/fd/" + std::to_string(file_)) {}
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { close(file_); }

  /// The path of a file that holds these bytes and nothing else.
  const std::string& with(std::span<const char> bytes) {
    if (ftruncate(file_, 0) != 0 || pwrite(file_, bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
      std::abort();
    return path_;
  }

 private:
  int file_;
  std::string path_;
};

}  // namespace isopach::fuzz
