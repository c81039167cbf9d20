// A folder for the time of a run, in that for temporary files.
#pragma once
#include <filesystem>

namespace isopach::cli {

/// New and empty; removed with all in it at the end, however that comes. What a run that was killed left is removed by
/// the next run that makes one: a run that lives holds a lock on its own. Throws as fail_to_write. Test:
/// tests/cli/tile_killed_test.py.
class PassingFolder {
 public:
  PassingFolder();
  ~PassingFolder();
  PassingFolder(const PassingFolder&) = delete;
  PassingFolder& operator=(const PassingFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  int lock_ = -1;
};

}  // namespace isopach::cli
