#include "isopach/overlay/border.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "isopach/base/fixed_sum.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/first_corner.hpp"
#include "isopach/geom/predicates.hpp"

namespace isopach {

namespace {

double squared_distance(const Point2& p, const Point2& q) {
  return (p.x - q.x) * (p.x - q.x) + (p.y - q.y) * (p.y - q.y);
}

[[gnu::always_inline]] inline double longest_edge2(const Triangle& t, std::span<const Point2> xy) {
  const Point2 &a = xy[t.v[0]], &b = xy[t.v[1]], &c = xy[t.v[2]];
  return std::max({squared_distance(a, b), squared_distance(b, c), squared_distance(c, a)});
}

/// f(h) for every half-edge h that starts at the origin of `first`, those to the infinite node included.
template <class F>
void for_edges_round(const Triangulation& t, HalfEdge first, F&& f) {
  HalfEdge h = first;
  do {
    f(h);
    h = t.next_leaving(h);
  } while (h != first);
}

/// Squared lengths of the three shortest edges at a node, ascending; infinite where there are fewer.
class ShortestEdges {
 public:
  /// Without branches: which of them a length displaces is left to chance.
  void add(double length2) {
    const double second = std::max(a_, length2), third = std::max(b_, second);
    a_ = std::min(a_, length2), b_ = std::min(b_, second), c_ = std::min(c_, third);
  }
  /// The third; the longest where there are fewer.
  [[nodiscard]] double third() const { return std::isfinite(c_) ? c_ : std::isfinite(b_) ? b_ : a_; }

 private:
  static constexpr double none = std::numeric_limits<double>::infinity();
  double a_ = none, b_ = none, c_ = none;
};

}  // namespace

// One pass over the triangles, each of whose half-edges counts at its origin. Triangles lie in memory as their nodes
// do, so a block of them writes to a range of nodes of its own and keeps the few edges that start elsewhere for the
// end: the order of edges is no matter.
Array<double> squared_third_edges(const Triangulation& t, std::span<const Point2> xy) {
  constexpr std::size_t block = std::size_t{1} << 15;
  struct Edge {
    Index origin;
    double length2;
  };
  using Edges = std::vector<Edge>;
  Array<ShortestEdges> shortest(t.nodes);
  const auto first_node = [&](std::size_t triangle) { return static_cast<Index>(triangle * t.nodes / t.real); };
  const Edges elsewhere = gather_blocks<Edges>(t.real, block, [&](std::size_t begin, std::size_t end) {
    const Index first = first_node(begin), last = first_node(end);
    Edges others;
    for (std::size_t i = begin; i < end; ++i) {
      const auto& v = t.triangles[i].v;
      const Point2 &a = xy[v[0]], &b = xy[v[1]], &c = xy[v[2]];
      const std::array<double, 3> length2{squared_distance(a, b), squared_distance(b, c), squared_distance(c, a)};
      for (std::size_t k = 0; k < 3; ++k)
        if (v[k] >= first && v[k] < last)
          shortest[v[k]].add(length2[k]);
        else
          others.push_back({v[k], length2[k]});
    }
    return others;
  });
  for (const Edge& e : elsewhere) shortest[e.origin].add(e.length2);
  for (std::size_t i = t.real; i < t.triangles.size(); ++i) {  // sides of the hull, from their other ends
    const auto& v = t.triangles[i].v;
    shortest[v[0]].add(squared_distance(xy[v[0]], xy[v[1]]));
  }
  Array<double> third(t.nodes);
  for_each_index(t.nodes, [&](std::size_t i) { third[i] = shortest[i].third(); });
  return third;
}

namespace {

/// Square of the spacing at the origin of `leaving`, from those of `squared_third_edges`.
double squared_spacing(const Triangulation& t, const Array<double>& third2, HalfEdge leaving) {
  double longest = 0, second = 0;
  for_edges_round(t, leaving, [&](HalfEdge h) {
    if (t.target(h) == no_index) return;
    const double of_neighbour = third2[t.target(h)];
    second = std::max(second, std::min(longest, of_neighbour));
    longest = std::max(longest, of_neighbour);
  });
  return std::min(third2[t.origin(leaving)], second);
}

/// Squared spacings of the nodes asked for last: a node of many triangles is asked for by each of them, one soon after
/// the other, and its spacing takes a look at all.
class Spacings {
 public:
  Spacings(const Triangulation& t, const Array<double>& third2) : t_(t), third2_(third2) { known_.fill({no_index, 0}); }
  [[nodiscard]] double at(HalfEdge leaving) {
    const Index node = t_.origin(leaving);
    Known& known = known_[node % known_.size()];
    if (known.node != node) known = {node, squared_spacing(t_, third2_, leaving)};
    return known.spacing2;
  }

 private:
  struct Known {
    Index node;
    double spacing2;
  };
  const Triangulation& t_;
  const Array<double>& third2_;
  std::array<Known, 64> known_;
};

/// abc / 4A: the area of a thin triangle exactly, before it is rounded.
double circumradius(const Triangle& t, std::span<const Point2> xy) {
  const std::array<Index, 3> v = from_first_corner(t.v);
  const Point2 &a = xy[v[0]], &b = xy[v[1]], &c = xy[v[2]];
  const double ab = std::hypot(b.x - a.x, b.y - a.y), bc = std::hypot(c.x - b.x, c.y - b.y),
               ca = std::hypot(a.x - c.x, a.y - c.y);
  const double left = (b.x - a.x) * (c.y - a.y), right = (b.y - a.y) * (c.x - a.x);
  double twice_area = left - right;
  if (!(twice_area > 1e-3 * (std::fabs(left) + std::fabs(right)))) twice_area = exact::twice_area(a, b, c);
  return ab * (bc / (2 * twice_area)) * ca;
}

enum Mark : unsigned char { kept = 0, taken = 1, stretched = 2 };

/// Which triangles are stretched more than rim_stretch.
class Stretches {
 public:
  Stretches(const Triangulation& t, std::span<const Point2> xy, const Array<double>& third2)
      : t_(t), xy_(xy), third2_(third2), spacings_(t, third2) {}

  /// Of those the square of the spacing that they are measured by.
  [[nodiscard]] std::optional<double> spacing2_if_stretched(std::size_t i) {
    const Triangle& triangle = t_.triangles[i];
    const double length2 = longest_edge2(triangle, xy_);
    // Each corner has the other two as neighbours, so no spacing is less than the least of the three.
    const double least = std::min({third2_[triangle.v[0]], third2_[triangle.v[1]], third2_[triangle.v[2]]});
    if (length2 <= rim_stretch * rim_stretch * least) return std::nullopt;
    double s2 = 0;
    for (Index k = 0; k < 3; ++k) s2 = std::max(s2, spacings_.at(half_edge(static_cast<Index>(i), k)));
    if (length2 <= rim_stretch * rim_stretch * s2) return std::nullopt;
    return s2;
  }

 private:
  const Triangulation& t_;
  std::span<const Point2> xy_;
  const Array<double>& third2_;
  Spacings spacings_;
};

bool is_beyond(const SizeLimits& limits, const Triangle& triangle, std::span<const Point2> xy) {
  return (limits.edge > 0 && longest_edge2(triangle, xy) > limits.edge * limits.edge) ||
         (limits.circumradius > 0 && circumradius(triangle, xy) > limits.circumradius);
}

void trim(const Triangulation& t, std::span<const Point2> xy, const Array<double>& third2, const AskedTriangles& asked,
          Array<unsigned char>& mark) {
  std::vector<Index> front =
      gather_blocks<std::vector<Index>>(t.real, default_block, [&](std::size_t begin, std::size_t end) {
        std::vector<Index> seeds;
        Stretches stretches(t, xy, third2);
        for (std::size_t i = begin; i < end; ++i) {
          const Triangle& triangle = t.triangles[i];
          mark[i] = kept;
          if (!asked.holds(i)) continue;
          const std::optional<double> s2 = stretches.spacing2_if_stretched(i);
          if (!s2) continue;
          mark[i] = stretched;
          const bool at_hull =
              std::any_of(triangle.n.begin(), triangle.n.end(), [&](HalfEdge h) { return t.is_ghost(triangle_of(h)); });
          if (!at_hull && longest_edge2(triangle, xy) <= gap_stretch * gap_stretch * *s2) continue;
          mark[i] = taken;
          seeds.push_back(static_cast<Index>(i));
        }
        return seeds;
      });
  while (!front.empty()) {
    const Index i = front.back();
    front.pop_back();
    for (const HalfEdge h : t.triangles[i].n) {
      const Index next = triangle_of(h);
      if (t.is_ghost(next) || mark[next] != stretched) continue;
      mark[next] = taken;
      front.push_back(next);
    }
  }
}

struct Totals {
  Index removed = 0;
  FixedSum area, removed_area;
};

double area_of(const Triangle& t, std::span<const Point2> xy) {
  const std::array<Index, 3> v = from_first_corner(t.v);
  return triangle_area(xy[v[0]], xy[v[1]], xy[v[2]]);
}

}  // namespace

Array<unsigned char> plainly_kept(const Triangulation& t, std::span<const Point2> xy, bool trim_rim,
                                  const SizeLimits& limits, const Context& context) {
  context.check();
  Array<unsigned char> plain(t.real);
  const Array<double> third2 = trim_rim && t.real > 0 ? squared_third_edges(t, xy) : Array<double>();
  for_blocks(t.real, default_block, [&](std::size_t begin, std::size_t end) {
    Stretches stretches(t, xy, third2);
    for (std::size_t i = begin; i < end; ++i) {
      const bool is_stretched = trim_rim && stretches.spacing2_if_stretched(i).has_value();
      plain[i] = is_stretched || is_beyond(limits, t.triangles[i], xy) ? 0 : 1;
    }
  });
  return plain;
}

Footprint footprint(const Triangulation& t, std::span<const Point2> xy, bool trim_rim, const SizeLimits& limits,
                    const Context& context, const AskedTriangles& asked) {
  context.check();
  Footprint f;
  f.removed.resize(t.real);
  if (trim_rim && t.real > 0) {
    f.third2 = squared_third_edges(t, xy);
    trim(t, xy, f.third2, asked, f.removed);
  } else {
    std::fill(f.removed.begin(), f.removed.end(), kept);
  }
  const FixedScale scale{1, asked.area_bound > 0 ? asked.area_bound : box_of(xy).area()};
  Totals all = reduce_blocks<Totals>(
      t.real, default_block,
      [&](std::size_t begin, std::size_t end) {
        Totals part{0, FixedSum(scale), FixedSum(scale)};
        for (std::size_t i = begin; i < end; ++i) {
          const bool is_asked = asked.holds(i);
          const bool gone = is_asked && (f.removed[i] == taken || is_beyond(limits, t.triangles[i], xy));
          f.removed[i] = gone ? 1 : 0;
          part.removed += gone ? 1 : 0;
          if (is_asked) (gone ? part.removed_area : part.area).add(area_of(t.triangles[i], xy));
        }
        return part;
      },
      [](Totals& total, const Totals& part) {
        total.removed += part.removed;
        total.area.add(part.area);
        total.removed_area.add(part.removed_area);
      });
  all.area.add(asked.kept_elsewhere);
  if (all.removed == 0) f.removed.clear();
  f.kept_sum = all.area, f.removed_sum = all.removed_area;
  f.area = all.area.value();
  f.removed_area = all.removed_area.value();
  return f;
}

namespace {

/// By node: a half-edge of a removed triangle that starts there, no_index where there is none.
Array<HalfEdge> edges_at_gaps(const Footprint& f, const Triangulation& t) {
  Array<HalfEdge> at_gap(t.nodes, no_index);
  for_each_index(t.real, [&](std::size_t i) {
    if (f.keeps(static_cast<Index>(i))) return;
    for (Index k = 0; k < 3; ++k) write_shared(at_gap[t.triangles[i].v[k]], half_edge(static_cast<Index>(i), k));
  });
  return at_gap;
}

/// Adds the removed ones among the triangles that a node is on, as gaps if others are kept.
class MarginBuilder {
 public:
  MarginBuilder(const Footprint& f, const Triangulation& t, std::span<const Point2> xy) : f_(f), t_(t), xy_(xy) {}

  template <class ForTriangles>
  Side add(Index node, const ForTriangles& for_triangles, std::vector<Margin::Gap>& gaps) const {
    bool any_kept = false;
    const std::size_t before = gaps.size();
    for_triangles([&](Index i) {
      if (t_.is_ghost(i)) return;
      if (f_.keeps(i)) {
        any_kept = true;
        return;
      }
      const auto& v = t_.triangles[i].v;
      gaps.push_back({node, {xy_[v[0]], xy_[v[1]], xy_[v[2]]}});
    });
    if (any_kept) return gaps.size() > before ? Side::rim : Side::inside;
    gaps.resize(before);
    return Side::outside;
  }

 private:
  const Footprint& f_;
  const Triangulation& t_;
  std::span<const Point2> xy_;
};

/// side_of(node, gaps) for all nodes, in parallel.
template <class F>
Margin make_margin(std::size_t nodes, F&& side_of) {
  using Gaps = std::vector<Margin::Gap>;
  Margin m;
  m.side.resize(nodes);
  m.gaps = gather_blocks<Gaps>(nodes, default_block, [&](std::size_t begin, std::size_t end) {
    Gaps gaps;
    for (std::size_t i = begin; i < end; ++i) m.side[i] = side_of(static_cast<Index>(i), gaps);
    return gaps;
  });
  return m;
}

}  // namespace

Margins margins(const Footprint& f, const Triangulation& t, std::span<const Point2> xy, const Locations& other_in_t,
                const Context& context) {
  context.check();
  using Kind = Location::Kind;
  using Gaps = std::vector<Margin::Gap>;
  const Array<HalfEdge> at_gap = f.is_whole() ? Array<HalfEdge>() : edges_at_gaps(f, t);
  const MarginBuilder builder(f, t, xy);
  const auto at_node = [&](Index node, Index v, Gaps& gaps) {
    if (f.is_whole() || at_gap[v] == no_index) return Side::inside;
    const auto round = [&](const auto& visit) {
      for_edges_round(t, at_gap[v], [&](HalfEdge h) { visit(triangle_of(h)); });
    };
    return builder.add(node, round, gaps);
  };
  const auto at_location = [&](Index node, Gaps& gaps) {
    const Location at = other_in_t[node];
    if (at.kind == Kind::none || at.kind == Kind::outside) return Side::outside;
    if (f.is_whole()) return Side::inside;
    if (at.kind == Kind::node) return at_node(node, at.id, gaps);
    if (at.kind == Kind::triangle) return f.keeps(at.id) ? Side::inside : Side::outside;
    const auto both_sides = [&](const auto& visit) {
      visit(triangle_of(at.id));
      visit(triangle_of(t.twin(at.id)));
    };
    return builder.add(node, both_sides, gaps);
  };
  Margins m;
  m.own = make_margin(xy.size(), [&](Index node, Gaps& gaps) { return at_node(node, node, gaps); });
  m.other = make_margin(other_in_t.size(), at_location);
  return m;
}

namespace {

// Whether the centroid of from, b, c, where `from` lies on the line p→q, is strictly left of it. Only where b and c lie
// on either side does rounding have a say, and then twice.
bool turns_left(const Point2& p, const Point2& q, const Point2& b, const Point2& c) {
  const int to_b = orientation(p, q, b), to_c = orientation(p, q, c);
  if (to_b >= 0 && to_c >= 0) return to_b + to_c > 0;
  if (to_b <= 0 && to_c <= 0) return false;
  return exact::twice_area(p, q, b) + exact::twice_area(p, q, c) > 0;
}

}  // namespace

// Whether the way to the centroid of from, b, c starts in one of the gaps at `node`: left of all their sides that
// `from` lies on.
bool FootprintOfNodes::leads_out(Index node, const Point2& from, const Point2& b, const Point2& c) const {
  const bool is_own = own_[node] != no_index;
  const Margin& margin = is_own ? m_.own : m_.other;
  const Index id = is_own ? own_[node] : other_[node];
  const auto starts_in = [&](const Margin::Gap& gap) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Point2 &p = gap.corners[k], &q = gap.corners[(k + 1) % 3];
      if (orientation(p, q, from) == 0 && !turns_left(p, q, b, c)) return false;
    }
    return true;
  };
  auto gap = std::lower_bound(margin.gaps.begin(), margin.gaps.end(), id,
                              [](const Margin::Gap& g, Index wanted) { return g.node < wanted; });
  for (; gap != margin.gaps.end() && gap->node == id; ++gap)
    if (starts_in(*gap)) return true;
  return false;
}

bool FootprintOfNodes::holds(const std::array<Index, 3>& cell, std::span<const Point2> xy) const {
  const std::array<Side, 3> sides{side(cell[0]), side(cell[1]), side(cell[2])};
  const Side least = std::min({sides[0], sides[1], sides[2]});
  if (least != Side::rim) return least == Side::inside;
  for (std::size_t k = 0; k < 3; ++k)
    if (sides[k] == Side::rim && leads_out(cell[k], xy[cell[k]], xy[cell[(k + 1) % 3]], xy[cell[(k + 2) % 3]]))
      return false;
  return true;
}

}  // namespace isopach
