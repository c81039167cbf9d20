// Compensated sums [Neumaier1974]. The order of the additions is fixed by the caller (see parallel.hpp:
// reduce_blocks), so a sum has the same bits for any number of threads.
#pragma once
#include <cmath>

namespace isopach {

class Sum {
 public:
  void add(double x) {
    const double t = sum_ + x;
    rest_ += std::fabs(sum_) >= std::fabs(x) ? (sum_ - t) + x : (x - t) + sum_;
    sum_ = t;
  }
  void add(const Sum& other) {
    add(other.sum_);
    rest_ += other.rest_;
  }
  [[nodiscard]] double value() const { return sum_ + rest_; }

 private:
  double sum_ = 0;
  double rest_ = 0;
};

}  // namespace isopach
