// Formats that are not read, known by their first bytes, so that a refusal can name what a file is and what helps.
#pragma once
#include <string_view>

namespace isopach {

struct ForeignFormat {
  std::string_view name;    ///< as people call it; empty: none of those known here
  std::string_view remedy;  ///< "convert it to … with …"
};

/// `head`: the first bytes of a file, 512 are enough. Test: tests/io/foreign_test.cpp.
[[nodiscard]] ForeignFormat foreign_format(std::string_view head);

}  // namespace isopach
