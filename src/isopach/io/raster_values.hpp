// RasterValues from a file.
#pragma once
#include <string>

#include "isopach/base/context.hpp"
#include "isopach/cloud/raster_values.hpp"

namespace isopach {

/// Reads band 1. Throws InputError: not readable, or not a raster; the message names `option`.
[[nodiscard]] RasterValues read_raster_values(const std::string& path, const std::string& option,
                                              const Context& context);

}  // namespace isopach
