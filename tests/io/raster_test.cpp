#include "isopach/io/raster.hpp"

#include <gdal_priv.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "isopach/base/error.hpp"
#include "tests/support/random.hpp"
#include "tests/support/shared_data.hpp"

namespace isopach {
namespace {

namespace fs = std::filesystem;

class RasterTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* const info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / (std::string("isopach-raster-") + info->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  [[nodiscard]] std::string file(const std::string& name) const { return (folder_ / name).string(); }
  std::string write(const std::string& name, const std::string& bytes) const {
    std::ofstream(file(name), std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return file(name);
  }

  fs::path folder_;
};

Cloud read(const fs::path& path) { return read_raster(path.string(), {}, {}); }

std::string slurp(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// A grid with holes, turned and sheared, whose cells have known centres.
Cloud known_grid() {
  Cloud cloud;
  cloud.grid = RasterGrid{37, 23, {500000, 0.5, 0.125, 4600000, 0.25, -0.75}};
  cloud.crs = "EPSG:26910";
  cloud.unit = "m";
  cloud.vertical_unit = "ft";
  for (std::size_t row = 0; row < 23; ++row)
    for (std::size_t column = 0; column < 37; ++column)
      if ((row * 37 + column) % 7 != 0)
        cloud.points.push_back(cell_centre(*cloud.grid, column, row, std::sin(static_cast<double>(row * 37 + column))));
  return cloud;
}

TEST_F(RasterTest, RoundTripsThroughGeoTiff) {
  const Cloud cloud = known_grid();
  write_raster(file("a.tif"), cloud, {});
  EXPECT_TRUE(is_raster(slurp(file("a.tif")).substr(0, 512)));
  const Cloud again = read(file("a.tif"));
  EXPECT_TRUE(std::equal(cloud.points.begin(), cloud.points.end(), again.points.begin(), again.points.end()));
  EXPECT_EQ(again.nodata, 37u * 23u - cloud.points.size());
  ASSERT_TRUE(again.grid);
  EXPECT_EQ(again.grid->columns, 37u);
  EXPECT_EQ(again.grid->rows, 23u);
  EXPECT_EQ(again.grid->geotransform, cloud.grid->geotransform);
  EXPECT_EQ(again.crs, "EPSG:26910");
  EXPECT_EQ(again.unit, "m");
  EXPECT_EQ(again.vertical_unit, "ft");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1) << "nothing is left beside the file";
}

TEST_F(RasterTest, OnlyGridsCanBeWritten) {
  Cloud cloud = known_grid();
  cloud.points.push_back(cloud.points.front());
  EXPECT_THROW(write_raster(file("a.tif"), cloud, {}), InputError);  // two in one cell
  cloud.points.back().x += 1000;
  EXPECT_THROW(write_raster(file("a.tif"), cloud, {}), InputError);  // outside
  cloud.grid.reset();
  EXPECT_THROW(write_raster(file("a.tif"), cloud, {}), UsageError);
  EXPECT_FALSE(fs::exists(file("a.tif")));
}

TEST_F(RasterTest, ScaleOffsetUnitAndNoDataOfTheBandAreApplied) {
  GDALAllRegister();
  GDALDataset* data =
      GetGDALDriverManager()->GetDriverByName("GTiff")->Create(file("a.tif").c_str(), 3, 2, 2, GDT_Int16, nullptr);
  ASSERT_NE(data, nullptr);
  double geotransform[] = {100, 10, 0, 200, 0, -10};
  data->SetGeoTransform(geotransform);
  GDALRasterBand& band = *data->GetRasterBand(1);
  band.SetScale(0.5);
  band.SetOffset(-3);
  band.SetNoDataValue(-32768);
  band.SetUnitType("US survey foot");
  std::int16_t raw[] = {0, 1, -32768, 3, 4, 5};
  ASSERT_EQ(band.RasterIO(GF_Write, 0, 0, 3, 2, raw, 3, 2, GDT_Int16, 0, 0, nullptr), CE_None);
  GDALClose(data);

  const Cloud cloud = read(file("a.tif"));
  const Array<Point3> expected = {{105, 195, -3}, {115, 195, -2.5}, {105, 185, -1.5}, {115, 185, -1}, {125, 185, -0.5}};
  EXPECT_EQ(cloud.points, expected);
  EXPECT_EQ(cloud.nodata, 1u);
  EXPECT_EQ(cloud.unit, "unknown");
  EXPECT_EQ(cloud.vertical_unit, "us-ft");
  ASSERT_EQ(cloud.notes.size(), 1u);  // two bands
}

TEST_F(RasterTest, AsciiGridsAreReadFromTheNorth) {
  const Array<Point3> expected = {{10.5, 21.5, 2}, {11.5, 21.5, 3}, {10.5, 20.5, -4.5}, {12.5, 20.5, 6}};
  const char* const cells = "2 3 -1\n-4.5 nan 6\n";
  for (const char* head :
       {"ncols 3\nnrows 2\nxllcorner 10\nyllcorner 20\ncellsize 1\nNODATA_value -1\n",
        "NCOLS 3\r\nNROWS 2\r\nXLLCENTER 10.5\r\nYLLCENTER 20.5\r\nCELLSIZE 1\r\nNODATA_VALUE -1.0\r\n",
        "nrows 2 ncols 3 xllcorner 1e1 yllcorner 20 dx 1 dy 1 nodata_value -1 "}) {
    const Cloud cloud = read(write("a.asc", std::string(head) + cells));
    EXPECT_EQ(cloud.points, expected) << head;
    EXPECT_EQ(cloud.nodata, 2u);
    EXPECT_EQ(cloud.format, "raster");
  }
  write("a.prj",
        "PROJCS[\"NAD_1983_UTM_Zone_10N\",GEOGCS[\"GCS_North_American_1983\",DATUM[\"D_North_American_1983\","
        "SPHEROID[\"GRS_1980\",6378137.0,298.257222101]],PRIMEM[\"Greenwich\",0.0],UNIT[\"Degree\","
        "0.0174532925199433]],PROJECTION[\"Transverse_Mercator\"],PARAMETER[\"False_Easting\",500000.0],"
        "PARAMETER[\"False_Northing\",0.0],PARAMETER[\"Central_Meridian\",-123.0],PARAMETER[\"Scale_Factor\","
        "0.9996],PARAMETER[\"Latitude_Of_Origin\",0.0],UNIT[\"Meter\",1.0]]");
  const Cloud placed = read(file("a.asc"));
  EXPECT_EQ(placed.crs, "EPSG:26910");
  EXPECT_EQ(placed.unit, "m");
  EXPECT_EQ(placed.vertical_unit, "unknown");
}

// One line, with the name of the file.
void expect_error(const std::string& path) {
  try {
    const Cloud cloud = read(path);
    ADD_FAILURE() << path << " was read: " << cloud.points.size() << " cells";
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find(path), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

TEST_F(RasterTest, BrokenGridsAreRefused) {
  const std::string head = "ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\nnodata_value 9\n";
  expect_error(write("short.asc", head + "1 2 3\n4 5\n"));
  expect_error(write("long.asc", head + "1 2 3\n4 5 6 7\n"));
  expect_error(write("word.asc", head + "1 2 3\n4 five 6\n"));
  expect_error(write("empty.asc", head + "9 9 9\n9 9 9\n"));
  expect_error(write("no-rows.asc", "ncols 3\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n"));
  expect_error(write("no-size.asc", "ncols 3\nnrows 1\nxllcorner 0\nyllcorner 0\n1 2 3\n"));
  expect_error(write("flat.asc", "ncols 3\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 0\n1 2 3\n"));
  expect_error(write("huge.asc", "ncols 4000000000\nnrows 4000000000\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n"));
  expect_error(write("fraction.asc", "ncols 1.5\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n"));
  expect_error(write("text.tif", "1 2 3\n4 5 6\n"));
  expect_error(file("absent.tif"));
}

TEST_F(RasterTest, ListsOfPointsAreNoRasters) {
  EXPECT_FALSE(is_raster("1 2 3\n4 5 6\n"));
  EXPECT_FALSE(is_raster("x y z\n1 2 3\n"));
  EXPECT_FALSE(is_raster("ncolsandmore 3"));
  EXPECT_FALSE(is_raster("ncols"));
  EXPECT_FALSE(is_raster(""));
  EXPECT_TRUE(is_raster("ncols 3\nnrows 2\n"));
  EXPECT_TRUE(is_raster(std::string_view("II*\0", 4)));
}

TEST_F(RasterTest, ATinyFileOfAbsurdSizeTakesNoMemory) {
  // Sparse: 100 000 by 100 000 cells in some 400 bytes, as one strip of blocks that were never written.
  GDALAllRegister();
  const char* const options[] = {"SPARSE_OK=TRUE", "TILED=YES", "BLOCKXSIZE=65536", "BLOCKYSIZE=65536", nullptr};
  GDALDataset* data = GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
      file("huge.tif").c_str(), 100000, 100000, 1, GDT_Byte, const_cast<char**>(options));
  ASSERT_NE(data, nullptr);
  GDALClose(data);
  ASSERT_LT(fs::file_size(file("huge.tif")), 100000u);
  expect_error(file("huge.tif"));
}

TEST_F(RasterTest, DamagedFilesReadOrSayWhy) {
  write_raster(file("good.tif"), known_grid(), {});
  const std::string ascii = "ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\nnodata_value 9\n1 2 3\n4 5 6\n";
  test::Random random(2);
  for (const std::string& good : {slurp(file("good.tif")), ascii}) {
    for (int i = 0; i < 150; ++i) {
      std::string bytes = good;
      if (i % 3 == 0) bytes.resize(random.below(good.size()));
      const std::size_t flips = i % 3 == 0 ? 0 : 1 + random.below(4);
      for (std::size_t k = 0; k < flips; ++k) bytes[random.below(bytes.size())] = static_cast<char>(random.below(256));
      const std::string path = write("bad.tif", bytes);
      try {
        EXPECT_FALSE(read(path).points.empty());
      } catch (const Error& error) {
        const std::string message = error.what();
        EXPECT_NE(message.find(path), std::string::npos) << message;
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
      }
    }
  }
}

TEST_F(RasterTest, TheDomeHasTheCellsOthersFound) {
  ISOPACH_SHARED_OR_SKIP(path, "msh-dome/2.tif");
  const Cloud cloud = read(path);
  ASSERT_TRUE(cloud.grid);
  EXPECT_EQ(cloud.grid->columns, 303u);
  EXPECT_EQ(cloud.grid->rows, 442u);
  EXPECT_EQ(cloud.points.size() + cloud.nodata, 303u * 442u);
  EXPECT_EQ(cloud.points.size(), 133926u);
  EXPECT_EQ(cloud.crs, "EPSG:26910");
  EXPECT_EQ(cloud.unit, "m");
}

TEST_F(RasterTest, EveryNumberTypeGivesTheSameHeights) {
  ISOPACH_SHARED_OR_SKIP(folder, "formats/pdal-gdal");
  const Cloud reference = read(folder / "float32.tif");
  EXPECT_EQ(reference.points.size(), 400u);
  for (const char* name : {"byte.tif", "int16.tif", "int32.tif"})
    EXPECT_EQ(read(folder / name).points, reference.points) << name;
}

TEST_F(RasterTest, GridsThatStartWithNanAreRead) {
  ISOPACH_SHARED_OR_SKIP(path, "formats/gdal-asc/nodata_nan.asc");
  const Cloud cloud = read(path);
  const Array<Point3> expected = {{1.5, 1.5, -1}, {2.5, 1.5, 0}, {0.5, 0.5, 1}, {1.5, 0.5, 2}, {2.5, 0.5, 3}};
  EXPECT_EQ(cloud.points, expected);
  EXPECT_EQ(cloud.nodata, 1u);
}

TEST_F(RasterTest, DegreesStayDegrees) {
  ISOPACH_SHARED_OR_SKIP(path, "demcompare/Copernicus_DSM_10_N45_00_E005_00_DEM.tif");
  const Cloud cloud = read(path);
  EXPECT_EQ(cloud.points.size(), 250000u);
  EXPECT_EQ(cloud.unit, "deg");
  EXPECT_EQ(cloud.vertical_unit, "unknown");
}

}  // namespace
}  // namespace isopach
