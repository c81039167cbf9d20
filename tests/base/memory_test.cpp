#include "isopach/base/memory.hpp"

#include <gtest/gtest.h>

#include <memory>

namespace isopach {
namespace {

constexpr std::size_t much = 200'000'000;

#if defined(__SANITIZE_ADDRESS__)
constexpr bool keeps_what_is_given_back = true;
#elif defined(__has_feature)
constexpr bool keeps_what_is_given_back = __has_feature(address_sanitizer);
#else
constexpr bool keeps_what_is_given_back = false;
#endif

/// A page of it after the other is touched, so that it is resident.
void take_and_give_back() {
  const auto bytes = std::make_unique<char[]>(much);  // NOLINT: set to 0
  ASSERT_EQ(bytes[much / 2], 0);
}

TEST(PeakMemory, TellsOfWorkSinceItWasMade) {
  const PeakMemory all;
  take_and_give_back();
  if (const auto peak = all.bytes()) {  // Linux tells
    EXPECT_GT(*peak, much);
  }
}

TEST(PeakMemory, NeverTellsOfEarlierWork) {
  if (keeps_what_is_given_back) return;  // by a sanitizer: then there is no such work to tell apart
  take_and_give_back();
  const PeakMemory none;
  if (const auto peak = none.bytes()) {
    EXPECT_LT(*peak, much);
  }
  take_and_give_back();
  if (const auto peak = none.bytes()) {
    EXPECT_GT(*peak, much);
  }
}

}  // namespace
}  // namespace isopach
