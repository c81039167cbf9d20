#include "isopach/io/expression.hpp"

#include <fmt/format.h>
#include <muParser.h>

#include <limits>

#include "isopach/base/error.hpp"

namespace isopach {

namespace {

/// A single "=" would overwrite a variable.
bool assigns(const std::string& text) {
  for (std::size_t i = text.find('='); i != std::string::npos; i = text.find('=', i + 1)) {
    const bool compares_left = i > 0 && std::string("=<>!").find(text[i - 1]) != std::string::npos;
    const bool compares_right = i + 1 < text.size() && text[i + 1] == '=';
    if (!compares_left && !compares_right) return true;
  }
  return false;
}

}  // namespace

struct Expression::Parser {
  std::string text, option;  // for copies
  Place place;
  mu::Parser formula;
};

Expression::Expression(const std::string& text, const std::string& option) : parser_(std::make_unique<Parser>()) {
  const auto refuse = [&](const std::string& why) {
    throw UsageError(fmt::format("{}: '{}': {}: give a formula of x, y, z1, z2, slope1, slope2", option, text, why));
  };
  if (text.find_first_of("\n\r") != std::string::npos)
    throw UsageError(option + ": a formula is one line: take the line break out");
  if (assigns(text)) refuse("'=' assigns, compare by '=='");
  parser_->text = text, parser_->option = option;
  Place& p = parser_->place;
  mu::Parser& formula = parser_->formula;
  try {
    formula.DefineVar("x", &p.x);
    formula.DefineVar("y", &p.y);
    formula.DefineVar("z1", &p.z1);
    formula.DefineVar("z2", &p.z2);
    formula.DefineVar("slope1", &p.slope1);
    formula.DefineVar("slope2", &p.slope2);
    formula.SetExpr(text);
    (void)formula.Eval();
  } catch (const mu::Parser::exception_type& e) {
    const std::string& token = e.GetToken();
    refuse(e.GetCode() == mu::ecUNASSIGNABLE_TOKEN ? "unknown name '" + token + "'" : "not a formula: " + e.GetMsg());
  }
  if (formula.GetNumResults() != 1) refuse("several results, separated by commas");
}

Expression::~Expression() = default;
Expression::Expression(const Expression& other) : Expression(other.parser_->text, other.parser_->option) {}
Expression::Expression(Expression&&) noexcept = default;

double Expression::operator()(const Place& place) {
  parser_->place = place;
  try {
    return parser_->formula.Eval();
  } catch (const mu::Parser::exception_type&) {  // an operation without a value, in builds of muParser that say so
    return std::numeric_limits<double>::quiet_NaN();
  }
}

}  // namespace isopach
