// Files beside the scans: compare takes what they hold, the command line their names.
#pragma once
#include <string>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/compare/options.hpp"

namespace isopach::cli {

/// Of --include, --exclude, --budget and --mask.
struct AreaPaths {
  std::vector<std::string> include, exclude, budget;
  std::string mask;  ///< empty: none
};

/// Errors as of read_polygons and read_mask.
[[nodiscard]] AreaOptions read_area(const AreaPaths& paths, const Context& context);

/// The rasters that --sigma1, --sigma2 and --weight name. Errors as of read_raster_values.
void read_rasters(CompareOptions& options, const Context& context);

}  // namespace isopach::cli
