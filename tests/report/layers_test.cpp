// Layers: sums over pixels are the volumes, whatever the grid; what is written is what GDAL reads.
#include "isopach/report/layers.hpp"

#include <gdal.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "isopach/base/error.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/compare/measured_cells.hpp"
#include "isopach/report/profile.hpp"
#include "isopach/report/vector_layers.hpp"
#include "tests/support/clouds.hpp"

namespace isopach::test {
namespace {

Cloud moved(Cloud cloud, const Point3& by, double scale = 1) {
  for (Point3& p : cloud.points) p = {scale * p.x + by.x, scale * p.y + by.y, p.z + by.z};
  return cloud;
}

Comparison compared(const Point3& origin, Surface surface = Surface::common, double lod = 0) {
  CompareOptions o;
  o.check_layers = false;
  o.surface = surface;
  o.keep_overlay = surface != Surface::common;
  o.uncertainty.lod = lod;
  return compare(moved(rough_cloud(uniform(800, 1), 2), origin, 100),
                 moved(rough_cloud(uniform(900, 3), 4), origin, 100), o, {});
}

const Array<double>& band(const RasterLayers& layers, const std::string& name) {
  for (const RasterBand& b : layers.bands)
    if (b.name == name) return b.values;
  throw std::runtime_error("no band " + name);
}

TEST(Raster, SumsAreTheVolumeAtEveryStepAndOrigin) {
  for (const Point3& origin : {Point3{0, 0, 0}, Point3{412345.678, 5236123.456, 789.5}, Point3{-0.1, 1e-3, -5}})
    for (const Surface surface : {Surface::common, Surface::overlay}) {
      const Comparison c = compared(origin, surface);
      for (const double step : {0.7, 1.0, 3.3, 17.0, 1000.0}) {
        const RasterLayers layers = difference_layers(c, step, {});
        const Array<double>&d = band(layers, "d"), &coverage = band(layers, "coverage");
        Sum net, area;
        for (std::size_t i = 0; i < d.size(); ++i) {
          area.add(coverage[i] * step * step);
          if (coverage[i] > 0) net.add(d[i] * coverage[i] * step * step);
        }
        EXPECT_NEAR(net.value(), c.measures.volume.net, 1e-12 * c.measures.volume.absolute) << step;
        EXPECT_NEAR(area.value(), c.domain_area, 1e-12 * c.domain_area) << step;
      }
    }
}

TEST(Raster, PixelsLieAtMultiplesOfTheStepAndHoldMeans) {
  const Comparison c = compared({412345.678, 5236123.456, 789.5}, Surface::common, 0.2);
  const RasterLayers layers = difference_layers(c, 4, {});
  EXPECT_EQ(std::fmod(layers.geotransform[0], 4), 0);
  EXPECT_EQ(std::fmod(layers.geotransform[3], 4), 0);
  EXPECT_LE(layers.geotransform[0], 412345.678 + 4);
  const Array<double>&d = band(layers, "d"), &a = band(layers, "z_a"), &b = band(layers, "z_b"),
        &lod = band(layers, "lod"), &sure = band(layers, "significance"), &share = band(layers, "coverage");
  for (std::size_t i = 0; i < d.size(); ++i) {
    EXPECT_EQ(std::isnan(d[i]), share[i] == 0);
    if (share[i] == 0) continue;
    EXPECT_NEAR(d[i], b[i] - a[i], 1e-10);
    EXPECT_NEAR(lod[i], 0.2, 1e-9);
    EXPECT_NEAR(sure[i], d[i] / 0.2, 1e-8);
    EXPECT_LT(std::fabs(a[i] - 789.5), 1.1);
    EXPECT_LE(share[i], 1 + 1e-9);
  }
}

TEST(Raster, IsReadByGdalAsItWasWritten) {
  Comparison c = compared({412345.678, 5236123.456, 789.5}, Surface::common, 0.2);
  c.a.crs = "EPSG:25832";
  const RasterLayers layers = difference_layers(c, 0.15, {});
  const auto path = std::filesystem::temp_directory_path() / "isopach_layers_test.tif";
  write_raster_layers(path.string(), layers, {});
  GDALAllRegister();
  const GDALDatasetH data = GDALOpen(path.c_str(), GA_ReadOnly);
  ASSERT_NE(data, nullptr);
  EXPECT_EQ(GDALGetRasterCount(data), 6);
  EXPECT_NE(std::string(GDALGetProjectionRef(data)).find("25832"), std::string::npos);
  std::array<double, 6> geotransform{};
  GDALGetGeoTransform(data, geotransform.data());
  EXPECT_EQ(geotransform, layers.geotransform);
  const int columns = static_cast<int>(layers.columns), rows = static_cast<int>(layers.rows);
  for (int k = 0; k < 6; ++k) {
    const GDALRasterBandH of = GDALGetRasterBand(data, k + 1);
    EXPECT_EQ(GDALGetDescription(of), layers.bands[static_cast<std::size_t>(k)].name);
    EXPECT_GT(GDALGetOverviewCount(of), 0);
    std::vector<double> values(layers.columns * layers.rows);
    ASSERT_EQ(GDALRasterIO(of, GF_Read, 0, 0, columns, rows, values.data(), columns, rows, GDT_Float64, 0, 0), CE_None);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double expected = layers.bands[static_cast<std::size_t>(k)].values[i];
      if (!(values[i] == expected || (std::isnan(values[i]) && std::isnan(expected)))) FAIL() << k << ", pixel " << i;
    }
  }
  GDALClose(data);
  EXPECT_FALSE(std::filesystem::exists(path.string() + ".aux.xml"));
  std::filesystem::remove(path);
}

TEST(Raster, OfTooManyPixelsIsRefused) {
  EXPECT_THROW((void)difference_layers(compared({0, 0, 0}), 1e-9, {}), UsageError);
  ProjectOptions turned;
  turned.direction.kind = Direction::Kind::fit;
  EXPECT_THROW(require_map_direction(turned, "@raster"), UsageError);
}

TEST(Raster, StyleHasTheColoursOfTheMap) {
  const std::string style = raster_style(compared({0, 0, 0}), {});
  EXPECT_NE(style.find("singlebandpseudocolor"), std::string::npos);
  EXPECT_NE(style.find("value=\"0\" label=\"0\" color=\"#f"), std::string::npos) << style;
}

// --- profiles and outlines ---

std::vector<std::vector<double>> rows_of(const std::string& csv) {
  std::vector<std::vector<double>> rows;
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    std::vector<double>& row = rows.emplace_back();
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(cell.empty() ? NAN : std::stod(cell));
  }
  return rows;
}

TEST(Profile, IsTheValuesAtItsPlacesAndLinearBetweenThem) {
  const Point3 origin{412345.678, 5236123.456, 789.5};
  for (const Surface surface : {Surface::common, Surface::overlay}) {
    const Comparison c = compared(origin, surface, 0.2);
    const std::vector<Point2> line{
        {origin.x - 10, origin.y + 20}, {origin.x + 55, origin.y + 61}, {origin.x + 40, origin.y + 120}};
    const auto rows = rows_of(profile_csv(c, line, {}));
    ASSERT_GT(rows.size(), 50U);
    const MeasuredCells cells = measured_cells(c);
    const auto at = [&](double x, double y) {
      const Point2 place{x - cells.offset[0], y - cells.offset[1]};
      const HeightsAt found = heights_at(view_of(cells), {&place, 1}, {});
      return std::array{found.z1[0] + cells.offset[2], found.z2[0] + cells.offset[2]};
    };
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (std::isnan(rows[i][3])) continue;
      EXPECT_NEAR(rows[i][5], rows[i][4] - rows[i][3], 1e-9);
      EXPECT_NEAR(rows[i][6], 0.2, 1e-9);
      if (i + 1 == rows.size() || std::isnan(rows[i + 1][3]) || rows[i + 1][0] - rows[i][0] < 1e-6) continue;
      const auto middle = at((rows[i][1] + rows[i + 1][1]) / 2, (rows[i][2] + rows[i + 1][2]) / 2);
      if (rows[i][0] < std::hypot(65, 41) && rows[i + 1][0] > std::hypot(65, 41) + 1e-9) continue;  // a corner between
      EXPECT_NEAR(middle[0], (rows[i][3] + rows[i + 1][3]) / 2, 1e-6);
      EXPECT_NEAR(middle[1], (rows[i][4] + rows[i + 1][4]) / 2, 1e-6);
    }
    const std::string svg = profile_svg(c, line, {});
    EXPECT_EQ(svg.rfind("<svg xmlns=", 0), 0U);
    EXPECT_EQ(svg.find("figure"), std::string::npos);
    const std::vector<Point2> away{{0, 0}, {1, 1}};
    EXPECT_EQ(rows_of(profile_csv(c, away, {})).size(), 0U);
    EXPECT_THROW((void)profile_svg(c, away, {}), UsageError);
  }
}

TEST(Outlines, OfTheDomainHaveItsArea) {
  const Comparison c = compared({412345.678, 5236123.456, 789.5});
  ASSERT_FALSE(c.cells.pieces.empty());
  const auto json = nlohmann::json::parse(outlines_geojson(c, {}));
  ASSERT_EQ(json["features"].size(), 3U);
  EXPECT_NEAR(json["features"][0]["properties"]["area"].get<double>(), c.domain_area, 1e-6 * c.domain_area);
  for (const auto& feature : json["features"]) {
    EXPECT_GE(feature["properties"]["area"].get<double>(), 0.9 * c.domain_area);
    EXPECT_TRUE(feature["geometry"].is_object());
  }
}

}  // namespace
}  // namespace isopach::test
