#include "isopach/match/surface/surface.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "isopach/base/median.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/measure/measures.hpp"

namespace isopach {

namespace {

constexpr double thin = 1e-9;  // twice the area over the squares of the sides: such facets have no slope

struct Slope {
  double x = 0, y = 0, area = 0;
};

/// The plane over a triangle; none over those that are removed or too thin.
struct Plane {
  bool exists = false;
  double bx, by, cx, cy;  ///< sides from the first corner to the others
  double twice;           ///< the area
  double gx, gy;          ///< slope
};

[[gnu::always_inline]] inline Plane plane_of(const MatchSurface& s, Index triangle) {
  Plane p;
  if (!s.footprint.keeps(triangle)) return p;
  const auto& v = s.t.triangles[triangle].v;
  const Point2 &a = s.xy[v[0]], &b = s.xy[v[1]], &c = s.xy[v[2]];
  p.bx = b.x - a.x, p.by = b.y - a.y, p.cx = c.x - a.x, p.cy = c.y - a.y;
  p.twice = p.bx * p.cy - p.by * p.cx;
  p.exists = p.twice > thin * (p.bx * p.bx + p.by * p.by + p.cx * p.cx + p.cy * p.cy);
  const double zb = s.z[v[1]] - s.z[v[0]], zc = s.z[v[2]] - s.z[v[0]];
  p.gx = (zb * p.cy - zc * p.by) / p.twice;
  p.gy = (zc * p.bx - zb * p.cx) / p.twice;
  return p;
}

// The mean slope around each node, by area. One after the other in the order of the triangles: the same bits for any
// number of threads. Not from the facets: they are more to read than it is to compute their planes twice.
Array<Slope> node_slopes(const MatchSurface& s) {
  Array<Slope> slopes(s.xy.size());
  std::fill(slopes.begin(), slopes.end(), Slope{});
  for (Index i = 0; i < s.t.real; ++i) {
    const Plane p = plane_of(s, i);
    if (!p.exists) continue;
    const double area = p.twice / 2, x = area * p.gx, y = area * p.gy;
    for (const Index node : s.t.triangles[i].v) slopes[node].x += x, slopes[node].y += y, slopes[node].area += area;
  }
  for_each_index(slopes.size(), [&](std::size_t i) {
    if (slopes[i].area > 0) slopes[i].x /= slopes[i].area, slopes[i].y /= slopes[i].area;
  });
  return slopes;
}

// Exact where the surface is quadratic and has these slopes: along an edge the slope changes by the curvature times its
// length, and the mean over the facet of the product of two barycentric coordinates is 1/12.
float rise_of(const MatchSurface& s, const Array<Slope>& slopes, const std::array<Index, 3>& v) {
  double rise = 0;
  for (Index k = 0; k < 3; ++k) {
    const Index a = v[k], b = v[next_side(k)];
    const double dx = s.xy[b].x - s.xy[a].x, dy = s.xy[b].y - s.xy[a].y;
    rise += (slopes[a].x - slopes[b].x) * dx + (slopes[a].y - slopes[b].y) * dy;
  }
  return static_cast<float>(rise / 24);
}

// Each facet is written once.
void describe_facets(MatchSurface& s) {
  const Array<Slope> slopes = node_slopes(s);
  s.weight.resize(s.xy.size());
  for_each_index(slopes.size(), [&](std::size_t i) { s.weight[i] = slopes[i].area / 3; });
  s.facets.resize(s.t.real);
  s.cosine.resize(s.t.real);
  for_each_index(s.t.real, [&](std::size_t i) {
    Facet& f = s.facets[i] = {};
    s.cosine[i] = 1;
    const Plane p = plane_of(s, static_cast<Index>(i));
    if (!p.exists) return;
    const auto& v = s.t.triangles[i].v;
    f.x = s.xy[v[0]].x, f.y = s.xy[v[0]].y, f.z = s.z[v[0]];
    f.gx = static_cast<float>(p.gx), f.gy = static_cast<float>(p.gy);
    f.bx = static_cast<float>(p.cy / p.twice), f.by = static_cast<float>(-p.cx / p.twice);
    f.cx = static_cast<float>(-p.by / p.twice), f.cy = static_cast<float>(p.bx / p.twice);
    const double x = (slopes[v[0]].x + slopes[v[1]].x + slopes[v[2]].x) / 3,
                 y = (slopes[v[0]].y + slopes[v[1]].y + slopes[v[2]].y) / 3;
    f.smooth_gx = static_cast<float>(x), f.smooth_gy = static_cast<float>(y);
    f.rise = rise_of(s, slopes, v);
    s.cosine[i] =
        static_cast<float>(1 / std::sqrt(1 + (double)f.smooth_gx * f.smooth_gx + (double)f.smooth_gy * f.smooth_gy));
  });
}

}  // namespace

MatchSurface make_surface(Array<Point2> xy, Array<double> z, const CurveBox& box, bool trim, double max_edge,
                          const Context& context) {
  MatchSurface s;
  s.xy = std::move(xy);
  s.z = std::move(z);
  s.t = triangulate(s.xy, box, context);
  s.footprint = footprint(s.t, s.xy, trim, {max_edge, 0}, context);
  describe_facets(s);
  return s;
}

MatchSurface make_surface(Array<Point2> xy, Array<double> z, Triangulation t, const Array<unsigned char>& kept) {
  MatchSurface s;
  s.xy = std::move(xy);
  s.z = std::move(z);
  s.t = std::move(t);
  s.footprint.removed.resize(kept.size());
  for_each_index(kept.size(), [&](std::size_t i) { s.footprint.removed[i] = kept[i] == 0 ? 1 : 0; });
  describe_facets(s);
  return s;
}

void weigh(MatchSurface& s, Array<double> mu) {
  s.mu = std::move(mu);
  for_each_index(s.mu.size(), [&](std::size_t i) { s.weight[i] *= s.mu[i]; });
  s.facet_weight.resize(s.t.real);
  for_each_index(s.t.real, [&](std::size_t i) {
    const auto& v = s.t.triangles[i].v;
    s.facet_weight[i] = static_cast<float>((s.mu[v[0]] + s.mu[v[1]] + s.mu[v[2]]) / 3);
  });
}

Array<double> steepness(const MatchSurface& s) {
  const Array<Slope> slopes = node_slopes(s);
  Array<double> steep(slopes.size());
  for_each_index(slopes.size(), [&](std::size_t i) { steep[i] = std::hypot(slopes[i].x, slopes[i].y); });
  return steep;
}

// The mean slope around a node is Σ over its facets and their corners of height · q / (2 · area), q the side opposite
// to the corner, turned by a right angle. A corner between two facets counts with the sum of its q.
Array<SlopeNoise> slope_noise(const MatchSurface& s) {
  Array<SlopeNoise> noise(s.xy.size());
  Array<double> twice_area(s.xy.size());
  Array<Point2> own(s.xy.size());  // Σ q of the node itself: 0 where facets surround it
  std::fill(noise.begin(), noise.end(), SlopeNoise{});
  std::fill(twice_area.begin(), twice_area.end(), 0.0);
  std::fill(own.begin(), own.end(), Point2{0, 0});
  const auto facet = [&](Index t) { return !s.t.is_ghost(t) && s.facets[t].exists(); };
  const auto turned = [&](Index t, Index k) {  // q of corner k
    const auto& v = s.t.triangles[t].v;
    const Point2 &p = s.xy[v[next_side(k)]], &q = s.xy[v[next_side(next_side(k))]];
    return Point2{p.y - q.y, q.x - p.x};
  };
  const auto add = [&](Index node, const Point2& q) {
    noise[node].xx += q.x * q.x, noise[node].xy += q.x * q.y, noise[node].yy += q.y * q.y;
  };
  for (Index t = 0; t < s.t.real; ++t) {
    if (!facet(t)) continue;
    const auto& v = s.t.triangles[t].v;
    const double twice = 2 * triangle_area(s.xy[v[0]], s.xy[v[1]], s.xy[v[2]]);
    for (Index k = 0; k < 3; ++k) {
      const Index next = next_side(k), n = s.t.triangles[t].n[k], other = triangle_of(n);
      const Point2 mine = turned(t, k), next_one = turned(t, next);
      twice_area[v[k]] += twice;
      own[v[k]] = {own[v[k]].x + mine.x, own[v[k]].y + mine.y};
      if (!facet(other)) {  // the side is of this facet alone
        add(v[k], next_one);
        add(v[next], mine);
        continue;
      }
      // The other facet has the same side the other way round: from v[next] to v[k].
      const Index from = side_of(n);
      const Point2 across = turned(other, from);  // of v[next] there, whose end is v[k]
      const Point2 across_next = turned(other, next_side(from));
      if (v[k] < v[next]) {
        add(v[k], {next_one.x + across.x, next_one.y + across.y});
        add(v[next], {mine.x + across_next.x, mine.y + across_next.y});
      }
    }
  }
  for_each_index(noise.size(), [&](std::size_t i) {
    if (!(twice_area[i] > 0)) return;
    SlopeNoise& c = noise[i];
    const double scale = 1 / (twice_area[i] * twice_area[i]);
    const Point2& q = own[i];
    c = {(c.xx + q.x * q.x) * scale, (c.xy + q.x * q.y) * scale, (c.yy + q.y * q.y) * scale};
  });
  return noise;
}

double roughness(const MatchSurface& s) {
  const Array<Slope> slopes = node_slopes(s);
  struct Around {
    double over = 0;  // of the node, Σ over the corners
    double corners = 0;
  };
  Array<Around> around(s.xy.size());
  std::fill(around.begin(), around.end(), Around{});
  for (Index i = 0; i < s.t.real; ++i) {
    if (!s.facets[i].exists()) continue;
    for (const Index node : s.t.triangles[i].v)
      for (const Index corner : s.t.triangles[i].v) {
        if (corner == node) continue;
        const Slope& g = slopes[node];
        around[node].over +=
            s.z[node] - s.z[corner] + g.x * (s.xy[corner].x - s.xy[node].x) + g.y * (s.xy[corner].y - s.xy[node].y);
        ++around[node].corners;
      }
  }
  std::vector<double> sizes;
  for (const Around& a : around)
    if (a.corners > 0) sizes.push_back(std::fabs(a.over) / a.corners);
  return mad_to_sigma * median(sizes);
}

MatchSurface thinned(const MatchSurface& s, std::size_t run, bool trim, const Context& context) {
  const std::size_t n = (s.xy.size() + run - 1) / run;
  const bool is_weighted = !s.mu.empty();
  struct Mean {
    double z, mu;
  };
  Array<Point2> places(n);
  Array<Mean> means(n);
  for_each_index(n, [&](std::size_t i) {
    const std::size_t begin = i * run, end = std::min(s.xy.size(), begin + run);
    Point3 sum{0, 0, 0};
    double mu = 0;
    for (std::size_t k = begin; k < end; ++k) {
      sum = {sum.x + s.xy[k].x, sum.y + s.xy[k].y, sum.z + s.z[k]};
      if (is_weighted) mu += s.mu[k];
    }
    const auto count = static_cast<double>(end - begin);
    places[i] = {sum.x / count, sum.y / count};
    means[i] = {sum.z / count, mu / count};
  });
  Box2 bounds;
  for (const Point2& p : places) bounds.add(p);
  const CurveBox box = curve_box(bounds);
  Array<Point2> sorted;
  const Array<Index> order = curve_order(places, box, nullptr, &sorted);
  Array<Point2> nodes;
  Array<double> heights, mu;
  for (std::size_t i = 0; i < n; ++i) {
    if (i > 0 && sorted[i] == sorted[i - 1]) continue;
    nodes.push_back(sorted[i]);
    heights.push_back(means[order[i]].z);
    if (is_weighted) mu.push_back(means[order[i]].mu);
  }
  MatchSurface result = make_surface(std::move(nodes), std::move(heights), box, trim, 0, context);
  if (is_weighted) weigh(result, std::move(mu));
  return result;
}

}  // namespace isopach
