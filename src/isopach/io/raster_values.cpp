#include "isopach/io/raster_values.hpp"

#include "isopach/base/error.hpp"
#include "isopach/io/read.hpp"

namespace isopach {

RasterValues read_raster_values(const std::string& path, const std::string& option, const Context& context) {
  const Cloud cloud = read_cloud(path, {}, context);
  if (!cloud.grid) throw InputError(option + ": " + path + " is no raster: give a GeoTIFF or another grid");
  return RasterValues(cloud);
}

}  // namespace isopach
