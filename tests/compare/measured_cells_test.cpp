// Cells as one mesh: sections against values at places, levels at the corners of pieces.
#include "isopach/compare/measured_cells.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "isopach/compare/compare.hpp"
#include "tests/support/clouds.hpp"

namespace isopach::test {
namespace {

TEST(MeasuredCells, HaveTheLevelAtTheCornersOfPiecesToo) {
  CompareOptions o;
  o.check_layers = false;
  o.uncertainty.lod = 0.25;
  const Comparison c = compare(rough_cloud(uniform(300, 1), 2), rough_cloud(uniform(300, 3), 4), o, {});
  ASSERT_FALSE(c.cells.pieces.empty());
  const MeasuredCells m = measured_cells(c);
  ASSERT_EQ(m.lod.size(), m.xy.size());
  for (const double level : m.lod) EXPECT_NEAR(level, 0.25, 1e-15);
}

TEST(MeasuredCells, InOrderAreTheSameTriangles) {
  CompareOptions o, other;
  o.check_layers = other.check_layers = false;
  o.locate = LocateMethod::tree, other.locate = LocateMethod::interface;
  const Cloud a = rough_cloud(uniform(500, 1), 2), b = rough_cloud(uniform(600, 3), 4);
  EXPECT_EQ(in_order(measured_cells(compare(a, b, o, {}))).triangles,
            in_order(measured_cells(compare(a, b, other, {}))).triangles);
}

}  // namespace
}  // namespace isopach::test
