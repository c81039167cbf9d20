// The kernel and its tests are built twice more: with every a·b + c contracted to a fused multiply-add, and with none
// (tests/CMakeLists.txt). The tests beside this one in the same program prove that predicates and triangulations equal
// the big integers both ways; this one proves that the build is what it says.
#include <gtest/gtest.h>

namespace isopach::test {
namespace {

double product_minus(double a, double b, double c) { return a * b - c; }

TEST(Contraction, IsOnOrOffAsThisBuildSays) {
  const volatile double x = 1 + 0x1p-30;  // x² = 1 + 2⁻²⁹ + 2⁻⁶⁰, the last term lost by rounding
  const volatile double rounded = x * x;
#if defined(ISOPACH_CONTRACTED)
  EXPECT_EQ(product_minus(x, x, rounded), 0x1p-60);
#else
  EXPECT_EQ(product_minus(x, x, rounded), 0.0);
#endif
}

}  // namespace
}  // namespace isopach::test
