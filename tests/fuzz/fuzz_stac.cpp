// Fuzz target: any bytes as a catalogue of files, and as the hrefs in it.
#include "isopach/io/stac.hpp"
#include "tests/fuzz/input.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace isopach;
  const std::string text(reinterpret_cast<const char*>(data), size);
  fuzz::only_errors([&] {
    for (const std::string& href : stac_hrefs(text, "fuzz")) {
      fuzz::require(!href.empty() && href.find('\0') == std::string::npos, "hrefs are names");
      fuzz::require(decoded(path_of_href(href)).find('\0') == std::string::npos, "decoded ones are, too");
    }
  });
  fuzz::require(printable(text).find('\n') == std::string::npos, "printable names have one line");
  return 0;
}
