// Weights by formula, as the command line gives them.
#pragma once
#include <string>

#include "isopach/io/expression.hpp"
#include "isopach/measure/volume/weight.hpp"

namespace isopach::test {

inline WeightSource weight_by(const std::string& formula) {
  return {WeightSource::Kind::expression, WeightSource::Scan::any, formula, Expression(formula, "@weight")};
}

}  // namespace isopach::test
