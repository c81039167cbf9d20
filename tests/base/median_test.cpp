#include "isopach/base/median.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "isopach/base/random.hpp"

namespace isopach {
namespace {

TEST(Median, IsTheMiddleOfTheSorted) {
  const RandomStream random(3, 0);
  for (std::size_t n = 1; n < 40; ++n) {
    std::vector<double> values(n);
    for (std::size_t i = 0; i < n; ++i) values[i] = std::floor(10 * random.normal(100 * n + i));  // with ties
    std::vector<double> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    EXPECT_EQ(median(values), sorted[n / 2]) << n;
  }
  std::vector<double> none;
  EXPECT_EQ(median(none), 0);
}

TEST(Median, OfAbsoluteDeviationsGivesTheStandardDeviation) {
  const RandomStream random(5, 0);
  std::vector<double> sizes(200000);
  for (std::size_t i = 0; i < sizes.size(); ++i) sizes[i] = std::fabs(3 * random.normal(i));
  EXPECT_NEAR(mad_to_sigma * median(sizes), 3, 0.03);
}

}  // namespace
}  // namespace isopach
