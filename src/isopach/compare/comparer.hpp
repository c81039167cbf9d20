// Comparer: many comparisons, one after another, without asking the system for memory again and again.
#pragma once
#include "isopach/base/kept_memory.hpp"
#include "isopach/compare/compare.hpp"

namespace isopach {

/// compare() with the same options for pair after pair, each on memory that the one before it gave back: from the second
/// pair of a size on no new page is touched. The results are those of compare(), bit for bit; they stay valid when the
/// Comparer ends. Between calls it holds at most the memory that a comparison takes. Safe from several threads.
/// Test: Comparer.* in tests/compare/comparer_test.cpp.
class Comparer {
 public:
  explicit Comparer(CompareOptions options = {}, Context context = {})
      : options_(std::move(options)), context_(std::move(context)) {}
  [[nodiscard]] Comparison compare(const CloudView& a, const CloudView& b) const {
    return isopach::compare(a, b, options_, context_);
  }

 private:
  KeptMemory kept_;
  CompareOptions options_;
  Context context_;
};

}  // namespace isopach
