// Fuzz target: any bytes as a raster, one that GDAL reads or an ESRI ASCII grid, and what is made of it: values by
// place, and a mask.
#include "isopach/cloud/raster_values.hpp"
#include "isopach/io/polygons.hpp"
#include "isopach/io/raster.hpp"
#include "tests/fuzz/cloud_checks.hpp"
#include "tests/fuzz/memory_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace isopach;
  const fuzz::ExactBytes copy(data, size);
  static fuzz::MemoryFile file;
  fuzz::only_errors([&] {
    const Cloud cloud = read_raster(copy.bytes(), "fuzz", {});
    fuzz::require_consistent(cloud);
    fuzz::require(cloud.points.size() + cloud.nodata == cloud.grid->columns * cloud.grid->rows,
                  "every cell is counted");
    const RasterValues values(cloud);
    for (const Point3& p : cloud.points) fuzz::require(values.at(p) == p.z, "a point finds its cell again");
    const Mask mask = read_mask(file.with(copy.bytes()), {});
    fuzz::require(mask.edges.size() >= 4, "a mask has an outline");
  });
  return 0;
}
