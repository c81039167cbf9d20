// What is left of isopach where it was built without GDAL: this program is linked with io/without_gdal.cpp.
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <string>

#include "isopach/base/error.hpp"
#include "isopach/io/crs.hpp"
#include "isopach/io/polygons.hpp"
#include "isopach/io/raster.hpp"
#include "isopach/io/raster_layers.hpp"
#include "isopach/io/read.hpp"
#include "isopach/io/vector_format.hpp"
#include "isopach/io/write.hpp"

namespace {

using namespace isopach;

int failures = 0;

void expect(bool is_so, const std::string& what) {
  if (is_so) return;
  std::cerr << "not so: " << what << "\n";
  ++failures;
}

/// Refuses with exit code 3, naming the file and what to do.
void expect_refused(const std::string& name, const std::function<void()>& what) {
  std::string said;
  try {
    what();
  } catch (const InputError& e) {
    said = e.what();
  }
  expect(said.find(name) != std::string::npos && said.find("was built without it") != std::string::npos,
         name + " is refused, but: '" + said + "'");
}

}  // namespace

int main() {
  const auto folder = std::filesystem::temp_directory_path() / "isopach-without-gdal";
  std::filesystem::create_directories(folder);
  const auto file = [&](const std::string& name, const std::string& content) {
    std::ofstream(folder / name, std::ios::binary) << content;
    return (folder / name).string();
  };
  const std::string tiff = file("a.tif", std::string("II*\0", 4) + "and so on");
  const std::string text = file("a.xyz", "0 0 1\n1 0 2\n0 1 3\n");
  const std::string grid = file("a.asc", "ncols 2\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 1\n0 5\n");
  const std::string polygons = file("a.geojson", R"({"type":"Polygon","coordinates":[[[0,0],[1,0],[1,1],[0,0]]]})");

  Cloud cloud = read_cloud(text, {}, {});
  expect(cloud.points.size() == 3, "points are read from text");
  expect(read_cloud(grid, {}, {}).points.size() == 2, "an ESRI ASCII grid is read");
  expect(read_mask(grid, {}).edges.size() == 4, "and is a mask");
  write_cloud((folder / "b.las").string(), cloud, {});
  expect(read_cloud((folder / "b.las").string(), {}, {}).points.size() == 3, "LAS is written and read");
  expect_refused(tiff, [&] { (void)read_cloud(tiff, {}, {}); });
  expect_refused("c.tif", [&] { need_raster_writer("c.tif"); });
  expect_refused("c.tif", [&] { write_raster_layers("c.tif", {}, {}); });
  expect_refused("c.gpkg", [&] { need_vector_writer(VectorFormat::gpkg, "c.gpkg"); });
  need_vector_writer(VectorFormat::geojson, "c.geojson");
  expect_refused(polygons, [&] { (void)read_polygons(polygons); });
  cloud.crs = "EPSG:25832";
  const std::string las = (folder / "c.las").string();
  expect_refused(las, [&] { write_cloud(las, cloud, {}); });
  expect(same_crs("EPSG:25832", "EPSG:25832"), "a coordinate system is itself");
  expect_refused("two coordinate reference systems", [] { (void)same_crs("EPSG:25832", "EPSG:25833"); });
  std::filesystem::remove_all(folder);
  return failures == 0 ? 0 : 1;
}
