#include "cli/tile_files.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "isopach/base/error.hpp"
#include "isopach/tiles/part_bytes.hpp"

namespace isopach::cli {
namespace fs = std::filesystem;

MappedFile::MappedFile(const fs::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat about {};
  if (descriptor < 0 || ::fstat(descriptor, &about) != 0) {
    const int error = errno;
    if (descriptor >= 0) ::close(descriptor);
    throw InputError(fmt::format("{}: cannot be read ({})", path.string(), std::strerror(error)));
  }
  size_ = static_cast<std::size_t>(about.st_size);
  if (size_ > 0) data_ = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, descriptor, 0);
  const int error = errno;
  ::close(descriptor);
  if (data_ == MAP_FAILED)
    throw Error(ExitCode::internal, fmt::format("{}: cannot be mapped ({})", path.string(), std::strerror(error)));
}

MappedFile::~MappedFile() {
  if (data_ != nullptr) ::munmap(data_, size_);
}

Part read_part(const Job& job, std::size_t k) {
  const fs::path path = job.tile_file(k, "part");
  return part_of(MappedFile(path).bytes(), job.id, path.string());
}

std::shared_ptr<const CellPart> cells_in(const fs::path& path, const std::string& job, std::size_t first_node) {
  struct Held {
    MappedFile file;
    CellPart cells;
    Held(const fs::path& of, const std::string& id, std::size_t node)
        : file(of), cells(cells_of(file.bytes(), id, of.string(), node)) {}
  };
  const auto held = std::make_shared<const Held>(path, job, first_node);
  return {held, &held->cells};
}

void fail_to_fit(const fs::path& cells) {
  throw InputError(cells.string() + ": it does not fit its part: remove both, and run the tile again");
}

}  // namespace isopach::cli
