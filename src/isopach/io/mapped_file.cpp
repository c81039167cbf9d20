#include "isopach/io/mapped_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "isopach/base/error.hpp"

namespace isopach {
namespace {

struct Descriptor {
  int value;
  ~Descriptor() {
    if (value >= 0) ::close(value);
  }
};

[[noreturn]] void fail_to_open(const std::string& path, int error) {
  if (error == ENOENT || error == ENOTDIR) throw InputError(fmt::format("{}: no such file: check the path", path));
  if (error == EACCES) throw InputError(fmt::format("{}: may not be read: check its permissions", path));
  throw InputError(fmt::format("{}: cannot be opened ({}): check the path", path, std::strerror(error)));
}

}  // namespace

MappedFile::MappedFile(const std::string& path) {
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  if (file.value < 0) fail_to_open(path, errno);
  struct stat info {};
  if (::fstat(file.value, &info) != 0) fail_to_open(path, errno);
  if (S_ISDIR(info.st_mode)) throw InputError(fmt::format("{}: is a folder: name a file in it", path));
  if (!S_ISREG(info.st_mode)) {
    read_stream(file.value, path);
  } else if (info.st_size > 0) {
    const auto size = static_cast<std::size_t>(info.st_size);
    void* const mapping = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.value, 0);
    if (mapping == MAP_FAILED) fail_to_open(path, errno);
    mapping_ = mapping;
    bytes_ = {static_cast<const char*>(mapping), size};
  }
  if (bytes_.empty()) throw InputError(fmt::format("{}: the file is empty: it holds no points", path));
}

MappedFile::~MappedFile() {
  if (mapping_ != nullptr) ::munmap(mapping_, bytes_.size());
}

void MappedFile::read_stream(int descriptor, const std::string& path) {
  constexpr std::size_t step = std::size_t{1} << 20;
  std::size_t used = 0;
  for (;;) {
    if (copy_.size() < used + step) copy_.resize(copy_.size() * 2 + step);
    const ssize_t got = ::read(descriptor, copy_.data() + used, step);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw InputError(fmt::format("{}: cannot be read ({}): check the file", path, std::strerror(errno)));
    if (got == 0) break;
    used += static_cast<std::size_t>(got);
  }
  bytes_ = {copy_.data(), used};
}

}  // namespace isopach
