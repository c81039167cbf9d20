// A scan of the unit square as the search sees it.
#pragma once
#include "isopach/base/random.hpp"
#include "isopach/match/surface/surface.hpp"

namespace isopach::test {

/// Random nodes in curve order of the unit square, with the heights that `height` gives to (place, number).
template <class Height>
MatchSurface square(std::size_t n, std::uint64_t seed, const Height& height) {
  const RandomStream random(seed, 0);
  Array<Point2> places(n);
  for (std::size_t i = 0; i < n; ++i) places[i] = {random.uniform(2 * i), random.uniform(2 * i + 1)};
  const CurveBox box = curve_box({{0, 0}, {1, 1}});
  Array<Point2> sorted;
  (void)curve_order(places, box, nullptr, &sorted);
  Array<double> z(n);
  for (std::size_t i = 0; i < n; ++i) z[i] = height(sorted[i], i);
  return make_surface(std::move(sorted), std::move(z), box, false, 0, {});
}

}  // namespace isopach::test
