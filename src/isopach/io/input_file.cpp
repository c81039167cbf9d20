#include "isopach/io/input_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <new>

#include "isopach/base/error.hpp"
#include "isopach/base/memory.hpp"

namespace isopach {
namespace {

constexpr std::uint64_t head_size = 4096, step = std::uint64_t{1} << 20;
constexpr std::uint64_t at_once = std::uint64_t{64} << 20;  // between two looks whether the user wants to stop
constexpr int patience_ms = 100;

std::uint64_t limit = 0;  // of the process: see set_max_input

[[noreturn]] void fail_to_open(const std::string& path, int error) {
  if (error == ENOENT || error == ENOTDIR) throw InputError(fmt::format("{}: no such file: check the path", path));
  if (error == EACCES) throw InputError(fmt::format("{}: may not be read: check its permissions", path));
  throw InputError(fmt::format("{}: cannot be opened ({}): check the path", path, std::strerror(error)));
}

}  // namespace

void set_max_input(std::uint64_t bytes) { limit = bytes; }

std::uint64_t max_input() { return limit > 0 ? limit : usable_memory() / 2; }

void InputFile::Release::operator()(char* p) const { std::free(p); }

// A FIFO is opened without waiting for its writer: the wait is in read_some, where the user can end it.
InputFile::InputFile(const std::string& path, const Context& context) : path_(path), context_(context) {
  do {
    context.check();
    descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  } while (descriptor_ < 0 && errno == EINTR);
  if (descriptor_ < 0) fail_to_open(path, errno);
  try {
    struct stat info {};
    if (::fstat(descriptor_, &info) != 0) fail_to_open(path, errno);
    if (S_ISDIR(info.st_mode)) throw InputError(fmt::format("{}: is a folder: name a file in it", path));
    size_ = static_cast<std::uint64_t>(info.st_size);
    regular_ = S_ISREG(info.st_mode) && size_ > 0;  // files of the kernel say 0 and hold something
    changed_s_ = info.st_mtim.tv_sec, changed_ns_ = info.st_mtim.tv_nsec;
    if (regular_)
      read_regular(std::min(size_, head_size));
    else
      read_stream();
    if (used_ == 0) throw InputError(fmt::format("{}: the file is empty: it holds no points", path));
  } catch (...) {
    ::close(descriptor_);
    throw;
  }
}

InputFile::~InputFile() { ::close(descriptor_); }

std::span<const char> InputFile::head() const { return {data_.get(), std::min(used_, head_size)}; }

std::span<const char> InputFile::bytes() {
  if (regular_ && used_ < size_) {
    if (size_ > max_input()) refuse_larger();
    read_regular(size_);
  }
  return {data_.get(), used_};
}

void InputFile::fail_to_read(int error) const {
  throw InputError(fmt::format("{}: cannot be read ({}): check the file", path_, std::strerror(error)));
}

void InputFile::fail_cut(std::uint64_t end) const {
  throw InputError(
      fmt::format("{}: was cut while it was read, from {} bytes to {}: wait until it is whole", path_, size_, end));
}

void InputFile::check_unchanged() const {
  struct stat now {};
  if (::fstat(descriptor_, &now) != 0) fail_to_read(errno);
  if (static_cast<std::uint64_t>(now.st_size) != size_ || now.st_mtim.tv_sec != changed_s_ ||
      now.st_mtim.tv_nsec != changed_ns_)
    throw InputError(fmt::format("{}: was changed while it was read: wait until it is whole", path_));
}

void InputFile::read_at(std::uint64_t at, std::size_t length, char* into) const {
  for (std::size_t done = 0; done < length;) {
    context_.check();
    const std::size_t most = std::min<std::size_t>(length - done, at_once);
    const ssize_t got = ::pread(descriptor_, into + done, most, static_cast<off_t>(at + done));
    if (got < 0 && errno != EINTR) fail_to_read(errno);
    if (got == 0) fail_cut(at + done);
    if (got > 0) done += static_cast<std::size_t>(got);
  }
  check_unchanged();
}

void InputFile::refuse_larger() const {
  throw InputError(
      fmt::format("{}: more than {}, the limit of @max-input (by default half of the memory): thin or crop it, or "
                  "raise the limit",
                  path_, bytes_in_words(max_input())));
}

void InputFile::grow(std::uint64_t size) {
  if (size <= room_) return;
  char* const larger = static_cast<char*>(std::realloc(data_.get(), size));
  if (larger == nullptr) throw std::bad_alloc();
  (void)data_.release();
  data_.reset(larger);
  room_ = size;
}

// 0 at the end. Whoever waits for a writer, or for its next bytes, can stop waiting.
std::size_t InputFile::read_some(std::uint64_t most) {
  for (;;) {
    context_.check();
    pollfd wait{descriptor_, POLLIN, 0};
    const int ready = regular_ ? 1 : ::poll(&wait, 1, patience_ms);
    if (ready == 0 || (ready < 0 && errno == EINTR)) continue;
    const ssize_t got = ::read(descriptor_, data_.get() + used_, most);
    if (got >= 0) return static_cast<std::size_t>(got);
    if (errno != EINTR && errno != EAGAIN) fail_to_read(errno);
  }
}

void InputFile::read_regular(std::uint64_t end) {
  grow(end);
  while (used_ < end) {
    const std::size_t got = read_some(std::min(end - used_, at_once));
    if (got == 0) fail_cut(used_);
    used_ += got;
  }
  check_unchanged();
}

void InputFile::read_stream() {
  const std::uint64_t most = max_input();
  for (;;) {
    if (room_ < used_ + step) grow(std::max(used_ + step, std::min(2 * room_, most + step)));
    const std::size_t got = read_some(std::min(room_ - used_, at_once));
    if (got == 0) return;
    used_ += got;
    if (used_ > most) refuse_larger();
  }
}

}  // namespace isopach
