#include "cli/passing_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <string_view>

#include "isopach/base/error.hpp"
#include "isopach/io/output_file.hpp"

namespace isopach::cli {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view ending = "-passing";

bool is_ours(std::string_view name) {
  return name.ends_with(ending) && is_unfinished_folder(name.substr(0, name.size() - ending.size()));
}

int open_folder(const fs::path& path) { return ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC); }

bool is_there(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(path, error);
}

fs::path temporary_folder() {
  std::error_code error;
  const fs::path folder = fs::temp_directory_path(error);
  if (error) throw UsageError("TMPDIR: it names no folder that is there: name one on a disk with room");
  return folder;
}

/// Folders of other users are left alone by the system.
void sweep(const fs::path& folder) {
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (!is_ours(entry->path().filename().string())) continue;
    const int lock = open_folder(entry->path());
    if (lock < 0) continue;
    std::error_code ignored;
    if (::flock(lock, LOCK_EX | LOCK_NB) == 0) fs::remove_all(entry->path(), ignored);
    ::close(lock);
  }
}

}  // namespace

PassingFolder::PassingFolder() {
  const fs::path folder = temporary_folder();
  sweep(folder);
  while (lock_ < 0) {
    path_ = folder / (unfinished_name() + std::string(ending));
    if (::mkdir(path_.c_str(), 0700) != 0) {
      if (errno == EEXIST) continue;
      fail_to_write(path_.string(), std::strerror(errno));
    }
    const int lock = open_folder(path_);
    if (lock < 0 && errno != ENOENT) fail_to_write(path_.string(), std::strerror(errno));
    // Not every file system has locks; they only guard from sweeping, which may have come first.
    const bool is_swept =
        lock < 0 || (::flock(lock, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) || !is_there(path_);
    if (!is_swept)
      lock_ = lock;
    else if (lock >= 0)
      ::close(lock);
  }
}

PassingFolder::~PassingFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  ::close(lock_);
}

}  // namespace isopach::cli
