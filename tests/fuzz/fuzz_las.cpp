// Any bytes: read_las reads them or throws isopach::Error with one line. The bytes stay in memory, behind a
// path, because LASzip opens files by name. The first four bytes are given: the rest is what is worth trying.
#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "isopach/base/error.hpp"
#include "isopach/io/las.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const int file = memfd_create("fuzz", 0);
  static const std::string path = "/proc/self/fd/" + std::to_string(file);
  std::string bytes(reinterpret_cast<const char*>(data), size);
  if (size >= 4) bytes.replace(0, 4, "LASF");
  if (ftruncate(file, 0) != 0 || pwrite(file, bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    abort();

  isopach::ReadOptions options;
  options.all_attributes = true;
  try {
    const isopach::Cloud cloud = isopach::read_las(path, options, {});
    if (cloud.points.empty()) abort();
    for (const isopach::Attribute& attribute : cloud.attributes)
      if (attribute.values.size() != cloud.points.size()) abort();
  } catch (const isopach::Error& error) {
    if (std::string(error.what()).find('\n') != std::string::npos) abort();
  }
  return 0;
}
