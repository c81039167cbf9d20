#include "isopach/io/output_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <functional>
#include <random>
#include <utility>

#include "isopach/base/error.hpp"
#include "isopach/io/write.hpp"

namespace isopach {
namespace fs = std::filesystem;

namespace {

constexpr std::string_view mark = ".isopach-", new_files = "/new/";

constexpr std::string_view plain_part = ".las";  ///< of an unfinished .laz: its points before they are compressed

/// Length of ".isopach-PID-RANDOM" at the beginning of a name; 0 where it begins otherwise.
std::size_t marked_length(std::string_view name) {
  if (name.substr(0, mark.size()) != mark) return 0;
  std::size_t at = mark.size();
  const auto skip = [&](auto&& wanted) {
    const std::size_t from = at;
    while (at < name.size() && wanted(static_cast<unsigned char>(name[at]))) ++at;
    return at > from;
  };
  if (!skip([](unsigned char c) { return std::isdigit(c) != 0; }) || at >= name.size() || name[at++] != '-') return 0;
  return skip([](unsigned char c) { return std::isxdigit(c) != 0; }) ? at : 0;
}

/// The file that an unfinished one was to become; empty if `name` is none of these.
std::string_view finished_name(std::string_view name) {
  const std::size_t length = marked_length(name);
  return length > 0 && length < name.size() && name[length] == '-' ? name.substr(length + 1) : std::string_view{};
}

struct Descriptor {
  int value = -1;
  Descriptor() = default;
  explicit Descriptor(int d) : value(d) {}
  ~Descriptor() {
    if (value >= 0) ::close(value);
  }
  Descriptor(Descriptor&& other) noexcept : value(std::exchange(other.value, -1)) {}
  Descriptor& operator=(Descriptor&&) = delete;
};

struct Unfinished {
  std::string path;
  Descriptor lock;  ///< held while this run writes the file
};

[[noreturn]] void refuse(const std::string& target, const std::string& folder, int error) {
  if (error == ENOENT || error == ENOTDIR)
    throw UsageError(fmt::format("{}: the folder {} does not exist: create it first", target, folder));
  if (error == EACCES || error == EPERM || error == EROFS)
    throw UsageError(fmt::format("{}: the folder {} may not be written to: choose another", target, folder));
  fail_to_write(target, std::strerror(error));
}

bool is_at(const std::string& path, int descriptor) {
  struct stat here {
  }, there{};
  return ::fstat(descriptor, &here) == 0 && ::stat(path.c_str(), &there) == 0 && here.st_ino == there.st_ino &&
         here.st_dev == there.st_dev;
}

// Creates an empty file beside the target. The name keeps the target's extension, by which some writers choose a
// format.
Unfinished create_unfinished(const fs::path& target) {
  const fs::path folder = target.has_parent_path() ? target.parent_path() : ".";
  for (;;) {
    std::string path = (folder / (unfinished_name() + "-" + target.filename().string())).string();
    Descriptor lock(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (lock.value < 0 && (errno == EEXIST || errno == EINTR)) continue;
    if (lock.value < 0) refuse(target.string(), folder.string(), errno);
    (void)::flock(lock.value, LOCK_EX | LOCK_NB);  // not every file system has locks; they only guard from sweeping
    if (is_at(path, lock.value)) return {std::move(path), std::move(lock)};  // else swept before it was locked
  }
}

bool is_dead(const fs::path& file) {
  const Descriptor descriptor(::open(file.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
  return descriptor.value >= 0 && ::flock(descriptor.value, LOCK_EX | LOCK_NB) == 0;
}

void remove_unfinished(const std::string& path) {
  std::error_code ignored;
  fs::remove(path + std::string(plain_part), ignored);
  fs::remove(path, ignored);
}

void put_in_place(const Unfinished& unfinished, const fs::path& final_path, const std::string& target) {
  put_on_disk(unfinished.path);
  std::error_code error;
  fs::rename(unfinished.path, final_path, error);
  if (error) fail_to_write(target, error.message());
}

}  // namespace

void fail_to_write(const std::string& path, const std::string& cause) {
  throw Error(ExitCode::internal,
              fmt::format("{}: cannot be written ({}): make room on the disk, or choose another folder", place_of(path),
                          cause));
}

OutputFile::OutputFile(std::string path, std::string name) : name_(name.empty() ? path : std::move(name)) {
  do {
    descriptor_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  } while (descriptor_ < 0 && errno == EINTR);
  if (descriptor_ < 0) fail_to_write(name_, std::strerror(errno));
}

OutputFile::~OutputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void OutputFile::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t done = ::write(descriptor_, bytes.data(), bytes.size());
    if (done < 0 && errno == EINTR) continue;
    if (done < 0) fail_to_write(name_, std::strerror(errno));
    bytes.remove_prefix(static_cast<std::size_t>(done));
  }
}

void OutputFile::close() {
  const int descriptor = std::exchange(descriptor_, -1);
  if (::close(descriptor) != 0) fail_to_write(name_, std::strerror(errno));
}

void write_text_atomically(const std::string& path, const std::string& text) {
  write_atomically(path, [&](const std::string& temporary) {
    OutputFile file(temporary);
    file.write(text);
    file.close();
  });
}

std::string unfinished_name() {
  std::random_device random;  // a name alone: no result depends on it
  return fmt::format("{}{}-{:08x}", mark, ::getpid(), random());
}

bool is_unfinished_folder(std::string_view name) { return !name.empty() && marked_length(name) == name.size(); }

std::string place_of(std::string text) {
  for (std::size_t at = text.find(mark); at != std::string::npos; at = text.find(mark, at)) {
    const std::string_view rest = std::string_view(text).substr(at);
    const std::size_t length = marked_length(rest);
    const std::string_view behind = rest.substr(length);
    if (length > 0 && behind.substr(0, new_files.size()) == new_files)
      text.erase(at, length + new_files.size());
    else if (length > 0)
      text.erase(at, length + (behind.starts_with('-') || behind.starts_with('/') ? 1 : 0));
    else
      at += mark.size();
  }
  return text;
}

void put_on_disk(const std::string& path) {
  const Descriptor descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (descriptor.value < 0) fail_to_write(path, std::strerror(errno));
  int result = 0;
  do {
    result = ::fsync(descriptor.value);
  } while (result != 0 && errno == EINTR);
  if (result != 0 && errno != EINVAL && errno != ENOTSUP && errno != EROFS) fail_to_write(path, std::strerror(errno));
}

void sweep_unfinished_files(const std::string& folder, std::string_view name) {
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const std::string found = entry->path().filename().string();
    std::string_view finished = finished_name(found);
    const bool is_part = finished.size() > plain_part.size() && finished.ends_with(".laz.las");
    if (is_part) finished.remove_suffix(plain_part.size());
    if (finished.empty() || (!name.empty() && finished != name)) continue;
    fs::path lock = entry->path();  // that of a part is on the file it is a part of
    if (is_part) lock.replace_extension();
    std::error_code ignored;
    if (fs::is_regular_file(entry->symlink_status(ignored)) &&
        (is_dead(lock) || (is_part && !fs::exists(lock, ignored))))
      remove_unfinished(entry->path().string());
  }
}

void write_atomically(const std::string& target, const std::function<void(const std::string& temporary)>& write) {
  std::error_code error;
  const fs::file_status status = fs::status(target, error);
  if (fs::is_directory(status)) throw UsageError(fmt::format("{}: is a folder: name a file", place_of(target)));
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    write(target);  // a pipe or device: there is nothing to rename, and replacing it would be wrong
    return;
  }
  const fs::path final_path = fs::is_symlink(target, error) ? fs::weakly_canonical(target, error) : fs::path(target);
  const fs::path folder = final_path.has_parent_path() ? final_path.parent_path() : ".";
  if (place_of(target) == target) sweep_unfinished_files(folder.string(), final_path.filename().string());
  const Unfinished unfinished = create_unfinished(final_path);
  try {
    write(unfinished.path);
    put_in_place(unfinished, final_path, target);
  } catch (const Error& failure) {
    remove_unfinished(unfinished.path);
    const std::string message = place_of(failure.what());
    if (message == failure.what()) throw;
    throw Error(failure.code(), message);
  } catch (...) {
    remove_unfinished(unfinished.path);
    throw;
  }
}

}  // namespace isopach
