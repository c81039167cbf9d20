// libFuzzer target: any bytes as a LAS file, and the checks of a compressed one. LASzip itself is left out: it does not
// check the codes it decodes, so it ends the program on some damaged points, and nothing here could mend it. The bytes
// stay in memory, behind a path, because readers of LAS open files by name.
#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "isopach/base/error.hpp"
#include "isopach/io/las.hpp"
#include "isopach/io/laz.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t format_at = 104;
  static const int file = memfd_create("fuzz", 0);
  static const std::string path = "/proc/self/fd/" + std::to_string(file);
  std::string bytes(reinterpret_cast<const char*>(data), size);
  if (size > format_at) bytes.replace(0, 4, "LASF");
  isopach::ReadOptions options;
  options.all_attributes = true;
  try {
    const isopach::LasFile las = isopach::parse_las(bytes, path);
    if (las.compressed) const isopach::LazReader checked(path, las);
  } catch (const isopach::Error&) {  // a reason is as good as points
  }
  if (size > format_at) bytes[format_at] = static_cast<char>(bytes[format_at] & 0x3F);
  if (ftruncate(file, 0) != 0 || pwrite(file, bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    abort();
  try {
    (void)isopach::read_las(path, options, {});
  } catch (const isopach::Error&) {
  }
  return 0;
}
