// Fuzz target: any bytes as a LAS file, and the checks of a compressed one. What LASzip decodes is the target laz: here
// compressed files end where LASzip would begin.
#include "isopach/io/copc.hpp"
#include "isopach/io/las.hpp"
#include "isopach/io/laz.hpp"
#include "tests/fuzz/cloud_checks.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t format_at = 104;
  isopach::fuzz::ExactBytes copy(data, size);
  const std::span<char> bytes = copy.bytes();
  if (size > format_at) std::memcpy(bytes.data(), "LASF", 4);
  isopach::ReadOptions options;
  options.all_attributes = true;
  isopach::fuzz::only_errors([&] {
    const isopach::LasFile las = isopach::parse_las(bytes, "fuzz");
    if (las.compressed) const isopach::LazReader checked("fuzz", las);
    if (isopach::is_copc(las)) (void)isopach::copc_chunks(las, {0, 0, 1, 1});
  });
  if (size > format_at) bytes[format_at] = static_cast<char>(bytes[format_at] & 0x3F);
  isopach::fuzz::only_errors([&] { isopach::fuzz::require_consistent(isopach::read_las(bytes, "fuzz", options, {})); });
  return 0;
}
