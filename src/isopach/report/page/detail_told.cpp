#include "isopach/report/page/detail_told.hpp"

#include <algorithm>
#include <cmath>

namespace isopach {

bool tells_detail(const Comparison& c) {
  if (!c.detail) return false;
  if (c.options.measure == MeasureKind::dV) return true;
  const auto shared = [](const PointFields& fields) {
    return static_cast<double>(
        std::count_if(fields.dz_signed.begin(), fields.dz_signed.end(), [](double d) { return std::isfinite(d); }));
  };
  const double a = shared(c.fields_a), b = shared(c.fields_b);
  return std::max(a, b) >= different_densities * std::min(a, b);
}

}  // namespace isopach
