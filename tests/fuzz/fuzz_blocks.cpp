// Fuzz target: any bytes as a file of points, read at once and a block at a time: the same points, or both are refused.
// Compressed points are the target laz, rasters the target raster.
#include <cstring>

#include "isopach/io/point_blocks.hpp"
#include "isopach/io/raster.hpp"
#include "tests/fuzz/cloud_checks.hpp"
#include "tests/fuzz/memory_file.hpp"

namespace {

using namespace isopach;

bool same(const void* a, const void* b, std::size_t bytes) { return bytes == 0 || std::memcmp(a, b, bytes) == 0; }

// The blocks, which follow one another in `whole`.
class Follower {
 public:
  explicit Follower(const Cloud& whole) : whole_(whole) {}
  void take(const Cloud& block) {
    fuzz::require_consistent(block);
    fuzz::require(block.points.size() <= whole_.points.size() - at_, "no more points than at once");
    fuzz::require(same(block.points.data(), whole_.points.data() + at_, block.points.size() * sizeof(Point3)),
                  "the points are those read at once");
    fuzz::require(block.attributes.size() == whole_.attributes.size(), "the attributes are those read at once");
    for (std::size_t k = 0; k < block.attributes.size(); ++k)
      fuzz::require(same(block.attributes[k].values.data(), whole_.attributes[k].values.data() + at_,
                         block.points.size() * sizeof(double)),
                    "the values are those read at once");
    at_ += block.points.size();
  }
  [[nodiscard]] bool is_done() const { return at_ == whole_.points.size(); }

 private:
  const Cloud& whole_;
  std::size_t at_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t format_at = 104, most = 3;
  static fuzz::MemoryFile file;
  fuzz::ExactBytes copy(data, size);
  const std::span<char> bytes = copy.bytes();
  if (is_raster({bytes.data(), size})) return 0;
  if (size > format_at && std::memcmp(bytes.data(), "LASF", 4) == 0)
    bytes[format_at] = static_cast<char>(bytes[format_at] & 0x3F);
  const std::string& path = file.with(bytes);
  ReadOptions options;
  options.all_attributes = true;
  Cloud whole;
  bool is_read = false;
  fuzz::only_errors([&] {
    whole = read_cloud(path, options, fuzz::one_thread());
    is_read = true;
  });
  bool is_read_in_blocks = false;
  Follower follower(whole);
  fuzz::only_errors([&] {
    (void)summarise(path, options, fuzz::one_thread());
    const auto take = [&](const Cloud& block) {
      if (is_read) follower.take(block);
    };
    const Cloud rest = for_each_block(path, options, fuzz::one_thread(), take, most);
    if (is_read)
      fuzz::require(rest.notes == whole.notes && rest.unit == whole.unit && rest.crs == whole.crs, "notes, unit, CRS");
    is_read_in_blocks = true;
  });
  fuzz::require(is_read == is_read_in_blocks, "a file is read in blocks if it is at once");
  fuzz::require(!is_read || follower.is_done(), "all points are in blocks");
  return 0;
}
