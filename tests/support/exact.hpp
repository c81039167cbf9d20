// Sums of doubles as integers: every double is a multiple of 2^−1074, the smallest of them.
#pragma once
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>

namespace isopach::test {

class ExactSum {
 public:
  using Integer = boost::multiprecision::cpp_int;

  void add(double x) { sum_ += in_steps(x); }
  void subtract(double x) { sum_ -= in_steps(x); }
  [[nodiscard]] const Integer& steps() const { return sum_; }

  /// Whether `found` is the double nearest to the sum, the even one of two.
  [[nodiscard]] bool rounds_to(double found) const {
    const Integer off = 2 * boost::multiprecision::abs(sum_ - in_steps(found));
    // Half of the way to either neighbour; at a power of two the one below is nearer.
    const double beyond = std::nextafter(found, HUGE_VAL), before = std::nextafter(found, -HUGE_VAL);
    const Integer gap =
        sum_ >= in_steps(found) ? in_steps(beyond) - in_steps(found) : in_steps(found) - in_steps(before);
    if (off != gap) return off < gap;
    int exponent = 0;
    const auto digits = static_cast<std::int64_t>(std::ldexp(std::frexp(found, &exponent), 53));
    return digits % 2 == 0;
  }
  /// |found − sum| in steps of 2^exponent, exponent ≥ −1074, rounded down.
  [[nodiscard]] Integer off_by(double found, int exponent) const {
    return boost::multiprecision::abs(sum_ - in_steps(found)) >> (exponent + 1074);
  }

  [[nodiscard]] static Integer in_steps(double x) {
    int exponent = 0;
    const auto digits = static_cast<std::int64_t>(std::ldexp(std::frexp(x, &exponent), 53));
    const int shift = exponent - 53 + 1074;
    const Integer size = digits;
    return shift >= 0 ? Integer(size << shift) : Integer(size / (Integer(1) << -shift));
  }

 private:
  Integer sum_;
};

}  // namespace isopach::test
