// When the summary and the report tell ρ_dV.
#include "isopach/report/page/detail_told.hpp"

#include <gtest/gtest.h>

#include "isopach/compare/compare.hpp"
#include "isopach/report/page/text.hpp"
#include "isopach/report/report.hpp"
#include "tests/support/clouds.hpp"

namespace isopach::test {
namespace {

Comparison of(std::size_t points_a, std::size_t points_b, MeasureKind measure = MeasureKind::V) {
  const auto scan = [](std::size_t points, std::uint64_t seed) {
    return cloud_over(framed_square(points, seed), [](const Point2& p) { return p.x * p.y; });
  };
  CompareOptions options;
  options.measure = measure;
  return compare(scan(points_a, 1), scan(points_b, 2), options, {});
}

TEST(DetailTold, WhereDensitiesDifferOrItWasAskedFor) {
  EXPECT_FALSE(tells_detail(of(400, 400)));
  EXPECT_FALSE(tells_detail(of(400, 440)));
  EXPECT_TRUE(tells_detail(of(400, 800)));
  EXPECT_TRUE(tells_detail(of(800, 400)));
  EXPECT_TRUE(tells_detail(of(400, 400, MeasureKind::dV)));
  EXPECT_EQ(comparison_text(of(400, 400), {}).find("rho_dV"), std::string::npos);
  EXPECT_NE(comparison_text(of(400, 800), {}).find("rho_dV"), std::string::npos);
}

}  // namespace
}  // namespace isopach::test
