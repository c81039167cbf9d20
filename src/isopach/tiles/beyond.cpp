#include "isopach/tiles/beyond.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "isopach/base/parallel.hpp"
#include "isopach/geom/convex_hull.hpp"
#include "isopach/geom/predicates.hpp"

namespace isopach {
namespace {

struct Side {
  Point2 from, to;

  [[nodiscard]] bool leaves_out(const Point2& p) const { return orientation(from, to, p) < 0; }
};

/// The sides that corners of the box lie beyond, every second or third of them where there are many; one alone where it
/// leaves out the whole box.
std::vector<Side> sides_to_ask(std::span<const Point2> hull, const Box2& box) {
  const std::array<Point2, 4> corners{{box.min, {box.max.x, box.min.y}, box.max, {box.min.x, box.max.y}}};
  std::vector<Side> found;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Side side{hull[i], hull[(i + 1) % hull.size()]};
    const auto out = std::count_if(corners.begin(), corners.end(), [&](const Point2& p) { return side.leaves_out(p); });
    if (out == 4) return {side};
    if (out > 0) found.push_back(side);
  }
  constexpr std::size_t most = 64;
  const std::size_t step = (found.size() + most - 1) / most;
  std::vector<Side> sides;
  for (std::size_t i = 0; i < found.size(); i += step) sides.push_back(found[i]);
  return sides;
}

}  // namespace

Array<std::uint64_t> sides_beyond(std::span<const Point2> hull, std::span<const Point2> xy) {
  Array<std::uint64_t> beyond(xy.size(), 0);
  if (hull.size() < 3 || xy.empty()) return beyond;
  const std::vector<Side> sides = sides_to_ask(hull, box_of(xy));
  if (sides.empty()) return beyond;
  ConvexHull inside;
  inside.add(hull);
  for_each_index(xy.size(), [&](std::size_t i) {
    if (inside.holds(xy[i])) return;
    for (std::size_t k = 0; k < sides.size(); ++k)
      if (sides[k].leaves_out(xy[i])) beyond[i] |= std::uint64_t{1} << k;
  });
  return beyond;
}

}  // namespace isopach
