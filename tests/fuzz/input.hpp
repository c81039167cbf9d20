// What all fuzz targets share: exact copies of bytes, values out of bytes, and what may leave a target.
#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <initializer_list>
#include <iterator>
#include <memory>
#include <span>
#include <string>

#include "isopach/base/context.hpp"
#include "isopach/base/error.hpp"

namespace isopach::fuzz {

/// A copy on the heap of exactly so many bytes, so that the address sanitizer sees a read one past the end.
class ExactBytes {
 public:
  ExactBytes(const void* data, std::size_t size) : data_(new char[size]), size_(size) {
    if (size > 0) std::memcpy(data_.get(), data, size);
  }
  [[nodiscard]] std::span<const char> bytes() const { return {data_.get(), size_}; }
  [[nodiscard]] std::span<char> bytes() { return {data_.get(), size_}; }

 private:
  std::unique_ptr<char[]> data_;
  std::size_t size_;
};

/// Values out of bytes, from the front; zeros when they are used up.
class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : rest_(data, size) {}

  [[nodiscard]] bool empty() const { return rest_.empty(); }
  std::uint8_t byte() {
    if (rest_.empty()) return 0;
    const std::uint8_t value = rest_.front();
    rest_ = rest_.subspan(1);
    return value;
  }
  bool flag() { return byte() % 2 != 0; }
  /// 0 to n − 1, for n up to 256.
  std::size_t below(std::size_t n) { return byte() % n; }
  int signed_byte() { return static_cast<std::int8_t>(byte()); }
  /// Any double: a whole number, one of those that arithmetic stumbles over, or eight bytes as they are.
  double number();
  /// A finite number above 0, as the command line lets it through: most are of the size of the scans.
  double length();
  /// 0 to 1, both included.
  double share() { return byte() / 255.0; }
  template <class E>
  E choice(std::initializer_list<E> values) {
    return values.begin()[below(values.size())];
  }
  /// All that is left.
  std::string text() {
    std::string all(reinterpret_cast<const char*>(rest_.data()), rest_.size());
    rest_ = {};
    return all;
  }

 private:
  std::span<const std::uint8_t> rest_;
};

inline double Input::number() {
  constexpr double inf = HUGE_VAL;
  constexpr double hard[] = {0.0,    -0.0,   NAN,    inf,    -inf,    4.9406564584124654e-324,
                             1e-310, 1e-200, 1e-150, -1e-60, 1e-16,   0.1,
                             1e15,   1e22,   1e59,   -1e60,  1e75,    1e150,
                             -1e150, 1e200,  1e307,  -1e308, 1.0 / 3, 9007199254740993.0};
  const std::uint8_t kind = byte();
  if (kind < 96) return static_cast<double>(kind) - 48;
  if (kind < 240) return hard[kind % std::size(hard)];
  std::uint64_t bits = 0;
  for (int i = 0; i < 8; ++i) bits = bits << 8 | byte();
  double value;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

inline double Input::length() {
  const std::uint8_t kind = byte();
  if (kind < 200) return (kind + 1) / 16.0;
  const double value = std::fabs(number());
  return std::isfinite(value) && value > 0 ? value : 1;
}

/// Of a run on one thread, so that a run is the same again.
[[nodiscard]] inline Context one_thread() {
  Context context;
  context.threads = 1;
  return context;
}

/// How often a target was done without an error, and the last one that it ended by: the replay asks whether inputs that
/// are named valid are.
inline std::size_t completed = 0;
inline std::string refusal;

/// Runs a target. A reason is as good as a result; every other exception leaves it, and ends the fuzzer.
template <class Work>
void only_errors(Work&& work) {
  try {
    work();
    ++completed;
  } catch (const isopach::Error& error) {
    refusal = error.what();
  }
}

inline void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "this does not hold: %s\n", what);
  std::abort();
}

inline void require_finite(const char* what, std::initializer_list<double> values) {
  for (const double value : values)
    if (!std::isfinite(value)) {
      std::fprintf(stderr, "%s: %g is no finite number\n", what, value);
      std::abort();
    }
}

}  // namespace isopach::fuzz
