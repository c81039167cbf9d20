// Clocks and medians. One thread is timed by its own CPU clock (other people's work on the machine is not counted);
// several threads by the wall clock.
#pragma once
#include <functional>
#include <string>
#include <vector>

namespace isopach::bench {

[[nodiscard]] double thread_cpu_seconds();
[[nodiscard]] double wall_seconds();

[[nodiscard]] double median(std::vector<double> values);

/// One thing to be timed. `work` alone is on the clock; `before` makes what it needs, `after` frees what it made.
struct Contestant {
  std::string name;
  int threads = 1;  ///< 1: thread CPU time; more: wall time
  std::function<void()> work;
  std::function<void()> before = [] {};
  std::function<void()> after = [] {};
};

/// Median seconds of each contestant; they take turns, so that a slow minute of the machine hits all of them.
[[nodiscard]] std::vector<double> take_turns(const std::vector<Contestant>& contestants, int repeats);

/// Median seconds of one piece of work.
[[nodiscard]] double time_of(int threads, int repeats, const std::function<void()>& work);

/// Keeps freed memory in the process, so that page faults of the first touch are off the clock for everybody.
void keep_heap();

}  // namespace isopach::bench
