#include "isopach/base/parallel.hpp"

#if defined(ISOPACH_STD_THREADS)
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#else
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>
#endif

namespace isopach {

#if defined(ISOPACH_STD_THREADS)

namespace {

constexpr std::size_t threads_at_once = 4;
thread_local int depth = 0;  // work inside work runs where it is

class FirstFailure {
 public:
  void guard(const std::function<void()>& work) {
    try {
      work();
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (!failure_) failure_ = std::current_exception();
    }
  }
  void raise() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  std::mutex mutex_;
  std::exception_ptr failure_;
};

void run_side_by_side(std::size_t count, const std::function<void()>& work) {
  FirstFailure failure;
  std::vector<std::thread> threads;
  const int here = depth;
  for (std::size_t i = 0; i < count; ++i)
    threads.emplace_back([&] {
      depth = here + 1;
      failure.guard(work);
    });
  for (std::thread& thread : threads) thread.join();
  failure.raise();
}

}  // namespace

namespace std_threads {

void run_blocks(std::size_t blocks, const std::function<void(std::size_t)>& work) {
  std::atomic<std::size_t> next{0};
  const auto drain = [&] {
    for (std::size_t b = next++; b < blocks; b = next++) work(b);
  };
  if (depth > 1) return drain();
  run_side_by_side(std::min(threads_at_once, blocks), drain);
}

void run_both(const std::function<void()>& f, const std::function<void()>& g) {
  run_blocks(2, [&](std::size_t i) { i == 0 ? f() : g(); });
}

}  // namespace std_threads

void run_with_threads(int, const std::function<void()>& work) { work(); }

int thread_count() { return static_cast<int>(threads_at_once); }

#else

void run_with_threads(int threads, const std::function<void()>& work) {
  if (threads <= 0) {
    work();
    return;
  }
  // The arena alone never grows past the machine's cores; the control lifts that, so that 7 threads mean 7 anywhere.
  oneapi::tbb::global_control control(oneapi::tbb::global_control::max_allowed_parallelism,
                                      static_cast<std::size_t>(threads));
  oneapi::tbb::task_arena arena(threads);
  arena.execute(work);
}

int thread_count() { return oneapi::tbb::this_task_arena::max_concurrency(); }

#endif

}  // namespace isopach
