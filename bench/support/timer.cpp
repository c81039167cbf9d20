#include "bench/support/timer.hpp"

#include <malloc.h>

#include <algorithm>
#include <climits>
#include <ctime>

#include "isopach/base/parallel.hpp"

namespace isopach::bench {
namespace {

double seconds_of(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double run(const Contestant& contestant) {
  double seconds = 0;
  run_with_threads(contestant.threads, [&] {
    contestant.before();
    const clockid_t clock = contestant.threads == 1 ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC;
    const double start = seconds_of(clock);
    contestant.work();
    seconds = seconds_of(clock) - start;
    contestant.after();
  });
  return seconds;
}

}  // namespace

double thread_cpu_seconds() { return seconds_of(CLOCK_THREAD_CPUTIME_ID); }
double wall_seconds() { return seconds_of(CLOCK_MONOTONIC); }

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

std::vector<double> take_turns(const std::vector<Contestant>& contestants, int repeats) {
  std::vector<std::vector<double>> seconds(contestants.size());
  for (int turn = 0; turn < repeats; ++turn)
    for (std::size_t i = 0; i < contestants.size(); ++i) seconds[i].push_back(run(contestants[i]));
  std::vector<double> medians;
  for (const std::vector<double>& s : seconds) medians.push_back(median(s));
  return medians;
}

double time_of(int threads, int repeats, const std::function<void()>& work) {
  Contestant one;
  one.threads = threads;
  one.work = work;
  return take_turns({one}, repeats)[0];
}

void keep_heap() {
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, INT_MAX);
  mallopt(M_ARENA_MAX, 1);
}

}  // namespace isopach::bench
