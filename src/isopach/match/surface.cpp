#include "isopach/match/surface.hpp"

#include <utility>

#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/measure/measures.hpp"

namespace isopach {

namespace {

/// By gathering round the nodes in the order of the triangles: the same bits for any number of threads.
Array<double> node_areas(const Triangulation& t, std::span<const Point2> xy, const Footprint& footprint) {
  Array<double> area(xy.size());
  std::fill(area.begin(), area.end(), 0.0);
  for (Index i = 0; i < t.real; ++i) {
    if (!footprint.keeps(i)) continue;
    const auto& v = t.triangles[i].v;
    const double third = triangle_area(xy[v[0]], xy[v[1]], xy[v[2]]) / 3;
    for (const Index node : v) area[node] += third;
  }
  return area;
}

}  // namespace

MatchSurface make_surface(Array<Point2> xy, Array<double> z, const CurveBox& box, bool trim, double max_edge,
                          const Context& context) {
  MatchSurface s;
  s.xy = std::move(xy);
  s.z = std::move(z);
  s.t = triangulate(s.xy, box, context);
  s.footprint = footprint(s.t, s.xy, trim, max_edge, context);
  s.weight = node_areas(s.t, s.xy, s.footprint);
  return s;
}

MatchSurface thinned(std::span<const Point2> xy, std::span<const double> z, std::size_t run, bool trim,
                     const Context& context) {
  const std::size_t n = (xy.size() + run - 1) / run;
  Array<Point3> means(n);
  for_each_index(n, [&](std::size_t i) {
    const std::size_t begin = i * run, end = std::min(xy.size(), begin + run);
    Point3 sum{0, 0, 0};
    for (std::size_t k = begin; k < end; ++k) sum = {sum.x + xy[k].x, sum.y + xy[k].y, sum.z + z[k]};
    const auto count = static_cast<double>(end - begin);
    means[i] = {sum.x / count, sum.y / count, sum.z / count};
  });
  Array<Point2> places(n);
  for_each_index(n, [&](std::size_t i) { places[i] = {means[i].x, means[i].y}; });
  Box2 bounds;
  for (const Point2& p : places) bounds.add(p);
  const CurveBox box = curve_box(bounds);
  Array<Point2> sorted;
  const Array<Index> order = curve_order(places, box, nullptr, &sorted);
  Array<Point2> nodes;
  Array<double> heights;
  for (std::size_t i = 0; i < n; ++i) {
    if (i > 0 && sorted[i] == sorted[i - 1]) continue;
    nodes.push_back(sorted[i]);
    heights.push_back(means[order[i]].z);
  }
  return make_surface(std::move(nodes), std::move(heights), box, trim, 0, context);
}

}  // namespace isopach
