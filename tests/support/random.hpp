// Counter-based random numbers for tests: the k-th number of a seed is a hash of (seed, k) (splitmix64, Steele, Lea and
// Flood 2014), so that a case has the same bits on every machine.
#pragma once
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace isopach::test {

class Random {
 public:
  explicit Random(std::uint64_t seed) : seed_(mix(seed + 0x9e3779b97f4a7c15ULL)) {}

  [[nodiscard]] std::uint64_t bits() { return mix(seed_ + 0x9e3779b97f4a7c15ULL * ++counter_); }
  /// In [0, 1), a multiple of 2⁻⁵³.
  [[nodiscard]] double uniform() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  [[nodiscard]] double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// In [0, n).
  [[nodiscard]] std::size_t below(std::size_t n) { return static_cast<std::size_t>(bits() % n); }
  /// Mean 0, standard deviation 1, bell-shaped: the sum of 12 uniform numbers (no libm, so the same bits everywhere).
  [[nodiscard]] double bell() {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += uniform();
    return sum;
  }

  template <class T>
  void shuffle(std::vector<T>& items) {
    for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[below(i)]);
  }

 private:
  [[nodiscard]] static std::uint64_t mix(std::uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31);
  }
  std::uint64_t seed_;
  std::uint64_t counter_ = 0;
};

}  // namespace isopach::test
