#include "isopach/cloud/raster_values.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "isopach/base/error.hpp"

namespace isopach {
namespace {

/// 2 × 2 cells of 10 by 10, north up, the last without data.
Cloud four_cells() {
  Cloud cloud;
  cloud.path = "r.asc";
  cloud.crs = "EPSG:25832";
  cloud.grid = RasterGrid{2, 2, {100, 10, 0, 220, 0, -10}};
  cloud.points = {{105, 215, 1}, {115, 215, 2}, {105, 205, 3}};
  return cloud;
}

TEST(RasterValues, HoldsTheCells) {
  const RasterValues r(four_cells());
  EXPECT_EQ(r.crs(), "EPSG:25832");
  EXPECT_EQ(r.value(0, 0), 1);
  EXPECT_EQ(r.value(1, 0), 2);
  EXPECT_EQ(r.value(0, 1), 3);
  EXPECT_TRUE(std::isnan(r.value(1, 1)));
  EXPECT_EQ(r.at({100, 220, 0}), 1);
  EXPECT_EQ(r.at({120, 211, 0}), 2);  // the far rim is of the last cell
  EXPECT_TRUE(std::isnan(r.at({99.9, 215, 0})));
  EXPECT_TRUE(std::isnan(r.at({115, 205, 0})));
}

TEST(RasterValues, CopiesOutliveTheFirst) {
  std::optional<RasterValues> first(four_cells());
  const RasterValues copy = *first;
  first.reset();
  EXPECT_EQ(copy.at({106, 203, 0}), 3);
}

TEST(RasterValues, RefusesAPointOutsideItsGrid) {
  Cloud cloud = four_cells();
  cloud.points.push_back({200, 0, 1});
  try {
    (void)RasterValues(cloud);
    ADD_FAILURE();
  } catch (const InputError& e) {
    EXPECT_EQ(std::string(e.what()).rfind("r.asc: ", 0), 0u) << e.what();
  }
}

}  // namespace
}  // namespace isopach
