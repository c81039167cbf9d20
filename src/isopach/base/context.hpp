// What a run carries besides its data: number of threads, seed, progress, cancellation. Passed by const reference;
// there are no mutable globals but the memory that waits for the next array (base/kept_memory.hpp).
#pragma once
#include <atomic>
#include <cstdint>
#include <functional>
#include <string_view>

#include "isopach/base/error.hpp"

namespace isopach {

struct Context {
  int threads = 0;                               ///< 0 = all cores. Results do not depend on it.
  std::uint64_t seed = 1;                        ///< for simulations; never taken from the clock
  const std::atomic<bool>* cancelled = nullptr;  ///< set by Ctrl-C; checked between blocks of work
  std::function<void(std::string_view stage, double fraction)> progress;  ///< may be empty; fraction in [0, 1]

  /// Reports progress, and throws Interrupted if the user asked to stop. Call from one thread.
  void step(std::string_view stage, double fraction) const {
    check();
    if (progress) progress(stage, fraction);
  }
  void check() const {
    if (cancelled != nullptr && cancelled->load(std::memory_order_relaxed)) throw Interrupted();
  }
};

}  // namespace isopach
