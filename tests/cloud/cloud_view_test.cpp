// Views of the caller's arrays show the points, attributes and faces of the cloud that a copy of them is, and copy
// nothing themselves.
#include "isopach/cloud/cloud_view.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <memory>
#include <ranges>
#include <type_traits>
#include <utility>
#include <vector>

#include "isopach/base/error.hpp"

namespace isopach {
namespace {

static_assert(std::ranges::random_access_range<PointsView> && std::ranges::sized_range<PointsView>);
static_assert(std::ranges::random_access_range<ValuesView> && std::ranges::sized_range<ValuesView>);
// What would dangle at once does not compile.
static_assert(!std::is_constructible_v<PointsView, Array<Point3>>);
static_assert(!std::is_constructible_v<ValuesView, Array<double>>);
static_assert(!std::is_constructible_v<CloudView, const Cloud>);
static_assert(std::convertible_to<const Cloud&, CloudView> && std::convertible_to<Cloud, CloudView>);

constexpr std::size_t n = 7, width = 5;

// Rows of five numbers, all different: x, y, z, quality, something else.
std::vector<double> table() {
  std::vector<double> rows(n * width);
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = 1000 + static_cast<double>(i * i) / 8;
  return rows;
}

Cloud copied(const std::vector<double>& rows) {
  Cloud cloud;
  cloud.attributes = {{"quality", {}}};
  for (std::size_t i = 0; i < n; ++i) {
    cloud.points.push_back({rows[i * width], rows[i * width + 1], rows[i * width + 2]});
    cloud.attributes[0].values.push_back(rows[i * width + 3]);
  }
  return cloud;
}

void expect_points(const PointsView& view, const Array<Point3>& points) {
  ASSERT_EQ(view.size(), points.size());
  EXPECT_EQ(view.empty(), points.empty());
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(view[i], points[i]) << i;
  EXPECT_TRUE(std::ranges::equal(view, points));
  EXPECT_EQ(view.copy(), points);
}

TEST(CloudView, OfRowsOfATableIsThatOfTheCopiedCloud) {
  const std::vector<double> rows = table();
  const Cloud cloud = copied(rows);
  const PointsView points(rows.data(), n, width);
  expect_points(points, cloud.points);
  const ValuesView quality(rows.data() + 3, n, width);
  EXPECT_TRUE(std::ranges::equal(quality, cloud.attributes[0].values));
  EXPECT_EQ(quality.copy(), cloud.attributes[0].values);
  for (std::size_t i = 0; i < n; ++i) EXPECT_EQ(points.address(i), &rows[i * width]) << i;
}

TEST(CloudView, OfColumnsOfRowsBackwardsAndOfOnePoint) {
  const std::vector<double> rows = table();
  const Cloud cloud = copied(rows);
  std::vector<double> x, y, z;
  for (const Point3& p : cloud.points) x.push_back(p.x), y.push_back(p.y), z.push_back(p.z);
  expect_points({x.data(), y.data(), z.data(), n}, cloud.points);
  const Array<Point3> backwards(cloud.points.rbegin(), cloud.points.rend());
  expect_points({rows.data() + (n - 1) * width, n, -static_cast<std::ptrdiff_t>(width)}, backwards);
  expect_points({rows.data(), 4, 0}, Array<Point3>(4, cloud.points[0]));
}

TEST(CloudView, OfNothingIsEmpty) {
  expect_points({}, {});
  expect_points({static_cast<const double*>(nullptr), 0}, {});
  const Array<Point3> none;
  expect_points(none, none);
  EXPECT_TRUE(ValuesView().empty());
  const CloudView view;
  EXPECT_TRUE(view.points.empty() && view.faces.empty() && view.find_attribute("") == nullptr);
  EXPECT_EQ(view.unit, Cloud{}.unit);
}

TEST(CloudView, IteratorsGoAnywhere) {
  const std::vector<double> rows = table();
  const PointsView points(rows.data(), n, width);
  auto i = points.begin() + 3;
  EXPECT_EQ(*i, points[3]);
  EXPECT_EQ(i[2], points[5]);
  EXPECT_EQ(*(i - 2), points[1]);
  EXPECT_EQ(*(1 + i), points[4]);
  EXPECT_EQ(*i++, points[3]);
  EXPECT_EQ(*i--, points[4]);
  EXPECT_EQ(*--i, points[2]);
  EXPECT_EQ(*++i, points[3]);
  EXPECT_EQ(points.end() - i, static_cast<std::ptrdiff_t>(n) - 3);
  EXPECT_TRUE(i > points.begin() && i < points.end() && i != points.end() && i - 3 == points.begin());
  const auto highest = std::ranges::max_element(points, {}, [](const Point3& p) { return p.z; });
  EXPECT_EQ(highest, points.end() - 1);
}

TEST(CloudView, OfACloudRefersToItsArraysAndHasItsWords) {
  Cloud cloud = copied(table());
  cloud.faces = {{0, 1, 2}, {2, 3, 4}};
  cloud.path = "scan.ply", cloud.format = "ply", cloud.unit = "mm", cloud.vertical_unit = "m", cloud.crs = "EPSG:2056";
  cloud.grid = RasterGrid{3, 2, {}};
  cloud.nodata = 4;
  cloud.notes = {"a remark"};
  const CloudView view = cloud;
  EXPECT_EQ(view.points.address(0), &cloud.points[0].x);
  EXPECT_EQ(view.faces.data(), cloud.faces.data());
  EXPECT_EQ(view.faces.size(), 2u);
  ASSERT_NE(view.find_attribute("quality"), nullptr);
  EXPECT_EQ(view.find_attribute("nothing"), nullptr);
  cloud.attributes[0].values[2] = -1, cloud.points[1] = {4, 5, 6};  // what is shown is the cloud, not a copy
  EXPECT_EQ(view.find_attribute("quality")->values[2], -1);
  EXPECT_EQ(view.points[1], (Point3{4, 5, 6}));
  EXPECT_EQ(view.path, cloud.path);
  EXPECT_EQ(view.format, cloud.format);
  EXPECT_EQ(view.unit, cloud.unit);
  EXPECT_EQ(view.vertical_unit, cloud.vertical_unit);
  EXPECT_EQ(view.crs, cloud.crs);
  ASSERT_TRUE(view.grid.has_value());
  EXPECT_EQ(view.grid->columns, 3u);
  EXPECT_EQ(view.nodata, cloud.nodata);
  EXPECT_EQ(view.notes, cloud.notes);
  EXPECT_EQ(view.owner, nullptr);

  const Cloud own = copy_of(view);
  EXPECT_EQ(own.points, cloud.points);
  EXPECT_NE(own.points.data(), cloud.points.data());
  EXPECT_EQ(own.faces, cloud.faces);
  ASSERT_EQ(own.attributes.size(), 1u);
  EXPECT_EQ(own.attributes[0].name, "quality");
  EXPECT_EQ(own.attributes[0].values, cloud.attributes[0].values);
  EXPECT_EQ(own.path, cloud.path);
  EXPECT_EQ(own.format, cloud.format);
  EXPECT_EQ(own.unit, cloud.unit);
  EXPECT_EQ(own.vertical_unit, cloud.vertical_unit);
  EXPECT_EQ(own.crs, cloud.crs);
  EXPECT_TRUE(own.grid.has_value());
  EXPECT_EQ(own.nodata, cloud.nodata);
  EXPECT_EQ(own.notes, cloud.notes);
}

TEST(CloudView, RefusesAttributesOfAnotherLengthAndFacesWithoutTheirPoints) {
  const std::vector<double> rows = table();
  CloudView view{PointsView(rows.data(), n, width)};
  view.attributes = {{"short", {rows.data(), n - 1, width}}, {"right", {rows.data(), n, width}}};
  EXPECT_NE(view.find_attribute("right"), nullptr);
  EXPECT_THROW((void)view.find_attribute("short"), InputError);
  std::vector<std::array<Index, 3>> faces{{0, 1, 2}, {4, 5, 6}};
  view.faces = faces;
  EXPECT_NO_THROW(check_faces(view));
  faces[1][2] = n;
  EXPECT_THROW(check_faces(view), InputError);
}

TEST(CloudView, OfATemporaryCloudOwnsIt) {
  Cloud cloud = copied(table());
  const Array<Point3> points = cloud.points;
  const double* const at = &cloud.points[0].x;
  CloudView last;
  {
    const CloudView view = std::move(cloud);
    EXPECT_EQ(view.points.address(0), at);  // taken over, not copied
    last = view;
    EXPECT_EQ(view.owner.use_count(), 2);
  }
  EXPECT_EQ(last.owner.use_count(), 1);
  expect_points(last.points, points);

  const auto shared = std::make_shared<const Cloud>(copied(table()));
  const CloudView view(shared);
  EXPECT_EQ(view.points.address(0), &shared->points[0].x);
  EXPECT_EQ(shared.use_count(), 2);
}

}  // namespace
}  // namespace isopach
