// Two tasks side by side that can both fail, such as reading two scans: which error is told must not depend on which of
// them was faster.
#pragma once
#include <exception>

#include "isopach/base/parallel.hpp"

namespace isopach {

/// As `both`; if both throw, the exception of `f`. Each runs to its end. Test: FirstError.* in
/// tests/base/first_error_test.cpp.
template <class F, class G>
void both_with_first_error(F&& f, G&& g) {
  std::exception_ptr of_f, of_g;
  const auto caught = [](auto& task, std::exception_ptr& error) {
    try {
      task();
    } catch (...) {
      error = std::current_exception();
    }
  };
  both([&] { caught(f, of_f); }, [&] { caught(g, of_g); });
  if (of_f) std::rethrow_exception(of_f);
  if (of_g) std::rethrow_exception(of_g);
}

}  // namespace isopach
