// Array<T>: std::vector whose resize leaves trivially constructible elements uninitialised, so that a large array is
// touched once, by the code that fills it (in parallel), and not a first time to be zeroed. Large ones take their
// memory where it can be kept for the next run (base/kept_memory.hpp).
#pragma once
#include <cstddef>
#include <limits>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "isopach/base/kept_memory.hpp"

namespace isopach {

template <class T>
struct DefaultInitAllocator : std::allocator<T> {
  template <class U>
  struct rebind {
    using other = DefaultInitAllocator<U>;
  };
  DefaultInitAllocator() = default;
  template <class U>
  DefaultInitAllocator(const DefaultInitAllocator<U>&) noexcept {}

  [[nodiscard]] T* allocate(std::size_t n) {
    if (!is_large(n)) return std::allocator<T>::allocate(n);
    return static_cast<T*>(take_memory(n * sizeof(T)));
  }
  void deallocate(T* p, std::size_t n) noexcept {
    if (!is_large(n)) return std::allocator<T>::deallocate(p, n);
    give_memory(p, n * sizeof(T));
  }

  template <class U>
  void construct(U* p) noexcept(std::is_nothrow_default_constructible_v<U>) {
    ::new (static_cast<void*>(p)) U;
  }
  template <class U, class... Args>
  void construct(U* p, Args&&... args) {
    ::new (static_cast<void*>(p)) U(std::forward<Args>(args)...);
  }

 private:
  /// What does not fit into addresses is refused by std::allocator.
  static bool is_large(std::size_t n) {
    return alignof(T) <= __STDCPP_DEFAULT_NEW_ALIGNMENT__ && n >= kept_from / sizeof(T) &&
           n <= std::numeric_limits<std::ptrdiff_t>::max() / sizeof(T);
  }
};

template <class T>
using Array = std::vector<T, DefaultInitAllocator<T>>;

}  // namespace isopach
