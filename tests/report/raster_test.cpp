// rasterise: one owner per pixel, chosen by the pixel's centre. Oracle: point in triangle, pixel by pixel.
#include <cmath>

#include <gtest/gtest.h>

#include "isopach/base/parallel.hpp"
#include "isopach/report/draw/hillshade.hpp"
#include "isopach/report/draw/raster.hpp"
#include "tests/report/sample_comparison.hpp"

namespace isopach {
namespace {

using Cover = CellRaster::Cover;

Point2 centre(const MapView& v, int column, int row) {
  return {v.left + (column + 0.5) / v.scale, v.top - (row + 0.5) / v.scale};
}

double cross(const Point2& a, const Point2& b, const Point2& p) {
  return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

/// Skews a grid so that no side is upright or level and node spacing is uneven.
Comparison skewed() {
  Comparison c = sample::make(
      {23, 17, 11, 8}, [](double x, double y) { return 0.3 * x - 0.2 * y; },
      [](double x, double y) { return std::sin(x) + y; }, [](double x, double y) { return x + y < 13; });
  for (Point2& p : c.cells.xy)
    p = {p.x + 0.13 * p.y + 0.1 * std::sin(p.y), p.y + 0.21 * p.x + 0.07 * std::cos(3 * p.x)};
  return c;
}

TEST(Raster, EveryPixelBelongsToTheTriangleThatHoldsItsCentre) {
  const Comparison c = skewed();
  const MapView view{-1.03, 11.57, 9.7, 140, 130};
  const CellRaster r = rasterise(c.cells, view);
  std::size_t covered = 0;
  for (int row = 0; row < view.rows; ++row)
    for (int column = 0; column < view.columns; ++column) {
      const Point2 p = centre(view, column, row);
      const std::size_t i = static_cast<std::size_t>(row * view.columns + column);
      Cover expected = Cover::none;
      double d = 0;
      for (Index t = 0; t < c.cells.triangulation.real; ++t) {
        const auto& v = c.cells.triangulation.triangles[t].v;
        const std::array<Point2, 3> q{c.cells.xy[v[0]], c.cells.xy[v[1]], c.cells.xy[v[2]]};
        const double w0 = cross(q[1], q[2], p), w1 = cross(q[2], q[0], p), w2 = cross(q[0], q[1], p);
        if (w0 < 0 || w1 < 0 || w2 < 0) continue;
        expected = c.cells.in_domain[t] != 0 ? Cover::domain : Cover::footprint;
        d = (w0 * c.cells.d(v[0]) + w1 * c.cells.d(v[1]) + w2 * c.cells.d(v[2])) / (w0 + w1 + w2);
      }
      ASSERT_EQ(static_cast<int>(r.cover[i]), static_cast<int>(expected)) << column << " " << row;
      if (expected != Cover::domain) continue;
      ++covered;
      ASSERT_NEAR(r.d[i], d, 1e-5) << column << " " << row;
    }
  EXPECT_GT(covered, 1000u);
}

TEST(Raster, CoveredPixelsAreTheAreaUpToTheBorder) {
  const Comparison c = sample::make(
      {60, 40, 10, 7}, [](double, double) { return 0; }, [](double, double) { return 1; },
      [](double x, double y) { return std::hypot(x - 5, y - 3.5) < 3; });
  const MapView view{-0.5, 7.5, 50, 550, 400};
  const CellRaster r = rasterise(c.cells, view);
  double pixels = 0;
  for (const Cover cover : r.cover) pixels += cover == Cover::domain;
  const double border = 2 * 2 * (6 + 6) * view.scale;  // a staircase round the disc, a pixel to either side
  EXPECT_NEAR(pixels, c.domain_area * view.scale * view.scale, border);
}

TEST(Raster, CentresOnSharedSidesHaveOneOwner) {
  // Nodes on pixel centres: every pixel is a tie. 4 × 4 units at 1 pixel a unit: half-open, so exactly 16 pixels.
  const Comparison c = sample::make(
      {5, 5, 4, 4}, [](double, double) { return 0; }, [](double x, double) { return x; });
  const CellRaster r = rasterise(c.cells, {-1.5, 6.5, 1, 8, 8});
  std::size_t pixels = 0;
  for (const Cover cover : r.cover) pixels += cover == Cover::domain;
  EXPECT_EQ(pixels, 16u);
}

TEST(Raster, NorthIsUp) {
  const Comparison c = sample::make(
      {11, 11, 10, 10}, [](double, double) { return 0; }, [](double, double y) { return y; });
  const CellRaster r = rasterise(c.cells, {0, 10, 2, 20, 20});
  EXPECT_NEAR(r.d[10], 9.75, 1e-6);            // first row
  EXPECT_NEAR(r.d[19 * 20 + 10], 0.25, 1e-6);  // last row
}

TEST(Raster, AWindowIsTheSameAsAPartOfTheWhole) {
  const Comparison c = skewed();
  const CellRaster whole = rasterise(c.cells, {0, 10, 8, 96, 80});
  const CellRaster window = rasterise(c.cells, {2, 8, 8, 40, 32});
  for (std::size_t row = 0; row < 32; ++row)
    for (std::size_t column = 0; column < 40; ++column) {
      const std::size_t i = (row + 16) * 96 + column + 16, k = row * 40 + column;
      ASSERT_EQ(static_cast<int>(whole.cover[i]), static_cast<int>(window.cover[k])) << row << " " << column;
      if (whole.cover[i] == Cover::domain) {
        ASSERT_NEAR(whole.d[i], window.d[k], 1e-6);
      }
    }
}

TEST(Raster, TheSameForAnyNumberOfThreads) {
  const Comparison c = skewed();
  const MapView view{-1, 12, 40, 600, 500};
  std::vector<CellRaster> rasters(3);
  for (std::size_t k = 0; k < 3; ++k)
    run_with_threads(std::array<int, 3>{1, 2, 7}[k], [&] { rasters[k] = rasterise(c.cells, view); });
  for (std::size_t k = 1; k < 3; ++k) {
    EXPECT_EQ(rasters[0].cover, rasters[k].cover);
    for (std::size_t i = 0; i < rasters[0].d.size(); ++i)
      if (rasters[0].cover[i] == Cover::domain) {
        ASSERT_EQ(rasters[0].d[i], rasters[k].d[i]);
        ASSERT_EQ(rasters[0].z[i], rasters[k].z[i]);
      }
  }
}

TEST(Raster, NoCellsGiveAnEmptyPicture) {
  const CellRaster r = rasterise(Cells{}, {0, 1, 10, 10, 10});
  for (const Cover cover : r.cover) EXPECT_EQ(static_cast<int>(cover), static_cast<int>(Cover::none));
}

TEST(Hillshade, SlopesFacingNorthWestAreBrighterThanSlopesFacingSouthEast) {
  const auto grey = [](double slope_x, double slope_y) {
    const Comparison c = sample::make(
        {11, 11, 10, 10}, [&](double x, double y) { return slope_x * x + slope_y * y; },
        [](double, double) { return 0; });
    const Hillshade h = hillshade(rasterise(c.cells, {0, 10, 5, 50, 50}));
    for (const float g : h.grey) {
      EXPECT_GE(g, 0.35F);
      EXPECT_LE(g, 1.0F);
    }
    return h.grey[25 * 50 + 25];
  };
  EXPECT_GT(grey(0.2, -0.2), grey(0, 0));  // rises to the south-east: faces the light
  EXPECT_LT(grey(-0.2, 0.2), grey(0, 0));
}

TEST(Hillshade, FlatAndSteepScenesAreBroughtToTheSameContrast) {
  const auto shade = [](double factor) {
    const Comparison c = sample::make(
        {60, 60, 10, 10}, [&](double x, double y) { return factor * std::sin(x) * std::sin(y); },
        [](double, double) { return 0; });
    return hillshade(rasterise(c.cells, {0, 10, 10, 100, 100}));
  };
  const Hillshade flat = shade(0.1), steep = shade(5);
  EXPECT_NEAR(flat.exaggeration / steep.exaggeration, 50, 0.1);
  for (std::size_t i = 0; i < flat.grey.size(); ++i) ASSERT_NEAR(flat.grey[i], steep.grey[i], 1e-3);
}

}  // namespace
}  // namespace isopach
