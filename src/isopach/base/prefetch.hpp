// prefetch: asks memory for a cache line that is needed soon, and does not wait.
#pragma once

namespace isopach {

/// Always inlined: the compiler drops calls of functions that do nothing but prefetch.
[[gnu::always_inline]] inline void prefetch(const void* address) { __builtin_prefetch(address); }

}  // namespace isopach
