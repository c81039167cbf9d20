// Contours: d at their corners, lengths against every triangle on its own, ends on the border alone.
#include "isopach/compare/contour_lines.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "isopach/base/error.hpp"
#include "isopach/compare/compare.hpp"
#include "tests/support/clouds.hpp"

namespace isopach::test {
namespace {

double length_of(const ContourLine& line) {
  double length = 0;
  for (std::size_t i = 1; i < line.xy.size(); ++i)
    length += std::hypot(line.xy[i].x - line.xy[i - 1].x, line.xy[i].y - line.xy[i - 1].y);
  return length;
}

// Of the border of {d ≥ level} inside one triangle.
double stretch(const MeshView& mesh, std::size_t triangle, double level) {
  std::vector<Point2> ends;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto a = static_cast<std::size_t>(mesh.triangles[triangle][k]),
               b = static_cast<std::size_t>(mesh.triangles[triangle][(k + 1) % 3]);
    const double da = mesh.z2[a] - mesh.z1[a] - level, db = mesh.z2[b] - mesh.z1[b] - level;
    if ((da >= 0) == (db >= 0)) continue;
    const double u = da / (da - db);
    ends.push_back(
        {mesh.xy[a].x + u * (mesh.xy[b].x - mesh.xy[a].x), mesh.xy[a].y + u * (mesh.xy[b].y - mesh.xy[a].y)});
  }
  return ends.size() == 2 ? std::hypot(ends[0].x - ends[1].x, ends[0].y - ends[1].y) : 0;
}

// Sides that one triangle alone has.
std::vector<std::array<Point2, 2>> border_of(const MeshView& mesh) {
  std::map<std::array<std::int32_t, 2>, int> count;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) ++count[{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])}];
  std::vector<std::array<Point2, 2>> border;
  for (const auto& [side, n] : count)
    if (n == 1)
      border.push_back({mesh.xy[static_cast<std::size_t>(side[0])], mesh.xy[static_cast<std::size_t>(side[1])]});
  return border;
}

bool lies_on(const std::vector<std::array<Point2, 2>>& border, const Point2& p) {
  return std::any_of(border.begin(), border.end(), [&](const auto& s) {
    const double x = s[1].x - s[0].x, y = s[1].y - s[0].y, length = std::hypot(x, y);
    const double along = ((p.x - s[0].x) * x + (p.y - s[0].y) * y) / length;
    return std::fabs((p.x - s[0].x) * y - (p.y - s[0].y) * x) / length < 1e-9 && along > -1e-9 && along < length + 1e-9;
  });
}

void expect_contours(const MeshView& mesh, double step) {
  const std::vector<ContourLine> lines = contour_lines(mesh, step, "@contours", {});
  const auto border = border_of(mesh);
  std::map<double, double> lengths;
  for (const ContourLine& line : lines) {
    lengths[line.level] += length_of(line);
    ASSERT_GE(line.xy.size(), 2U);
    if (!(line.xy.front() == line.xy.back())) {
      EXPECT_TRUE(lies_on(border, line.xy.front())) << line.level << " of " << line.xy.size();
      EXPECT_TRUE(lies_on(border, line.xy.back())) << line.xy.back().x << ", " << line.xy.back().y;
    }
    const HeightsAt at = heights_at(mesh, line.xy, {});
    for (std::size_t i = 0; i < line.xy.size(); ++i) {
      if (std::isnan(at.z1[i])) continue;  // on the border, by rounding beside it
      EXPECT_NEAR(at.z2[i] - at.z1[i], line.level, 1e-9);
    }
  }
  for (double k = -20; k <= 20; ++k) {
    double length = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) length += stretch(mesh, t, k * step);
    EXPECT_NEAR(lengths[k * step], length, 1e-10 * (1 + length)) << k * step;
  }
}

TEST(ContourLines, AreTheStretchesOfAllTrianglesJoined) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    SCOPED_TRACE(seed);
    CompareOptions o;
    o.check_layers = false;
    o.border = BorderRule::hull;
    Cloud a = rough_cloud(uniform(150, seed), seed + 1), b = rough_cloud(uniform(150, seed), seed + 2);
    for (Cloud* cloud : {&a, &b})  // of the same places, so that d is as coarse as the heights: many nodes on a level
      for (Point3& p : cloud->points) p.z = std::round(8 * p.z) / 8;
    const MeasuredCells cells = measured_cells(compare(a, b, o, {}));
    expect_contours(view_of(cells), 0.125);
    expect_contours(view_of(cells), 0.3);
  }
}

TEST(ContourLines, OfAPyramidAreSquares) {
  MeasuredCells m;
  m.xy = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}, {0, 0}};
  m.z1.assign(5, 0.0), m.z2 = {0.5, 0.5, 0.5, 0.5, 2.5};
  m.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  const std::vector<ContourLine> lines = contour_lines(view_of(m), 1, "@contours", {});
  ASSERT_EQ(lines.size(), 2U);
  for (const ContourLine& line : lines) {
    EXPECT_EQ(line.xy.front(), line.xy.back());
    EXPECT_EQ(line.xy.size(), 5U);
    EXPECT_NEAR(length_of(line), 8 * (2.5 - line.level) / 2, 1e-14);
  }
  EXPECT_THROW((void)contour_lines(view_of(m), 1e-5, "@contours", {}), UsageError);
  m.z2.assign(5, 0.0);
  EXPECT_TRUE(contour_lines(view_of(m), 1, "@contours", {}).empty());
}

TEST(ContourLines, JoinWhereABorderCutsCells) {
  CompareOptions o;
  o.check_layers = false;
  Cloud a = rough_cloud(uniform(2000, 1), 2), b = a;
  for (Point3& p : b.points) p.z += 3 * p.x + p.y;  // contours are straight lines right across
  for (Point3& p : a.points) p.z += 0;
  const MeasuredCells cells = in_order(measured_cells(compare(a, b, o, {})));
  const auto lines = contour_lines(view_of(cells), 0.5, "@contours", {});
  std::map<double, int> parts;
  for (const ContourLine& line : lines) ++parts[line.level];
  for (const double level : {1.0, 1.5, 2.0, 2.5, 3.0}) EXPECT_EQ(parts[level], 1) << level;
}

}  // namespace
}  // namespace isopach::test
