// Fuzz target: any text as a formula of --weight, evaluated at places of every kind, and again by a copy.
#include <cmath>

#include "isopach/io/expression.hpp"
#include "tests/fuzz/input.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace isopach;
  const fuzz::ExactBytes copy(data, size);
  fuzz::only_errors([&] {
    Expression formula(std::string(copy.bytes().data(), size), "@weight");
    Expression again = formula;
    constexpr double values[] = {0, -1, 0.5, 1e6, 1e-310, -1e150, 1e308, HUGE_VAL, NAN};
    for (std::size_t i = 0; i < std::size(values); ++i) {
      const auto value = [&](std::size_t k) { return values[(i + k) % std::size(values)]; };
      const Place place{value(0), value(1), value(2), value(3), value(4), value(5)};
      const double one = formula(place), other = again(place);
      fuzz::require(one == other || (std::isnan(one) && std::isnan(other)), "a copy is the same formula");
    }
  });
  return 0;
}
