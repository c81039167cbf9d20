// THE PAGE's header: compare(a, b, options).
#pragma once
#include "isopach/base/context.hpp"
#include "isopach/base/kept_memory.hpp"
#include "isopach/cloud/cloud_view.hpp"
#include "isopach/compare/comparison.hpp"
#include "isopach/overlay/pair.hpp"

namespace isopach {

/// How much and where b differs from a (docs/method/method.md): two Clouds, or views of arrays of the caller's own.
/// Errors: OverlapError when the hulls are disjoint, touch only, or coverage is below options.min_coverage; InputError
/// for scans without usable points or with CRS that do not match.
[[nodiscard]] Comparison compare(const CloudView& a, const CloudView& b, const CompareOptions& options,
                                 const Context& context);

/// The same, and `scans` keeps what was made of each scan on the way: nodes, triangulation, what the border keeps of it
/// and what of that is folded.
[[nodiscard]] Comparison compare(const CloudView& a, const CloudView& b, const CompareOptions& options,
                                 const Context& context, Pair& scans);

/// compare() with the same options for pair after pair, each on memory that the one before it gave back: from the
/// second pair of a size on large arrays touch no new page. The results are those of compare(), bit for bit; they stay
/// valid when the Comparer ends. Between calls it holds at most the memory that a comparison takes. Safe from several
/// threads. Test: Comparer.* in tests/compare/comparer_test.cpp.
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
