// The only place that knows threads (oneTBB underneath). A small vocabulary of verbs:
//   run_with_threads   everything inside runs on at most `threads` threads
//   run_alone          everything inside runs on the thread that calls it
//   for_blocks         f(begin, end) over fixed blocks of [0, n)
//   for_each_index     f(i) for i in [0, n)
//   reduce_blocks      per-block results, combined in block order: the same bits for any number of threads
//   gather_blocks      per-block vectors, one behind the other
//   both               two tasks side by side
//   read_shared, write_shared, claim, take_next   single words that tasks running side by side share
// Blocks depend on n and the block size alone, never on the number of threads.
//
// The templates below only wrap work and hand it to parallel.cpp, once for many blocks: no file of the project includes
// a header of oneTBB but that one. Built with ISOPACH_STD_THREADS (preset tsan) it runs the work on plain threads: the
// thread sanitizer does not see how oneTBB synchronises, and would report its every task.
#pragma once
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <functional>
#include <vector>

namespace isopach {

struct Context;

inline constexpr std::size_t default_block = 4096;

/// Runs `work` with at most `threads` threads (0 = all cores). More threads than cores are allowed.
void run_with_threads(int threads, const std::function<void()>& work);

/// The same with the threads of `context`, and watched (base/watch.hpp): what it shares out ends once it is cancelled.
void run_with_threads(const Context& context, const std::function<void()>& work);

/// Runs `work` on this thread: for what is done before another one is awake. No thread is started.
void run_alone(const std::function<void()>& work);

/// Number of threads that parallel work may use where this is called.
[[nodiscard]] int thread_count();

/// Runs `run(work, first, last)` over ranges that share out [0, blocks). The first error that is seen is thrown, after
/// all that were begun have ended. What for_blocks stands on.
void run_blocks(std::size_t blocks, const void* work,
                void (*run)(const void* work, std::size_t first, std::size_t last));

/// Runs the two side by side, each to its end. Which error is told must not depend on which of the two was faster: if
/// both throw, that of `f`. Test: Both.* in tests/base/parallel_test.cpp.
void both(const std::function<void()>& f, const std::function<void()>& g);

template <class F>
void for_blocks(std::size_t n, std::size_t block, F&& f) {
  const std::size_t blocks = (n + block - 1) / block;
  if (blocks <= 1) {
    if (n > 0) f(std::size_t{0}, n);
    return;
  }
  const auto work = [&](std::size_t first, std::size_t last) {
    for (std::size_t b = first; b != last; ++b) f(b * block, std::min(n, (b + 1) * block));
  };
  run_blocks(blocks, &work, [](const void* given, std::size_t first, std::size_t last) {
    (*static_cast<const decltype(work)*>(given))(first, last);
  });
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

/// The vectors that `map(begin, end)` gives for each block, one behind the other in the order of the blocks.
template <class Vector, class Map>
[[nodiscard]] Vector gather_blocks(std::size_t n, std::size_t block, Map&& map) {
  return reduce_blocks<Vector>(
      n, block, map, [](Vector& all, const Vector& part) { all.insert(all.end(), part.begin(), part.end()); });
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

}  // namespace isopach
