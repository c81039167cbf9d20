// Expression: a formula of the user as a function of a place (muParser underneath; docs/use/weights.md lists what it
// knows).
#pragma once
#include <memory>
#include <string>

#include "isopach/geom/place.hpp"

namespace isopach {

/// One of these is used by one task at a time: evaluation writes to it. A copy is another one.
class Expression {
 public:
  /// Throws UsageError naming `option`: not a formula, an unknown name, an assignment, or several results.
  Expression(const std::string& text, const std::string& option);
  ~Expression();
  Expression(const Expression& other);
  Expression(Expression&& other) noexcept;
  Expression& operator=(const Expression&) = delete;

  /// NaN or an infinity where the formula has no value.
  [[nodiscard]] double operator()(const Place& place);

 private:
  struct Parser;
  std::unique_ptr<Parser> parser_;
};

}  // namespace isopach
