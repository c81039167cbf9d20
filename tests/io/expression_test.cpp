#include "isopach/io/expression.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>

#include "isopach/base/error.hpp"

namespace isopach {
namespace {

TEST(Expression, NamesWhatAPlaceHas) {
  Expression f("x + 10*y + 100*z1 + 1000*z2 + 10000*slope1 + 100000*slope2", "@weight");
  EXPECT_EQ(f({1, 2, 3, 4, 5, 6}), 654321);
  EXPECT_TRUE(std::isnan(Expression("sqrt(x)", "@weight")({-1, 0, 0, 0, 0, 0})));
}

// Each task has a copy: one that still read the variables of the first would change with it, or outlive it.
TEST(Expression, CopiesAreOfTheirOwn) {
  auto first = std::make_unique<Expression>("2 * x", "@weight");
  std::function<double(const Place&)> second = *first;
  std::function<double(const Place&)> third = second;
  EXPECT_EQ((*first)({1, 0, 0, 0, 0, 0}), 2);
  EXPECT_EQ(second({5, 0, 0, 0, 0, 0}), 10);
  first.reset();
  EXPECT_EQ(third({7, 0, 0, 0, 0, 0}), 14);
  EXPECT_EQ(second({-1, 0, 0, 0, 0, 0}), -2);
}

TEST(Expression, RefusesWhatIsNone) {
  for (const char* text : {"", "x +", "w", "x = 2", "x, y", "x\ny"}) {
    try {
      (void)Expression(text, "@weight");
      ADD_FAILURE() << text;
    } catch (const UsageError& e) {
      EXPECT_EQ(std::string(e.what()).rfind("@weight: ", 0), 0u) << e.what();
    }
  }
}

}  // namespace
}  // namespace isopach
