#include "isopach/report/page/change_values.hpp"

#include <algorithm>
#include <cmath>

namespace isopach::values {
namespace {

Json place(const Comparison& c, const Point2& p) {
  const Point3 at = c.frame.to_input({p.x, p.y, 0});
  return Json::array({real(at.x), real(at.y)});
}

Json bounds_json(const Comparison& c, const Change& change) {
  Box2 box;
  for (const PolygonWithHoles& polygon : change.outline)
    for (const Point2& p : polygon.rings[0]) box.add(p);
  if (box.empty()) box.add(change.largest_at);
  return {{"min", place(c, box.min)}, {"max", place(c, box.max)}};
}

Json change_json(const Comparison& c, std::size_t i) {
  const Change& x = c.changes->list[i];
  const bool is_sure = x.sigma && *x.sigma > 0;
  return {{"id", i + 1},
          {"net", real(x.net())},
          {"above", real(x.gained ? x.volume : 0)},
          {"below", real(x.gained ? 0 : x.volume)},
          {"sigma_net", x.sigma ? real(*x.sigma) : Json(nullptr)},
          {"area", real(x.area)},
          {"mean", real(x.mean_d())},
          {"max", real(x.largest_d())},
          {"max_at", place(c, x.largest_at)},
          {"centroid", place(c, x.centroid)},
          {"bounds", bounds_json(c, x)},
          {"points_a", x.points[0]},
          {"points_b", x.points[1]},
          {"significance", is_sure ? real(x.volume / *x.sigma) : Json(nullptr)},
          {"significant", x.sigma ? Json(x.volume > c.uncertainty.deviations * *x.sigma) : Json(nullptr)}};
}

/// The greatest of 1, 2, 5 × 10^k that is at most v, and the next one.
struct Step {
  int power, digit;
  [[nodiscard]] double value() const {
    constexpr std::array<double, 3> digits{1, 2, 5};
    const double tens = std::pow(10.0, std::abs(power));
    return power < 0 ? digits[static_cast<std::size_t>(digit)] / tens : digits[static_cast<std::size_t>(digit)] * tens;
  }
  void next() {
    if (++digit == 3) digit = 0, ++power;
  }
};

/// How many objects are at least so large, at 1, 2, 5 × 10^k from the smallest to the largest.
Json frequency_json(const std::vector<Change>& list) {
  Json volumes = Json::array(), gained = Json::array(), lost = Json::array();
  if (!list.empty() && list.back().volume > 0) {  // the largest first
    Step step{static_cast<int>(std::floor(std::log10(list.back().volume))) - 1, 0};
    for (; step.value() <= list.front().volume; step.next()) {
      Step next = step;
      next.next();
      const double v = step.value();
      if (next.value() <= list.back().volume) continue;
      const auto count = [&](bool of) {
        return std::count_if(list.begin(), list.end(),
                             [&](const Change& x) { return x.gained == of && x.volume >= v; });
      };
      volumes.push_back(real(v)), gained.push_back(count(true)), lost.push_back(count(false));
    }
  }
  return {{"volumes", volumes}, {"gained", gained}, {"lost", lost}};
}

Json sums_json(const Detected& d) {
  return {{"above", real(d.above)}, {"below", real(d.below)}, {"area", real(d.area)}};
}

}  // namespace

Json changes_json(const Comparison& c) {
  Json list = Json::array();
  for (std::size_t i = 0; i < c.changes->list.size(); ++i) list.push_back(change_json(c, i));
  return list;
}

Json change_summary_json(const Comparison& c) {
  const Changes& x = *c.changes;
  Json small = sums_json(x.small.sum);
  small["gained"] = x.small.gained, small["lost"] = x.small.lost;
  const auto gained = std::count_if(x.list.begin(), x.list.end(), [](const Change& change) { return change.gained; });
  return {{"level", x.level > 0 ? "height" : "lod"},
          {"height", x.level > 0 ? real(x.level) : Json(nullptr)},
          {"min_area", real(x.min_area)},
          {"min_volume", real(c.options.changes.min_volume)},
          {"gained", gained},
          {"lost", static_cast<std::ptrdiff_t>(x.list.size()) - gained},
          {"all", sums_json(x.all)},
          {"small", small},
          {"frequency", frequency_json(x.list)}};
}

}  // namespace isopach::values
