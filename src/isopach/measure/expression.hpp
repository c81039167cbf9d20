// Expression: a formula of the user as a function of a place (muParser underneath; docs/use/weights.md lists what it
// knows).
#pragma once
#include <array>
#include <memory>
#include <string>

namespace isopach {

/// What a formula may name. Coordinates and heights as in the input; slopes are rise over run, of either surface.
struct Place {
  double x = 0, y = 0, z1 = 0, z2 = 0, slope1 = 0, slope2 = 0;
};

/// One of these is used by one task at a time: evaluation writes to it.
class Expression {
 public:
  /// Throws UsageError naming `option`: not a formula, an unknown name, an assignment, or several results.
  Expression(const std::string& text, const std::string& option);
  ~Expression();
  Expression(Expression&&) noexcept;

  /// NaN or an infinity where the formula has no value.
  [[nodiscard]] double operator()(const Place& place);

 private:
  struct Parser;
  std::unique_ptr<Parser> parser_;
};

}  // namespace isopach
