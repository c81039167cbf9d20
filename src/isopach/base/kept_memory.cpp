#include "isopach/base/kept_memory.hpp"

#include <array>
#include <bit>
#include <new>

#include "isopach/base/parallel.hpp"

namespace isopach {
namespace {

// Sizes are rounded up to 16 steps a power of two, so that arrays of nearly the same length share their memory. What is
// behind an array is never touched, and costs nothing but addresses.
constexpr std::size_t steps = 16, slots = 16;
constexpr int first_power = std::bit_width(kept_from) - 1, last_power = 46;
constexpr std::size_t sizes = static_cast<std::size_t>(last_power - first_power + 1) * steps;

struct Size {
  std::size_t bytes, index;  // index == sizes: too large to be kept
};

Size rounded(std::size_t bytes) {
  const int power = std::bit_width(bytes) - 1;
  if (power > last_power) return {bytes, sizes};
  const std::size_t step = (std::size_t{1} << power) / steps;
  const std::size_t n = (bytes + step - 1) / step;  // 16 to 32; 32 is the first of the next power
  return {n * step, static_cast<std::size_t>(power - first_power) * steps + n - steps};
}

// The process has one memory: this is its only state that outlives a call. Each word is claimed or written whole.
struct Store {
  std::array<std::array<void*, slots>, sizes> kept{};
  std::size_t keepers = 0, in_use = 0, waiting = 0, peak = 0;
};
constinit Store store;

void add(std::size_t& word, std::size_t value) { (void)take_next(word, value); }
void subtract(std::size_t& word, std::size_t value) { (void)take_next(word, std::size_t{0} - value); }

void* take_from(std::array<void*, slots>& places) {
  for (void*& place : places) {
    void* memory = read_shared(place);
    if (memory != nullptr && claim(place, memory, static_cast<void*>(nullptr))) return memory;
  }
  return nullptr;
}

std::size_t size_of_index(std::size_t index) {
  const std::size_t step = (kept_from << (index / steps)) / steps;
  return (steps + index % steps) * step;
}

// Gives memory back to the system, the largest first, until `bytes` more do not exceed the peak.
void make_room(std::size_t bytes) {
  for (std::size_t i = sizes; i-- > 0;) {
    for (;;) {
      if (read_shared(store.in_use) + read_shared(store.waiting) + bytes <= read_shared(store.peak)) return;
      void* const memory = take_from(store.kept[i]);
      if (memory == nullptr) break;
      subtract(store.waiting, size_of_index(i));
      ::operator delete(memory);
    }
  }
}

void note_use(std::size_t bytes) {
  add(store.in_use, bytes);
  std::size_t peak = read_shared(store.peak);
  const std::size_t now = read_shared(store.in_use);
  while (peak < now && !claim(store.peak, peak, now)) {
  }
}

}  // namespace

KeptMemory::KeptMemory() { add(store.keepers, memory_is_kept ? 1 : 0); }

KeptMemory::~KeptMemory() {
  if (!memory_is_kept || take_next(store.keepers, std::size_t{0} - 1) != 1) return;
  for (std::size_t i = 0; i < store.kept.size(); ++i)
    while (void* const memory = take_from(store.kept[i])) {
      subtract(store.waiting, size_of_index(i));
      ::operator delete(memory);
    }
}

void* take_memory(std::size_t bytes) {
  const Size size = rounded(bytes);
  void* memory = nullptr;
  if (size.index < sizes && read_shared(store.waiting) > 0) {
    memory = take_from(store.kept[size.index]);
    if (memory != nullptr)
      subtract(store.waiting, size.bytes);
    else
      make_room(size.bytes);
  }
  if (memory == nullptr) memory = ::operator new(size.bytes);
  note_use(size.bytes);
  return memory;
}

void give_memory(void* memory, std::size_t bytes) noexcept {
  const Size size = rounded(bytes);
  subtract(store.in_use, size.bytes);
  if (size.index < sizes && read_shared(store.keepers) > 0) {
    add(store.waiting, size.bytes);
    for (void*& place : store.kept[size.index]) {
      void* empty = nullptr;
      if (claim(place, empty, memory)) return;
    }
    subtract(store.waiting, size.bytes);
  }
  ::operator delete(memory);
}

std::size_t kept_bytes() { return read_shared(store.waiting); }

}  // namespace isopach
