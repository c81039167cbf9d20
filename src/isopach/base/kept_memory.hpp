// KeptMemory: what large arrays give back is kept for the next ones, so that a second run like the first one asks the
// system for nothing and touches no new page.
#pragma once
#include <cstddef>

namespace isopach {

/// While one lives, memory of arrays (base/array.hpp) from kept_from bytes on is kept when they end, and handed to the
/// next array of about the same size, in any thread; the end of the last one gives it back to the system. What is kept
/// and in use together never exceeds what was in use at once before: a run that keeps has the peak of one that does
/// not. Results are the same bits. Cost: a look at 16 words an array. Test: KeptMemory.* in
/// tests/base/kept_memory_test.cpp.
class KeptMemory {
 public:
  KeptMemory();
  ~KeptMemory();
  KeptMemory(const KeptMemory&) = delete;
  KeptMemory& operator=(const KeptMemory&) = delete;
};

// The address sanitizer finds arrays that are used after their end only where their memory does not serve others.
#if defined(__SANITIZE_ADDRESS__)
inline constexpr bool memory_is_kept = false;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
inline constexpr bool memory_is_kept = false;
#else
inline constexpr bool memory_is_kept = true;
#endif
#else
inline constexpr bool memory_is_kept = true;
#endif

inline constexpr std::size_t kept_from = std::size_t{1} << 18;  ///< bytes; smaller arrays come from the heap

/// Memory for `bytes`, at least kept_from, aligned for any ordinary type. Throws std::bad_alloc.
[[nodiscard]] void* take_memory(std::size_t bytes);
/// Of take_memory(bytes).
void give_memory(void* memory, std::size_t bytes) noexcept;
/// Bytes that wait for the next array.
[[nodiscard]] std::size_t kept_bytes();

}  // namespace isopach
