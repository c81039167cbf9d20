#include "isopach/apps/heights_below.hpp"

#include <limits>

#include "isopach/base/parallel.hpp"
#include "isopach/overlay/interpolate.hpp"
#include "isopach/overlay/localise.hpp"

namespace isopach {

Array<double> heights_below(const Array<Point2>& xy, const MatchSurface& surface, const Context& context) {
  const Locations where = localise_in_order(xy, surface.t, surface.xy, context);
  Array<double> below = interpolate(where, xy, surface.t, surface.xy, surface.z, context);
  for_each_index(xy.size(), [&](std::size_t i) {
    const Location at = where[i];
    const bool known = at.kind == Location::Kind::node       ? surface.weight[at.id] > 0
                       : at.kind == Location::Kind::triangle ? surface.footprint.keeps(at.id)
                       : at.kind == Location::Kind::edge     ? surface.footprint.keeps(triangle_of(at.id))
                                                             : false;
    if (!known) below[i] = std::numeric_limits<double>::quiet_NaN();
  });
  return below;
}

}  // namespace isopach
