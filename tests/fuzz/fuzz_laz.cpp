// Fuzz target: small valid LAZ files, one for each point format that LASzip packs in its own way, damaged inside their
// chunks: bytes changed, the end cut off, the counts of the header one more or less than the points.
#include <array>
#include <vector>

#include "isopach/io/input_file.hpp"
#include "isopach/io/las.hpp"
#include "isopach/io/laz.hpp"
#include "tests/fuzz/cloud_checks.hpp"
#include "tests/fuzz/memory_file.hpp"

namespace {

using namespace isopach;

constexpr std::array formats{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
constexpr std::size_t points = 24;

/// LAS 1.4 with numbers that are known, and differ from point to point.
std::string plain(int format) {
  constexpr std::size_t header = 375;
  const std::size_t length = las_record_length[static_cast<std::size_t>(format)];
  std::string bytes(header + points * length, '\0');
  char* const h = bytes.data();
  std::memcpy(h, "LASF", 4);
  h[24] = 1, h[25] = 4;
  put_le<std::uint16_t>(h + 94, header);
  put_le<std::uint32_t>(h + 96, header);
  h[104] = static_cast<char>(format);
  put_le(h + 105, static_cast<std::uint16_t>(length));
  if (format < 6) put_le<std::uint32_t>(h + 107, points), put_le<std::uint32_t>(h + 111, points);
  for (int axis = 0; axis < 3; ++axis) put_le(h + 131 + 8 * axis, 0.001);
  put_le<std::uint64_t>(h + 247, points), put_le<std::uint64_t>(h + 255, points);
  for (std::size_t i = 0; i < points; ++i) {
    char* const record = h + header + i * length;
    for (std::size_t k = 12; k < length; ++k) record[k] = static_cast<char>(i * k % 7);
    record[14] = 0x11;
    for (std::size_t axis = 0; axis < 3; ++axis)
      put_le(record + 4 * axis, static_cast<std::int32_t>((i * i * 37 + axis * 1000 * i) % 5000));
  }
  return bytes;
}

std::string packed(int format) {
  fuzz::MemoryFile in, out;
  const std::string bytes = plain(format), path = out.with({});
  compress_las(in.with({bytes.data(), bytes.size()}), path, points, {});
  InputFile file(path, {});
  return {file.bytes().begin(), file.bytes().end()};
}

void change_counts(fuzz::Input& in, std::string& laz) {
  const int by = static_cast<int>(in.below(3)) - 1;
  if (in.below(4) == 0)
    put_le(laz.data() + 247, get_le<std::uint64_t>(laz.data() + 247) + static_cast<std::uint64_t>(by));
  if (in.below(4) == 0)
    put_le(laz.data() + 107, get_le<std::uint32_t>(laz.data() + 107) + static_cast<std::uint32_t>(by));
}

void damage(fuzz::Input& in, std::string& laz) {
  change_counts(in, laz);
  const std::size_t begin = get_le<std::uint32_t>(laz.data() + 96), size = laz.size();
  for (std::size_t n = in.below(6); n > 0; --n) {
    const std::size_t high = in.byte(), at = begin + (256 * high + in.byte()) % (size - begin);
    laz[at] = static_cast<char>(laz[at] ^ in.byte());
  }
  if (in.below(8) == 7) laz.resize(size - in.byte() % (size - begin));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::vector<std::string> valid = [] {
    std::vector<std::string> all;
    for (const int format : formats) all.push_back(packed(format));
    return all;
  }();
  fuzz::Input in(data, size);
  std::string laz = valid[in.below(valid.size())];
  damage(in, laz);
  const fuzz::ExactBytes copy(laz.data(), laz.size());
  ReadOptions options;
  options.all_attributes = true;
  fuzz::only_errors([&] { fuzz::require_consistent(read_las(copy.bytes(), "fuzz", options, fuzz::one_thread())); });
  return 0;
}
