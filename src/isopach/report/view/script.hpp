// The script of the view, viewer/bundle/viewer.js: cmake/ViewScript.cmake makes the source file of these from it.
#pragma once
#include <string_view>

namespace isopach {

[[nodiscard]] std::string_view view_script();
/// Of the script, in hexadecimal digits.
[[nodiscard]] std::string_view view_script_sha256();

}  // namespace isopach
