#include "isopach/io/crs.hpp"

#include <gtest/gtest.h>

#include "tests/io/files.hpp"

namespace isopach {
namespace {

// A geographic system with heights over the ellipsoid in a unit of choice.
std::string geographic(const std::string& unit_of_height) {
  return "GEOGCRS[\"test\",DATUM[\"test\",ELLIPSOID[\"test\",6378137,298.25]],CS[ellipsoidal,3],"
         "AXIS[\"latitude\",north,ANGLEUNIT[\"degree\",0.0174532925199433]],"
         "AXIS[\"longitude\",east,ANGLEUNIT[\"degree\",0.0174532925199433]],AXIS[\"height (h)\",up,LENGTHUNIT[" +
         unit_of_height + "]]]";
}

// A projected system without a code, in metres.
const std::string local_grid =
    "PROJCS[\"local grid\",GEOGCS[\"test\",DATUM[\"test\",SPHEROID[\"test\",6378137,298.25]],PRIMEM[\"Greenwich\",0],"
    "UNIT[\"degree\",0.0174532925199433]],PROJECTION[\"Transverse_Mercator\"],PARAMETER[\"latitude_of_origin\",1],"
    "PARAMETER[\"central_meridian\",2],PARAMETER[\"scale_factor\",1],PARAMETER[\"false_easting\",3],"
    "PARAMETER[\"false_northing\",4],UNIT[\"metre\",1]]";

TEST(CrsTest, UnitsAreThoseOfTheAxes) {
  const auto units = [](const std::string& wkt) {
    const Crs crs = crs_from_wkt(wkt, "test");
    return crs.unit + " " + crs.vertical_unit;
  };
  EXPECT_EQ(units(geographic("\"metre\",1")), "deg m");
  EXPECT_EQ(units(geographic("\"foot\",0.3048")), "deg ft");
  EXPECT_EQ(units(geographic("\"US survey foot\",0.304800609601219")), "deg us-ft");
  EXPECT_EQ(units(geographic("\"fathom\",1.8288")), "deg unknown");
  EXPECT_EQ(units(local_grid), "m unknown");
  EXPECT_EQ(units(wkt_of_crs("EPSG:25832+5783", "test")), "m m");
  EXPECT_EQ(units(wkt_of_crs("EPSG:2225+6360", "test")), "us-ft us-ft");
  EXPECT_EQ(units(wkt_of_crs("EPSG:4978", "test")), "m m");  // geocentric
}

TEST(CrsTest, NamesAreCodesWhereThereAreSome) {
  EXPECT_EQ(crs_from_wkt(wkt_of_crs("EPSG:25832", "test"), "test").name, "EPSG:25832");
  EXPECT_EQ(crs_from_wkt(wkt_of_crs("EPSG:25832+5783", "test"), "test").name, "EPSG:25832+5783");
  EXPECT_TRUE(crs_from_wkt(local_grid, "test").name.starts_with("PROJCS[\"local grid\""));
  EXPECT_EQ(crs_from_wkt("no such text", "test").name, "");
  EXPECT_EQ(crs_from_esri("no such text", "test").name, "");
  EXPECT_EQ(crs_from_esri("PROJCS[\"NAD_1983_UTM_Zone_10N\",GEOGCS[\"GCS_North_American_1983\","
                          "DATUM[\"D_North_American_1983\",SPHEROID[\"GRS_1980\",6378137.0,298.257222101]],"
                          "PRIMEM[\"Greenwich\",0.0],UNIT[\"Degree\",0.0174532925199433]],"
                          "PROJECTION[\"Transverse_Mercator\"],PARAMETER[\"False_Easting\",500000.0],"
                          "PARAMETER[\"False_Northing\",0.0],PARAMETER[\"Central_Meridian\",-123.0],"
                          "PARAMETER[\"Scale_Factor\",0.9996],PARAMETER[\"Latitude_Of_Origin\",0.0],"
                          "UNIT[\"Meter\",1.0]]",
                          "test")
                .name,
            "EPSG:26910");
  EXPECT_EQ(short_name(local_grid), "local grid");
  EXPECT_EQ(short_name("EPSG:25832"), "EPSG:25832");
  EXPECT_EQ(short_name(std::string(100, 'x')), "another one");
}

TEST(CrsTest, SystemsAreComparedWithoutTheirHeights) {
  EXPECT_TRUE(same_crs("EPSG:25832+5783", "EPSG:25832"));
  EXPECT_TRUE(same_crs("EPSG:25832", wkt_of_crs("EPSG:25832", "test")));
  EXPECT_FALSE(same_crs("EPSG:25832", "EPSG:25833"));
  EXPECT_FALSE(same_crs("EPSG:25832", "WGS84"));
  EXPECT_TRUE(same_crs("", "EPSG:25832"));
  EXPECT_TRUE(same_crs("what nobody understands", "EPSG:25832"));
}

TEST(CrsTest, FilesThatATextNamesAreNotOpened) {
  const test::TempFolder folder;
  const std::string file = folder / "system.wkt";
  std::ofstream(file) << local_grid;
  EXPECT_NE(wkt_of_crs(local_grid, "test"), "");
  const std::vector<std::string> names{file, "ESRI::" + file, "esri::ESRI::" + file, "/vsimem/system.wkt",
                                       "DICT:" + file + ",1"};
  for (const std::string& name : names) EXPECT_EQ(wkt_of_crs(name, "test"), "") << name;
}

}  // namespace
}  // namespace isopach
