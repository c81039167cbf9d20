// The only place that knows threads (oneTBB underneath). A small vocabulary of verbs:
//   run_with_threads   everything inside runs on at most `threads` threads
//   for_blocks         f(begin, end) over fixed blocks of [0, n)
//   for_each_index     f(i) for i in [0, n)
//   reduce_blocks      per-block results, combined in block order: the same bits for any number of threads
//   both               two tasks side by side
//   read_shared, write_shared, claim, take_next   single words that tasks running side by side share
// Blocks depend on n and the block size alone, never on the number of threads.
//
// Built with ISOPACH_STD_THREADS (preset tsan) the same verbs run on plain threads: the thread sanitizer does not see
// how oneTBB synchronises, and would report its every task.
#pragma once
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <functional>
#include <vector>

#if !defined(ISOPACH_STD_THREADS)
#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_invoke.h>
#endif

namespace isopach {

inline constexpr std::size_t default_block = 4096;

/// Runs `work` with at most `threads` threads (0 = all cores). More threads than cores are allowed.
void run_with_threads(int threads, const std::function<void()>& work);

/// Number of threads that parallel work may use where this is called.
[[nodiscard]] int thread_count();

#if defined(ISOPACH_STD_THREADS)
namespace std_threads {
void run_blocks(std::size_t blocks, const std::function<void(std::size_t)>& work);
void run_both(const std::function<void()>& f, const std::function<void()>& g);
}  // namespace std_threads
#endif

template <class F>
void for_blocks(std::size_t n, std::size_t block, F&& f) {
  const std::size_t blocks = (n + block - 1) / block;
  if (blocks <= 1) {
    if (n > 0) f(std::size_t{0}, n);
    return;
  }
#if defined(ISOPACH_STD_THREADS)
  std_threads::run_blocks(blocks, [&](std::size_t b) { f(b * block, std::min(n, (b + 1) * block)); });
#else
  oneapi::tbb::parallel_for(oneapi::tbb::blocked_range<std::size_t>(0, blocks, 1),
                            [&](const oneapi::tbb::blocked_range<std::size_t>& range) {
                              for (std::size_t b = range.begin(); b != range.end(); ++b)
                                f(b * block, std::min(n, (b + 1) * block));
                            });
#endif
}

template <class F>
void for_each_index(std::size_t n, F&& f) {
  for_blocks(n, default_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) f(i);
  });
}

/// `map(begin, end) -> T` on fixed blocks, then `combine(T& left, const T& right)` from left to right.
template <class T, class Map, class Combine>
[[nodiscard]] T reduce_blocks(std::size_t n, std::size_t block, Map&& map, Combine&& combine) {
  const std::size_t blocks = (n + block - 1) / block;
  std::vector<T> partial(blocks);
  for_blocks(n, block, [&](std::size_t begin, std::size_t end) { partial[begin / block] = map(begin, end); });
  T total{};
  for (const T& part : partial) combine(total, part);
  return total;
}

/// What another task wrote before its write_shared or claim of this word is seen after read_shared of it.
template <class T>
[[nodiscard]] T read_shared(const T& word) {
  return std::atomic_ref<T>(const_cast<T&>(word)).load(std::memory_order_acquire);
}
template <class T>
void write_shared(T& word, T value) {
  std::atomic_ref<T>(word).store(value, std::memory_order_release);
}
/// Puts `desired` in place of `expected`; false if the word holds something else, which `expected` becomes.
template <class T>
[[nodiscard]] bool claim(T& word, T& expected, T desired) {
  return std::atomic_ref<T>(word).compare_exchange_strong(expected, desired, std::memory_order_acq_rel,
                                                          std::memory_order_acquire);
}
/// Adds `count` to a shared counter; gives its value before.
template <class T>
[[nodiscard]] T take_next(T& counter, T count) {
  return std::atomic_ref<T>(counter).fetch_add(count, std::memory_order_relaxed);
}

/// Which error is told must not depend on which of the two was faster: if both throw, that of `f`. Each runs to its
/// end. Test: Both.* in tests/base/parallel_test.cpp.
template <class F, class G>
void both(F&& f, G&& g) {
  std::exception_ptr of_f, of_g;
  const auto caught = [](auto& task, std::exception_ptr& error) {
    try {
      task();
    } catch (...) {
      error = std::current_exception();
    }
  };
  const auto run_f = [&] { caught(f, of_f); };
  const auto run_g = [&] { caught(g, of_g); };
#if defined(ISOPACH_STD_THREADS)
  std_threads::run_both(run_f, run_g);
#else
  oneapi::tbb::parallel_invoke(run_f, run_g);
#endif
  if (of_f) std::rethrow_exception(of_f);
  if (of_g) std::rethrow_exception(of_g);
}

}  // namespace isopach
