#include "isopach/io/crs.hpp"

#include <cmath>

namespace isopach {

std::string unit_of_length(double metres) {
  const auto is = [metres](double length) { return std::fabs(metres - length) < 1e-9 * length; };
  if (is(1)) return "m";
  if (is(0.001)) return "mm";
  if (is(0.3048)) return "ft";
  if (is(1200.0 / 3937.0)) return "us-ft";
  return "unknown";
}

void set_crs(Cloud& cloud, const Crs& crs) {
  cloud.crs = crs.name;
  cloud.unit = crs.unit;
  cloud.vertical_unit = crs.vertical_unit;
}

}  // namespace isopach
