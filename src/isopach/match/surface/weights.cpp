#include "isopach/match/surface/weights.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "isopach/base/error.hpp"
#include "isopach/compare/weighting.hpp"

namespace isopach {

namespace {

using Kind = WeightSource::Kind;
using From = WeightSource::Scan;

double checked(double value, const std::string& what) {
  if (std::isnan(value)) return 0;
  if (value < 0 || std::isinf(value))
    throw InputError(
        fmt::format("@weight: {} is {} at a point of FIXED: weights are finite and 0 or more", what, value));
  return value;
}

Array<double> by_formula(const WeightSource& weight, const Frame& frame, const MatchSurface& s) {
  Formula formula = weight.formula;
  const Array<double> slopes = steepness(s);
  const auto& r = frame.rotation;
  const Point3& o = frame.origin;
  const Point3 origin{r[0] * o.x + r[1] * o.y + r[2] * o.z, r[3] * o.x + r[4] * o.y + r[5] * o.z,
                      r[6] * o.x + r[7] * o.y + r[8] * o.z};
  Array<double> values(s.xy.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double z = s.z[i] + origin.z;
    values[i] = checked(formula({s.xy[i].x + origin.x, s.xy[i].y + origin.y, z, z, slopes[i], slopes[i]}),
                        "'" + weight.text + "'");
  }
  return values;
}

Array<double> by_raster(const WeightSource& weight, const Frame& frame, const MatchSurface& s) {
  if (frame.rotation != std::array<double, 9>{1, 0, 0, 0, 1, 0, 0, 0, 1})
    throw UsageError(
        "@weight: a raster is in x and y, so it goes with @direction z alone: leave the direction, or "
        "give a formula");
  Array<double> values(s.xy.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = checked(weight.raster->at({s.xy[i].x + frame.origin.x, s.xy[i].y + frame.origin.y, 0}), weight.text);
  return values;
}

void give(MatchSurface& s, Array<double> values, const std::string& name) {
  if (std::all_of(values.begin(), values.end(), [](double v) { return v == 0; }))
    throw InputError("@weight: " + name + " is 0 at every point: nothing is left to match");
  weigh(s, std::move(values));
}

}  // namespace

void apply_weight(const CloudView& moving, const CloudView& fixed, const HeightField& moving_field,
                  const HeightField& fixed_field, const Frame& frame, const CompareOptions& options,
                  MatchSurface& moving_surface, MatchSurface& fixed_surface) {
  const WeightSource& w = options.weight;
  if (w.kind == Kind::none) return;
  stages::check_read(w);
  if (w.kind == Kind::expression) return give(fixed_surface, by_formula(w, frame, fixed_surface), w.text);
  if (w.kind == Kind::raster) return give(fixed_surface, by_raster(w, frame, fixed_surface), w.text);
  const AttributeView* of_fixed = w.scan == From::b ? nullptr : fixed.find_attribute(w.text);
  const AttributeView* of_moving = w.scan == From::a ? nullptr : moving.find_attribute(w.text);
  if (of_moving != nullptr) {
    give(moving_surface, stages::attribute_of_nodes(moving, *of_moving, moving_field, "MOVING"), w.text);
  } else if (of_fixed != nullptr) {
    give(fixed_surface, stages::attribute_of_nodes(fixed, *of_fixed, fixed_field, "FIXED"), w.text);
  } else {
    throw InputError(
        fmt::format("@weight: no scan that it may belong to has an attribute '{}': `isopach info` lists "
                    "those they have",
                    w.text));
  }
}

}  // namespace isopach
