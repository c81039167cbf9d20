// libFuzzer target: any bytes as a file of this format. Only isopach::Error may leave the reader.
#include <cstddef>
#include <cstdint>

#include "isopach/base/error.hpp"
#include "isopach/io/text.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  isopach::ReadOptions options;
  options.all_attributes = true;
  options.faces = true;
  try {
    (void)isopach::parse_text({reinterpret_cast<const char*>(data), size}, "fuzz", options, isopach::Context{});
  } catch (const isopach::Error&) {  // a reason is as good as a cloud
  }
  return 0;
}
