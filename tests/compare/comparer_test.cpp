#include "isopach/compare/compare.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>

#include "tests/support/random.hpp"

namespace isopach {
namespace {

Cloud waves(std::uint64_t seed, std::size_t points) {
  test::Random random(seed);
  Cloud cloud;
  for (std::size_t i = 0; i < points; ++i) {
    const double x = random.uniform(0, 100), y = random.uniform(0, 100);
    cloud.points.push_back({x, y, std::sin(x / 9) + 0.1 * random.uniform(0, 1)});
  }
  return cloud;
}

std::int64_t faults() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  return used.ru_minflt;
}

TEST(Comparer, GivesTheBitsOfCompareAndTouchesFewNewPages) {
  const Cloud a = waves(1, 100000), b = waves(2, 100000);
  (void)compare(a, b, {}, {});
  std::int64_t before = faults();
  const Comparison once = compare(a, b, {}, {});
  const std::int64_t without = faults() - before;
  const Comparer comparer;
  (void)comparer.compare(a, b);
  before = faults();
  const Comparison again = comparer.compare(a, b);
  const std::int64_t with = faults() - before;
  EXPECT_EQ(again.measures.volume.net, once.measures.volume.net);
  EXPECT_EQ(again.measures.volume.absolute, once.measures.volume.absolute);
  if (memory_is_kept) {
    EXPECT_LT(4 * with, 3 * without);  // about half; what is left is of lists, which the heap gives back
  }
}

TEST(Comparer, ResultsOutliveIt) {
  const Cloud a = waves(1, 20000), b = waves(2, 20000);
  Comparison result;
  {
    const Comparer comparer;
    result = comparer.compare(a, b);
  }
  const Comparison once = compare(a, b, {}, {});
  ASSERT_EQ(result.cells.z1.size(), once.cells.z1.size());
  EXPECT_TRUE(std::equal(result.cells.z1.begin(), result.cells.z1.end(), once.cells.z1.begin()));
  EXPECT_TRUE(std::equal(result.cells.z2.begin(), result.cells.z2.end(), once.cells.z2.begin()));
}

}  // namespace
}  // namespace isopach
