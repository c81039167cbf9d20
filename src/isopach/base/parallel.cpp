#include "isopach/base/parallel.hpp"

#include <pthread.h>

#include <algorithm>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/base/error.hpp"
#include "isopach/base/thread_limit.hpp"
#include "isopach/base/watch.hpp"

#if !defined(ISOPACH_STD_THREADS)
#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_invoke.h>
#include <oneapi/tbb/task_arena.h>
#endif

namespace isopach {

namespace {

thread_local const Context* watched = nullptr;

/// Runs `work` with `context` watched, whatever thread this is; null: none.
template <class Work>
void run_watching(const Context* context, Work&& work) {
  if (context == nullptr) return work();
  const Watch here(*context);
  context->check();
  work();
}

/// Blocks [first, last), with a look at the flag before each.
void run_watched(const Context* context, std::size_t first, std::size_t last, const void* work,
                 void (*run)(const void*, std::size_t, std::size_t)) {
  if (context == nullptr) {
    run(work, first, last);
    return;
  }
  const Watch here(*context);  // work inside this work may run on another thread than the one that shared it out
  for (std::size_t b = first; b != last; ++b) {
    context->check();
    run(work, b, b + 1);
  }
}

}  // namespace

Watch::Watch(const Context& context) : before_(watched) {
  if (context.cancelled != nullptr) watched = &context;
}
Watch::~Watch() { watched = before_; }

void run_with_threads(const Context& context, const std::function<void()>& work) {
  const Watch here(context);
  run_with_threads(context.threads, work);
}

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

void share_out(std::size_t count, const std::function<void(std::size_t)>& work) {
  std::atomic<std::size_t> next{0};
  const auto drain = [&] {
    for (std::size_t i = next++; i < count; i = next++) work(i);
  };
  if (depth > 1) return drain();
  run_side_by_side(std::min(threads_at_once, count), drain);
}

void run_two(const std::function<void()>& f, const std::function<void()>& g) {
  share_out(2, [&](std::size_t i) { i == 0 ? f() : g(); });
}

}  // namespace

void run_blocks(std::size_t blocks, const void* work, void (*run)(const void*, std::size_t, std::size_t)) {
  const Context* const context = watched;
  share_out(blocks, [&](std::size_t b) { run_watched(context, b, b + 1, work, run); });
}

void run_with_threads(int, const std::function<void()>& work) { work(); }

void run_alone(const std::function<void()>& work) { work(); }

int thread_count() { return static_cast<int>(threads_at_once); }

#else

namespace {

void execute(oneapi::tbb::task_arena& arena, const std::function<void()>& work) {
  arena.execute([&, context = watched] { run_watching(context, work); });
}

}  // namespace

void run_with_threads(int threads, const std::function<void()>& work) {
  if (threads <= 0) {
    work();
    return;
  }
  // The arena alone never grows past the machine's cores; the control lifts that, so that 7 threads mean 7 anywhere.
  oneapi::tbb::global_control control(oneapi::tbb::global_control::max_allowed_parallelism,
                                      static_cast<std::size_t>(threads));
  oneapi::tbb::task_arena arena(threads);
  execute(arena, work);
}

void run_alone(const std::function<void()>& work) {
  oneapi::tbb::task_arena arena(1);  // and no global_control: other calls of the library keep their threads
  execute(arena, work);
}

int thread_count() { return oneapi::tbb::this_task_arena::max_concurrency(); }

void run_blocks(std::size_t blocks, const void* work, void (*run)(const void*, std::size_t, std::size_t)) {
  using Range = oneapi::tbb::blocked_range<std::size_t>;
  oneapi::tbb::parallel_for(Range(0, blocks, 1), [=, context = watched](const Range& range) {
    run_watched(context, range.begin(), range.end(), work, run);
  });
}

namespace {

void run_two(const std::function<void()>& f, const std::function<void()>& g) { oneapi::tbb::parallel_invoke(f, g); }

}  // namespace

#endif

void both(const std::function<void()>& f, const std::function<void()>& g) {
  std::exception_ptr of_f, of_g;
  const auto caught = [context = watched](const std::function<void()>& task, std::exception_ptr& error) {
    try {
      run_watching(context, task);
    } catch (...) {
      error = std::current_exception();
    }
  };
  run_two([&] { caught(f, of_f); }, [&] { caught(g, of_g); });
  if (of_f) std::rethrow_exception(of_f);
  if (of_g) std::rethrow_exception(of_g);
}

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
