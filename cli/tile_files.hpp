// What tiles left, read again by those who join them.
#pragma once
#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "cli/tile_job.hpp"
#include "isopach/measure/parted_cells.hpp"
#include "isopach/tiles/part.hpp"

namespace isopach::cli {

/// The bytes of a file, mapped: what has been looked at can go.
class MappedFile {
 public:
  explicit MappedFile(const std::filesystem::path& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  [[nodiscard]] std::span<const char> bytes() const { return {static_cast<const char*>(data_), size_}; }

 private:
  void* data_ = nullptr;
  std::size_t size_ = 0;
};

/// JOB/tiles/K.part. InputError as part_of.
[[nodiscard]] Part read_part(const Job& job, std::size_t k);

/// Cells of a file, which is mapped as long as they are looked at. InputError as cells_of.
[[nodiscard]] std::shared_ptr<const CellPart> cells_in(const std::filesystem::path& path, const std::string& job,
                                                       std::size_t first_node);

/// InputError: cells and part are not of one run.
[[noreturn]] void fail_to_fit(const std::filesystem::path& cells);

}  // namespace isopach::cli
