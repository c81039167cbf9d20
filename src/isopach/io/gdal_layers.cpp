#include <limits>

#include "isopach/io/gdal.hpp"
#include "isopach/io/output_file.hpp"
#include "isopach/io/raster_layers.hpp"
#include "isopach/io/write.hpp"

namespace isopach {
namespace {

void check(bool good, const std::string& path, const GdalMessages& messages) {
  if (!good) fail_to_write(path, messages.failure());
}

GdalDataset in_memory(const RasterLayers& layers, const std::string& path, const GdalMessages& messages) {
  const int columns = static_cast<int>(layers.columns), rows = static_cast<int>(layers.rows);
  GdalDataset data(gdal().GDALCreate(gdal().GDALGetDriverByName("MEM"), "", columns, rows,
                                     static_cast<int>(layers.bands.size()), GDT_Float64, nullptr));
  check(data != nullptr, path, messages);
  std::array<double, 6> geotransform = layers.geotransform;
  check(gdal().GDALSetGeoTransform(data.get(), geotransform.data()) == CE_None, path, messages);
  if (const std::string wkt = wkt_of_crs(layers.crs, path); !wkt.empty())
    check(gdal().GDALSetProjection(data.get(), wkt.c_str()) == CE_None, path, messages);
  int number = 0;
  for (const RasterBand& of : layers.bands) {
    const GDALRasterBandH band = gdal().GDALGetRasterBand(data.get(), ++number);
    check(gdal().GDALSetRasterNoDataValue(band, std::numeric_limits<double>::quiet_NaN()) == CE_None, path, messages);
    gdal().GDALSetDescription(band, of.name.c_str());
    if (!of.unit.empty()) check(gdal().GDALSetRasterUnitType(band, of.unit.c_str()) == CE_None, path, messages);
    // GDAL takes what it writes from as no constant, and leaves it as it is.
    auto* values = const_cast<double*>(of.values.data());
    check(gdal().GDALRasterIO(band, GF_Write, 0, 0, columns, rows, values, columns, rows, GDT_Float64, 0, 0) == CE_None,
          path, messages);
  }
  return data;
}

}  // namespace

void need_raster_writer(const std::string& path) { need_gdal(path + ": writing a raster"); }

void write_raster_layers(const std::string& path, const RasterLayers& layers, const Context& context) {
  need_raster_writer(path);
  context.step("write", 0);
  write_atomically(path, [&](const std::string& temporary) {
    const GdalMessages messages;
    const NoNetwork alone;
    gdal().GDALAllRegister();
    const GdalDataset data = in_memory(layers, path, messages);
    const char* const cog[] = {"COMPRESS=DEFLATE", "PREDICTOR=YES", "OVERVIEW_RESAMPLING=AVERAGE", "BIGTIFF=IF_SAFER",
                               nullptr};
    const char* const tiff[] = {"TILED=YES", "COMPRESS=DEFLATE", "PREDICTOR=3", "BIGTIFF=IF_SAFER", nullptr};
    const GDALDriverH best = gdal().GDALGetDriverByName("COG");
    const GDALDriverH driver = best != nullptr ? best : gdal().GDALGetDriverByName("GTiff");
    GdalDataset written(gdal().GDALCreateCopy(driver, temporary.c_str(), data.get(), 0,
                                              const_cast<char**>(best != nullptr ? cog : tiff), nullptr, nullptr));
    check(written != nullptr, path, messages);
    written.reset();
    check(messages.failure().empty(), path, messages);
  });
}

}  // namespace isopach
