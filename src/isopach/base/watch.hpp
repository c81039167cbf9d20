// Cancellation of shared-out work: between two of its blocks, whatever function shares it out.
#pragma once
#include <atomic>

namespace isopach {

/// While it lives, work that the thread which made it shares out (base/parallel.hpp) looks at `flag` before each block,
/// on every thread, and ends by throwing Interrupted once it is set: within some thousand points, where
/// Context::check is asked between stages. To be made by whoever owns the flag, around the whole of a run. Null: as if
/// it were not there. Test: Watch.* in tests/base/parallel_test.cpp.
class Watch {
 public:
  explicit Watch(const std::atomic<bool>* flag);
  ~Watch();
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;

 private:
  const std::atomic<bool>* before_;
};

}  // namespace isopach
