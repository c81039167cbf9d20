// Fuzz target: any bytes as a file of this format.
#include "isopach/io/pcd.hpp"
#include "tests/fuzz/cloud_checks.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const isopach::fuzz::ExactBytes copy(data, size);
  isopach::ReadOptions options;
  options.all_attributes = true;
  options.faces = true;
  isopach::fuzz::only_errors(
      [&] { isopach::fuzz::require_consistent(isopach::parse_pcd(copy.bytes(), "fuzz", options, {})); });
  return 0;
}
