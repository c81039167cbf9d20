// Cancellation of shared-out work: between two of its blocks, whatever function shares it out.
#pragma once
#include "isopach/base/context.hpp"

namespace isopach {

/// While it lives, work that the thread which made it shares out (base/parallel.hpp) asks `context` before each block,
/// on every thread, whether it is cancelled, and ends by throwing Interrupted: within some thousand points, where
/// Context::check is asked between stages. run_with_threads(context, ...) makes one; a program makes one around the
/// whole of a run. `context` must outlive it; one without a flag is as if it were not there. Test: Watch.* in
/// tests/base/parallel_test.cpp.
class Watch {
 public:
  explicit Watch(const Context& context);
  ~Watch();
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;

 private:
  const Context* before_;
};

}  // namespace isopach
