#include "isopach/base/error.hpp"

#include "isopach/base/option_key.hpp"

namespace isopach {

std::string Error::option() const { return leading_key(what()); }

}  // namespace isopach
