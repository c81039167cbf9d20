// difference.ply and points_*.ply, read back.
#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>

#include "isopach/base/error.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/io/read.hpp"
#include "isopach/report/report.hpp"
#include "tests/report/sample_comparison.hpp"

namespace isopach {
namespace {

Cloud read_back(const std::string& path) {
  ReadOptions options;
  options.all_attributes = options.faces = true;
  Cloud cloud = read_cloud(path, options, {});
  std::filesystem::remove(path);
  return cloud;
}

TEST(WriteCells, HoldsTheDomainInInputCoordinates) {
  const sample::Grid grid{13, 9, 12, 8, {512300, 5405100, 40}};
  const Comparison c = sample::make(
      grid, [](double x, double) { return x; }, [](double x, double y) { return x + y - 3; },
      [](double x, double) { return x < 6; });
  const std::string path = testing::TempDir() + "isopach_cells_test.ply";
  write_cells(path, c, {});
  const Cloud cloud = read_back(path);
  EXPECT_EQ(cloud.faces.size(), 6u * 8 * 2);
  EXPECT_EQ(cloud.points.size(), 7u * 9);  // nodes with x ≤ 6; the others are left out
  const Attribute* dz = cloud.find_attribute("dz");
  ASSERT_NE(dz, nullptr);
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const double x = cloud.points[i].x - 512300, y = cloud.points[i].y - 5405100;
    EXPECT_EQ(dz->values[i], y - 3);
    EXPECT_EQ(cloud.points[i].z, 40 + x + y - 3);  // surface B
  }
  double area = 0;
  for (const auto& f : cloud.faces) {
    const Point3 &p = cloud.points[f[0]], &q = cloud.points[f[1]], &r = cloud.points[f[2]];
    const double twice = (q.x - p.x) * (r.y - p.y) - (r.x - p.x) * (q.y - p.y);
    EXPECT_GT(twice, 0);
    area += twice / 2;
  }
  EXPECT_DOUBLE_EQ(area, c.domain_area);
}

TEST(WriteOverlayCells, HoldTheAreaAndVolumeOfTheExactOverlay) {
  Cloud a, b;
  for (int i = 0; i < 400; ++i) {
    const double x = std::fmod(i * 0.754877666, 1.0) * 40, y = std::fmod(i * 0.569840291, 1.0) * 40;
    a.points.push_back({512300 + x, 5405100 + y, std::sin(x / 3)});
    b.points.push_back({512300 + y, 5405100 + 0.9 * x, std::cos(y / 3)});
  }
  CompareOptions options;
  options.surface = Surface::overlay;
  options.keep_overlay = true;
  options.uncertainty.lod = 0.5;
  const Comparison c = compare(a, b, options, {});
  const std::string path = testing::TempDir() + "isopach_overlay_cells_test.ply";
  write_overlay_cells(path, c, {});
  const Cloud cloud = read_back(path);
  const Attribute* dz = cloud.find_attribute("dz");
  ASSERT_NE(dz, nullptr);
  const Attribute *lod = cloud.find_attribute("lod"), *significant = cloud.find_attribute("significant");
  ASSERT_TRUE(lod != nullptr && significant != nullptr);
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    EXPECT_EQ(lod->values[i], 0.5);
    EXPECT_EQ(significant->values[i], std::fabs(dz->values[i]) > 0.5 ? 1 : 0);
  }
  double area = 0, net = 0;
  for (const auto& f : cloud.faces) {
    const Point3 &p = cloud.points[f[0]], &q = cloud.points[f[1]], &r = cloud.points[f[2]];
    const double twice = (q.x - p.x) * (r.y - p.y) - (r.x - p.x) * (q.y - p.y);
    area += twice / 2;
    net += twice / 6 * (dz->values[f[0]] + dz->values[f[1]] + dz->values[f[2]]);
  }
  EXPECT_NEAR(area, c.measures.area, 1e-7 * c.measures.area);  // map coordinates have nine digits before the point
  EXPECT_NEAR(net, c.measures.volume.net, 1e-6 * c.measures.volume.absolute);
}

TEST(WritePoints, KeepsEveryPointInFileOrder) {
  Cloud cloud;
  cloud.unit = "m", cloud.vertical_unit = "ft", cloud.crs = "EPSG:32610";
  PointFields fields;
  for (int i = 0; i < 1000; ++i) {
    cloud.points.push_back({512300.123 + i, 5e6 - 0.25 * i, 0.1 * i});
    fields.dz_signed.push_back(i % 7 == 0 ? std::nan("") : 0.01 * (i - 500));
  }
  const std::string path = testing::TempDir() + "isopach_points_test.ply";
  write_points(path, cloud, fields, {});
  const Cloud back = read_back(path);
  ASSERT_EQ(back.points.size(), cloud.points.size());
  EXPECT_EQ(back.unit, "m");
  EXPECT_EQ(back.vertical_unit, "ft");
  EXPECT_EQ(back.crs, "EPSG:32610");
  const Attribute *d = back.find_attribute("dz_signed"), *a = back.find_attribute("dz_abs");
  ASSERT_TRUE(d != nullptr && a != nullptr);
  for (std::size_t i = 0; i < 1000; ++i) {
    EXPECT_EQ(back.points[i], cloud.points[i]);
    if (i % 7 == 0) {
      EXPECT_TRUE(std::isnan(d->values[i]) && std::isnan(a->values[i]));
    } else {
      EXPECT_EQ(d->values[i], fields.dz_signed[i]);
      EXPECT_EQ(a->values[i], std::fabs(fields.dz_signed[i]));
    }
  }
}

TEST(WritePoints, RefusesFieldsOfAnotherCloud) {
  Cloud cloud;
  cloud.points.resize(3);
  EXPECT_THROW(write_points(testing::TempDir() + "x.ply", cloud, PointFields{}, {}), Error);
}

}  // namespace
}  // namespace isopach
