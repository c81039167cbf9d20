#include "isopach/report/page/detail_told.hpp"

#include <algorithm>

namespace isopach {

bool tells_detail(const Comparison& c) {
  if (!c.detail) return false;
  if (c.options.measure == MeasureKind::dV) return true;
  const auto [fewer, more] = std::minmax(c.compared_points[0], c.compared_points[1]);
  return static_cast<double>(more) >= different_densities * static_cast<double>(fewer);
}

}  // namespace isopach
