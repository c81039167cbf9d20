#include "isopach/base/parallel.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>

#include "isopach/base/error.hpp"
#include "isopach/base/watch.hpp"

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

constexpr std::size_t many = 2000;

/// Blocks that run before the flag, set in the first, ends the work.
std::size_t run_until(std::atomic<bool>& flag) {
  std::atomic<std::size_t> count{0};
  for_blocks(many, 1, [&](std::size_t, std::size_t) {
    flag = true;
    ++count;
  });
  return count;
}

Context cancelled_by(const std::atomic<bool>& flag, int threads = 0) {
  Context context;
  context.threads = threads;
  context.cancelled = &flag;
  return context;
}

TEST(Watch, EndsWorkThatIsSharedOut) {
  for (const int threads : {1, 2, 7}) {
    std::atomic<bool> flag{false};
    EXPECT_THROW(run_with_threads(cancelled_by(flag, threads), [&] { run_until(flag); }), Interrupted);
  }
}

TEST(Watch, EndsWorkInsideWorkOnAnyThread) {
  std::atomic<bool> flag{false};
  std::atomic<std::size_t> inner{0};
  const auto nested = [&] {
    for_blocks(64, 1, [&](std::size_t, std::size_t) {
      for_blocks(many, 1, [&](std::size_t, std::size_t) {
        if (++inner == 100) flag = true;
      });
    });
  };
  const Context context = cancelled_by(flag);
  const Watch watch(context);
  EXPECT_THROW(run_with_threads(4, nested), Interrupted);
  EXPECT_LT(inner, many);  // each thread ends after the block that it is in
}

TEST(Watch, EndsOneOfTwoThatShareOutNothing) {
  std::atomic<bool> flag{true};
  bool ran = false;
  const Context context = cancelled_by(flag);
  const Watch watch(context);
  EXPECT_THROW(both([&] { ran = true; }, [&] { ran = true; }), Interrupted);
  EXPECT_FALSE(ran);
}

TEST(Watch, IsOverWithItsScope) {
  std::atomic<bool> flag{false};
  const Context inner = cancelled_by(flag);
  { const Watch watch(inner); }
  EXPECT_EQ(run_until(flag), many);
  std::atomic<bool> outer_flag{false};
  const Context outer = cancelled_by(outer_flag);
  const Watch watch(outer);
  const Context without;
  { const Watch none(without); }
  EXPECT_THROW(run_until(outer_flag), Interrupted);
}

}  // namespace
}  // namespace isopach
