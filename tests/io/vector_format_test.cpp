// GeoPackage and FlatGeobuf: what GDAL reads of them is what the GeoJSON says; the same bytes twice.
#include "isopach/io/vector_format.hpp"

#include <gdal.h>
#include <gtest/gtest.h>
#include <ogr_api.h>
#include <ogr_srs_api.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "isopach/io/polygons.hpp"

namespace isopach::test {
namespace {

const std::string text = R"({"type": "FeatureCollection", "name": "changes",
"crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25832"}},
"features": [
{"type":"Feature","id":1,"properties":{"id":1,"change":"gained","net":12.345678901234567,"sigma_net":null,"significant":true},"geometry":{"type":"Polygon","coordinates":[[[500000.1,5200000.2],[500010.0,5200000.0],[500000.0,5200010.0],[500000.1,5200000.2]]]}},
{"type":"Feature","id":2,"properties":{"id":2,"change":"lost","net":-1.5,"sigma_net":0.25,"significant":false},"geometry":{"type":"MultiPolygon","coordinates":[[[[0,0],[1,0],[0,1],[0,0]]],[[[5,5],[6,5],[5,6],[5,5]]]]}}
]})";

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class VectorFormats : public testing::TestWithParam<VectorFormat> {};

TEST_P(VectorFormats, HoldWhatTheGeoJsonSays) {
  const std::string ending = ending_of(GetParam());
  const auto path = std::filesystem::temp_directory_path() / ("isopach_vector_test." + ending);
  write_vectors(path.string(), text, GetParam(), "EPSG:25832+7837");
  const std::string first = bytes_of(path);
  write_vectors(path.string(), text, GetParam(), "EPSG:25832+7837");
  EXPECT_EQ(bytes_of(path), first);
  GDALAllRegister();
  const GDALDatasetH data = GDALOpenEx(path.c_str(), GDAL_OF_VECTOR, nullptr, nullptr, nullptr);
  ASSERT_NE(data, nullptr);
  ASSERT_EQ(GDALDatasetGetLayerCount(data), 1);
  const OGRLayerH layer = GDALDatasetGetLayer(data, 0);
  EXPECT_STREQ(OGR_L_GetName(layer), "changes");
  ASSERT_NE(OGR_L_GetSpatialRef(layer), nullptr);
  ASSERT_EQ(OGR_L_GetFeatureCount(layer, TRUE), 2);
  int seen = 0;
  for (OGRFeatureH f = OGR_L_GetNextFeature(layer); f != nullptr; f = OGR_L_GetNextFeature(layer)) {
    const bool gained = std::string(OGR_F_GetFieldAsString(f, OGR_F_GetFieldIndex(f, "change"))) == "gained";
    EXPECT_EQ(OGR_F_GetFieldAsDouble(f, OGR_F_GetFieldIndex(f, "net")), gained ? 12.345678901234567 : -1.5);
    EXPECT_EQ(OGR_F_IsFieldSetAndNotNull(f, OGR_F_GetFieldIndex(f, "sigma_net")), gained ? 0 : 1);
    EXPECT_NEAR(OGR_G_Area(OGR_F_GetGeometryRef(f)), gained ? 48.5 : 1, 1e-6);
    OGR_F_Destroy(f), ++seen;
  }
  EXPECT_EQ(seen, 2);
  GDALClose(data);
  EXPECT_EQ(read_polygons(path.string()).polygons.size(), 2U);
  std::filesystem::remove(path);
}

INSTANTIATE_TEST_SUITE_P(All, VectorFormats,
                         testing::Values(VectorFormat::geojson, VectorFormat::gpkg, VectorFormat::fgb));

}  // namespace
}  // namespace isopach::test
