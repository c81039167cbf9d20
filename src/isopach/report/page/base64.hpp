// base64: bytes as text [RFC 4648].
#pragma once
#include <string>
#include <string_view>

namespace isopach {

[[nodiscard]] std::string base64(std::string_view bytes);

}  // namespace isopach
