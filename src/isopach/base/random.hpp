// Counter-based random numbers: the i-th number of a stream is a function of (seed, stream, i) alone, so that parallel
// code gives the same bits for any number of threads and any order of evaluation. Not for cryptography.
//
// Source: [Steele2014], SplitMix64; a stream starts at a hash of its name. [Box1958] for the normal distribution.
// Bits and uniform numbers are the same on every machine; normal ones as far as its log and cos agree in the last
// digit. Test of the distributions: tests/base/random_test.cpp
#pragma once
#include <cmath>
#include <cstdint>
#include <numbers>

namespace isopach {

class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t stream) : start_(mix(mix(seed + golden) + stream)) {}

  /// 64 random bits. Every i of the whole range is allowed.
  [[nodiscard]] std::uint64_t bits(std::uint64_t i) const { return mix(start_ + (i + 1) * golden); }

  /// Uniform in [0, 1), a multiple of 2^-53.
  [[nodiscard]] double uniform(std::uint64_t i) const { return static_cast<double>(bits(i) >> 11) * 0x1p-53; }

  /// Normal with mean 0 and standard deviation 1 (|x| < 8.6); uses bits(2i) and bits(2i + 1).
  [[nodiscard]] double normal(std::uint64_t i) const {
    const double radius = std::sqrt(-2 * std::log(1 - uniform(2 * i)));  // 1 − u lies in (0, 1]: the log is finite
    return radius * std::cos(2 * std::numbers::pi * uniform(2 * i + 1));
  }

 private:
  static constexpr std::uint64_t golden = 0x9e3779b97f4a7c15;  // 2^64 over the golden ratio

  [[nodiscard]] static std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return z ^ (z >> 31);
  }

  std::uint64_t start_;
};

}  // namespace isopach
