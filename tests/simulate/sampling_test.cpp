#include "isopach/simulate/sampling.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "isopach/base/parallel.hpp"

namespace isopach {
namespace {

const Outline irregular_footprint{{0, 12}, {31, 0}, {78, 5}, {100, 34}, {94, 71}, {58, 90}, {11, 66}};

Outline oval() {
  Outline polygon;
  for (int i = 0; i < 48; ++i) {
    const double angle = 2 * std::numbers::pi * i / 48;
    polygon.push_back({88 * std::cos(angle), 118 * std::sin(angle)});
  }
  return polygon;
}

std::vector<Outline> footprints() {
  return {rectangle({0, 0}, {100, 100}), rectangle({412000, 5236000}, {413000, 5236500}), irregular_footprint, oval()};
}

const ScanPattern patterns[] = {{},
                                {0.02, 1, 0, false, 1, 0.1},
                                {0.14, 2, 0.2, true, 1.4, 0.15},
                                {1.69, 2, 0.3, false, 1.2, 0.2},
                                {-2.5, 3, 0.1, true, 2, 0.4}};

std::size_t duplicates(Array<Point2> nodes) {
  std::sort(nodes.begin(), nodes.end(), lexicographic_less);
  return nodes.size() - static_cast<std::size_t>(std::unique(nodes.begin(), nodes.end()) - nodes.begin());
}

/// Nodes per cell of a grid over the box, row by row.
std::vector<double> counts(const Array<Point2>& nodes, const Point2& min, const Point2& max, std::size_t columns,
                           std::size_t rows) {
  std::vector<double> cells(columns * rows);
  for (const Point2& p : nodes) {
    const double cx = (p.x - min.x) / (max.x - min.x) * static_cast<double>(columns);
    const double cy = (p.y - min.y) / (max.y - min.y) * static_cast<double>(rows);
    cells[std::min(static_cast<std::size_t>(cy), rows - 1) * columns +
          std::min(static_cast<std::size_t>(cx), columns - 1)] += 1;
  }
  return cells;
}

TEST(Outline, AreaAndContains) {
  EXPECT_EQ(polygon_area(rectangle({-1, 2}, {3, 7})), 20);
  EXPECT_NEAR(polygon_area(oval()), 24 * 88 * 118 * std::sin(2 * std::numbers::pi / 48), 1e-9);
  for (const Point2& corner : irregular_footprint) EXPECT_TRUE(contains(irregular_footprint, corner));
  EXPECT_TRUE(contains(irregular_footprint, {50, 40}));
  EXPECT_FALSE(contains(irregular_footprint, {1, 1}));
  EXPECT_FALSE(contains(irregular_footprint, {97, 80}));
}

TEST(ScanNodes, AreAboutAsManyAsAskedForAndInside) {
  for (const Outline& footprint : footprints())
    for (const ScanPattern& pattern : patterns)
      for (const std::size_t count : {1000U, 50000U}) {
        const Array<Point2> nodes = scan_nodes(footprint, count, pattern, {1, 1});
        // The number of lines that meet the border is uncertain by a few: so is the count, by a few lines.
        EXPECT_NEAR(static_cast<double>(nodes.size()), static_cast<double>(count),
                    2.5 * std::sqrt(static_cast<double>(count)));
        EXPECT_TRUE(std::all_of(nodes.begin(), nodes.end(), [&](const Point2& p) { return contains(footprint, p); }));
        EXPECT_EQ(duplicates(nodes), 0U);
      }
}

TEST(ScanNodes, LeaveNoHoleUpToTheBorder) {
  for (const ScanPattern& pattern : patterns) {
    const Array<Point2> nodes = scan_nodes(rectangle({0, 0}, {100, 100}), 40000, pattern, {1, 1});
    const std::vector<double> cells = counts(nodes, {0, 0}, {100, 100}, 50, 50);  // cells of 4 by 4 spacings
    EXPECT_GE(*std::min_element(cells.begin(), cells.end()), 2) << pattern.heading;
  }
}

TEST(ScanNodes, DensityDoublesWhereStripsOverlap) {
  ScanPattern pattern{0, 2, 0.25, true, 1, 0.1};
  const Array<Point2> nodes = scan_nodes(rectangle({0, 0}, {70, 70}), 100000, pattern, {1, 1});
  const std::vector<double> bands = counts(nodes, {0, 0}, {70, 70}, 1, 7);  // strips 0–40 and 30–70
  const double single = 100000 / 8.0;
  for (std::size_t i = 0; i < 7; ++i) EXPECT_NEAR(bands[i] / single, i == 3 ? 2 : 1, 0.03) << i;
}

TEST(ScanNodes, LinesRunAcrossTheHeading) {
  // Without jitter the points of a line of a turning mirror lie on one straight line, nearly across the flight.
  const ScanPattern pattern{0.5, 1, 0, false, 1, 0};
  const Array<Point2> nodes = scan_nodes(rectangle({0, 0}, {100, 100}), 10000, pattern, {1, 1});
  std::size_t along_line = 0;
  for (std::size_t i = 1; i < nodes.size(); ++i) {
    const double dx = nodes[i].x - nodes[i - 1].x, dy = nodes[i].y - nodes[i - 1].y;
    const double flight = std::cos(0.5) * dx + std::sin(0.5) * dy, across = std::cos(0.5) * dy - std::sin(0.5) * dx;
    if (std::fabs(across - 1) < 0.02 && std::fabs(flight) < 0.02) ++along_line;
  }
  EXPECT_GT(along_line, nodes.size() * 98 / 100);  // the others begin a line
}

TEST(ScanNodes, StretchSetsLinesApart) {
  for (const double stretch : {0.5, 1.0, 2.0}) {
    const Array<Point2> nodes = scan_nodes(rectangle({0, 0}, {100, 100}), 10000, {0, 1, 0, false, stretch, 0}, {1, 1});
    const double step = nodes[1].y - nodes[0].y, lines = static_cast<double>(nodes.size()) / (100 / step);
    EXPECT_NEAR(100 / lines / step, stretch, 0.03 * stretch);
  }
}

TEST(IrregularNodes, AreUniform) {
  const Array<Point2> nodes = irregular_nodes(rectangle({-10, 5}, {10, 45}), 100000, {1, 1});
  EXPECT_EQ(nodes.size(), 100000U);
  double chi2 = 0;
  for (const double c : counts(nodes, {-10, 5}, {10, 45}, 20, 40)) chi2 += (c - 125) * (c - 125) / 125;
  EXPECT_NEAR(chi2, 799, 4 * std::sqrt(2 * 799.0));
}

TEST(IrregularNodes, FillAnyFootprintWithTheExactCount) {
  for (const Outline& footprint : footprints()) {
    const Array<Point2> nodes = irregular_nodes(footprint, 20000, {1, 1});
    EXPECT_EQ(nodes.size(), 20000U);
    EXPECT_TRUE(std::all_of(nodes.begin(), nodes.end(), [&](const Point2& p) { return contains(footprint, p); }));
    EXPECT_EQ(duplicates(nodes), 0U);
    // A fan of triangles from corner 0: each holds its share.
    for (std::size_t i = 2; i < footprint.size(); ++i) {
      const Outline triangle{footprint[0], footprint[i - 1], footprint[i]};
      const double share = polygon_area(triangle) / polygon_area(footprint);
      const auto held = static_cast<double>(
          std::count_if(nodes.begin(), nodes.end(), [&](const Point2& p) { return contains(triangle, p); }));
      EXPECT_NEAR(held, 20000 * share, 4.5 * std::sqrt(20000 * share * (1 - share)) + 1);
    }
  }
}

TEST(BorderedNodes, HaveTheFootprintAsTheirHullExactly) {
  for (const Outline& footprint : {rectangle({-50, -50}, {50, 50}), irregular_footprint})
    for (const std::size_t count : {4U, 10U, 100U, 30000U}) {
      const Array<Point2> nodes = bordered_nodes(footprint, count, {3, 2});
      EXPECT_EQ(nodes.size(), std::max<std::size_t>(count, footprint.size()));
      EXPECT_EQ(duplicates(nodes), 0U);
      // contains() is exact on the sides here: whole numbers and multiples of 2^-20.
      EXPECT_TRUE(std::all_of(nodes.begin(), nodes.end(), [&](const Point2& p) { return contains(footprint, p); }));
      for (std::size_t i = 0; i < footprint.size(); ++i) {
        const Point2 p = footprint[i], q = footprint[(i + 1) % footprint.size()];
        EXPECT_EQ(std::count(nodes.begin(), nodes.end(), p), 1);
        const auto on_side = std::count_if(nodes.begin(), nodes.end(), [&](const Point2& m) {
          return (q.x - p.x) * (m.y - p.y) - (q.y - p.y) * (m.x - p.x) == 0;
        });
        const double spacing = std::sqrt(polygon_area(footprint) / static_cast<double>(count));
        if (count == 30000) {
          EXPECT_NEAR(static_cast<double>(on_side), std::hypot(q.x - p.x, q.y - p.y) / spacing, 3);
        }
      }
    }
}

TEST(Nodes, DependOnSeedAndScanAloneNotOnThreads) {
  const Outline footprint = irregular_footprint;
  const auto all = [&](const Draw& draw) {
    return std::vector<Array<Point2>>{scan_nodes(footprint, 30000, patterns[2], draw),
                                      irregular_nodes(footprint, 30000, draw), bordered_nodes(footprint, 30000, draw)};
  };
  std::vector<Array<Point2>> one, seven;
  run_with_threads(1, [&] { one = all({11, 1}); });
  run_with_threads(7, [&] { seven = all({11, 1}); });
  EXPECT_EQ(one, seven);
  for (const Draw& other : {Draw{12, 1}, Draw{11, 2}}) {
    const std::vector<Array<Point2>> changed = all(other);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NE(one[i], changed[i]);
  }
}

}  // namespace
}  // namespace isopach
