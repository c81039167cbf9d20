#include "isopach/base/parallel.hpp"

#include <pthread.h>

#include <algorithm>
#include <mutex>
#include <thread>
#include <vector>

#include "isopach/base/thread_limit.hpp"

#if defined(ISOPACH_STD_THREADS)
#include <atomic>
#include <exception>
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

namespace {

constexpr std::size_t stack_bytes = std::size_t{4} << 20;  // that of oneTBB's workers

void* wait_at(void* gate) {
  const std::lock_guard<std::mutex> open(*static_cast<std::mutex*>(gate));
  return nullptr;
}

}  // namespace

int startable_threads(int wanted) {
  pthread_attr_t attributes;
  if (pthread_attr_init(&attributes) != 0) return 0;
  pthread_attr_setstacksize(&attributes, stack_bytes);
  std::vector<pthread_t> threads;
  threads.reserve(static_cast<std::size_t>(std::max(wanted, 0)));
  std::mutex gate;
  gate.lock();  // none ends before all are there
  for (pthread_t thread{}; static_cast<int>(threads.size()) < wanted; threads.push_back(thread))
    if (pthread_create(&thread, &attributes, wait_at, &gate) != 0) break;
  gate.unlock();
  for (const pthread_t thread : threads) pthread_join(thread, nullptr);
  pthread_attr_destroy(&attributes);
  return static_cast<int>(threads.size());
}

int all_cores() { return static_cast<int>(std::max(1U, std::thread::hardware_concurrency())); }

}  // namespace isopach
