#include "isopach/base/parallel.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>

namespace isopach {
namespace {

void fail(bool fails, int milliseconds, const char* name) {
  std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
  if (fails) throw std::runtime_error(name);
}

std::string told(bool first, bool second, int wait_first, int wait_second) {
  std::string error = "none";
  run_with_threads(2, [&] {
    try {
      both([&] { fail(first, wait_first, "first"); }, [&] { fail(second, wait_second, "second"); });
    } catch (const std::runtime_error& e) {
      error = e.what();
    }
  });
  return error;
}

TEST(Both, TellsTheErrorOfTheFirstTaskWhicheverIsFaster) {
  EXPECT_EQ(told(true, true, 20, 0), "first");
  EXPECT_EQ(told(true, true, 0, 20), "first");
  EXPECT_EQ(told(false, true, 20, 0), "second");
  EXPECT_EQ(told(true, false, 20, 0), "first");
  EXPECT_EQ(told(false, false, 0, 0), "none");
}

}  // namespace
}  // namespace isopach
