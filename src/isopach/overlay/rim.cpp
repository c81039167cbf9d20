#include "isopach/overlay/rim.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "isopach/base/parallel.hpp"
#include "isopach/geom/predicates.hpp"

namespace isopach {
namespace {

/// Extent bits of a triangle.
unsigned char extent_of(const Triangulation& t, Index triangle, const Footprint& f, const Footprint& single) {
  if (t.is_ghost(triangle)) return 0;
  return static_cast<unsigned char>(in_hull | (f.keeps(triangle) ? in_footprint : 0) |
                                    (single.keeps(triangle) ? in_single : 0));
}

/// Cells that one side runs through.
class Walk {
 public:
  Walk(const Triangulation& t, std::span<const Point2> xy, std::span<const HalfEdge> leaving)
      : t_(t), xy_(xy), leaving_(leaving) {}

  /// f(cell) from the first node of the side to the second.
  template <class F>
  void operator()(const BorderSide& side, F&& f) const {
    Index node = side.from;
    HalfEdge leaving = leaving_[node];
    while (node != side.to) std::tie(node, leaving) = next_node(node, leaving, side.to, f);
  }

 private:
  /// The next node on the way, and a half-edge that leaves it.
  template <class F>
  std::pair<Index, HalfEdge> next_node(Index node, HalfEdge leaving, Index to, F&& f) const {
    const Point2 &p = xy_[node], &q = xy_[to];
    HalfEdge h = leaving;
    while (true) {  // round the node, until the way is found
      const Index next = t_.target(h);
      if (next == to) return {to, t_.twin(h)};
      if (next != no_index && orientation(p, q, xy_[next]) == 0 && is_ahead(p, q, xy_[next])) return {next, t_.twin(h)};
      const Index cell = triangle_of(h);
      if (!t_.is_ghost(cell)) {
        const Index beyond = t_.triangles[cell].v[previous_side(side_of(h))];
        if (orientation(p, q, xy_[next]) < 0 && orientation(p, q, xy_[beyond]) > 0) {
          f(cell);
          return through(node, half_edge(cell, next_side(side_of(h))), to, f);
        }
      }
      h = t_.next_leaving(h);
    }
  }

  /// From `from` across sides of T, of which `exit` is the first, to the next node on the way.
  template <class F>
  std::pair<Index, HalfEdge> through(Index from, HalfEdge exit, Index to, F&& f) const {
    const Point2 &p = xy_[from], &q = xy_[to];
    while (true) {
      const HalfEdge entry = t_.twin(exit);
      const Index cell = triangle_of(entry), first = next_side(side_of(entry)), second = previous_side(side_of(entry));
      const Index apex = t_.triangles[cell].v[second];
      f(cell);
      const int side = apex == to ? 0 : orientation(p, q, xy_[apex]);
      if (side == 0) return {apex, half_edge(cell, second)};
      exit = half_edge(cell, side > 0 ? first : second);  // from right of the way to left of it
    }
  }

  static bool is_ahead(const Point2& p, const Point2& q, const Point2& r) {
    return p.x != q.x ? (q.x > p.x) == (r.x > p.x) && r.x != p.x : (q.y > p.y) == (r.y > p.y) && r.y != p.y;
  }

  const Triangulation& t_;
  std::span<const Point2> xy_;
  std::span<const HalfEdge> leaving_;
};

/// By node that a side starts at: a half-edge that leaves it.
Array<HalfEdge> leaving_starts(const Triangulation& t, std::span<const BorderSide> sides) {
  Array<unsigned char> starts(t.nodes, 0);
  for (const BorderSide& side : sides) starts[side.from] = 1;
  Array<HalfEdge> leaving(t.nodes, no_index);
  for_each_index(t.real, [&](std::size_t i) {
    for (Index k = 0; k < 3; ++k) {
      const Index node = t.triangles[i].v[k];
      if (starts[node] != 0) write_shared(leaving[node], half_edge(static_cast<Index>(i), k));
    }
  });
  return leaving;
}

/// Twice the area of p, q, c: positive where c lies left of p→q.
double twice_area(const Point2& p, const Point2& q, const Point2& c) {
  return (q.x - p.x) * (c.y - p.y) - (q.y - p.y) * (c.x - p.x);
}

}  // namespace

std::vector<BorderSide> border_sides(const Triangulation& t, const Footprint& f, const Footprint* single) {
  std::vector<BorderSide> sides;
  if (f.is_whole() && single == nullptr) {
    if (t.real == 0) return sides;
    for (Index i = t.real; i < t.triangles.size(); ++i)
      sides.push_back({t.triangles[i].v[1], t.triangles[i].v[0], in_hull | in_footprint | in_single});
    return sides;
  }
  const Footprint& alone = single != nullptr ? *single : f;
  // Seen from what lies beyond them, which is little, and then in the order of the triangles that they are sides of.
  struct Found {
    HalfEdge at;
    unsigned char ends;
  };
  auto found =
      gather_blocks<std::vector<Found>>(t.triangles.size(), default_block, [&](std::size_t begin, std::size_t end) {
        std::vector<Found> part;
        for (auto i = static_cast<Index>(begin); i < end; ++i) {
          if (!t.is_ghost(i) && f.keeps(i) && alone.keeps(i)) continue;
          const unsigned beyond = extent_of(t, i, f, alone);
          for (const HalfEdge h : t.triangles[i].n) {
            const unsigned ends = extent_of(t, triangle_of(h), f, alone) & ~beyond;
            if (ends != 0) part.push_back({h, static_cast<unsigned char>(ends)});
          }
        }
        return part;
      });
  std::sort(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.at < b.at; });
  for (const Found& side : found) sides.push_back({t.origin(side.at), t.target(side.at), side.ends});
  return sides;
}

std::vector<RimCrossing> crossings(const Triangulation& t, std::span<const Point2> xy,
                                   std::span<const BorderSide> sides, const Context& context) {
  context.check();
  if (t.real == 0 || sides.empty()) return {};
  const Array<HalfEdge> leaving = leaving_starts(t, sides);
  const Walk walk(t, xy, leaving);
  constexpr std::size_t block = 256;
  std::vector<RimCrossing> found =
      gather_blocks<std::vector<RimCrossing>>(sides.size(), block, [&](std::size_t begin, std::size_t end) {
        std::vector<RimCrossing> part;
        for (std::size_t i = begin; i < end; ++i)
          walk(sides[i], [&](Index cell) { part.push_back({cell, static_cast<Index>(i)}); });
        return part;
      });
  std::sort(found.begin(), found.end(), [&](const RimCrossing& a, const RimCrossing& b) {  // not by how T was numbered
    const auto key = [&](const RimCrossing& c) {
      const BorderSide& s = sides[c.side];
      return std::tuple(c.cell, std::min(s.from, s.to), std::max(s.from, s.to), c.side);
    };
    return key(a) < key(b);
  });
  return found;
}

const std::vector<RimPiece>& RimCutter::operator()(const RimCell& cell) {
  RimPiece whole;
  constexpr std::array<unsigned char, 3> sides_at{0b101, 0b011, 0b110};  // side k runs from corner k to the next
  for (std::size_t k = 0; k < 3; ++k) {
    const Index v = cell.nodes[k];
    RimCorner& c = whole.corners.emplace_back();
    static_cast<Corner&>(c) = {xy_[v].x, xy_[v].y, z_[0][v], z_[1][v]};
    c.sides = sides_at[k];
  }
  const auto first = std::min_element(cell.nodes.begin(), cell.nodes.end()) - cell.nodes.begin();
  std::rotate(whole.corners.begin(), whole.corners.begin() + first, whole.corners.end());
  pieces_.assign(1, whole);
  unsigned bounded = 0;
  for (std::size_t i = 0; i < cell.across.size(); ++i) {
    BorderSide side = sides_[cell.across[i].side];
    for (; i + 1 < cell.across.size(); ++i) {  // a side of both scans
      const BorderSide& next = sides_[cell.across[i + 1].side];
      if (std::minmax(next.from, next.to) != std::minmax(side.from, side.to)) break;
      side.of |= next.of;
    }
    bounded |= side.of;
    cut_along(side, cell);
  }
  settle_heights(cell);
  for (RimPiece& piece : pieces_) {
    Point2 middle{0, 0};
    for (const Corner& c : piece.corners) middle.x += c.x, middle.y += c.y;
    const auto n = static_cast<double>(piece.corners.size());
    middle.x /= n, middle.y /= n;
    piece.in = cell.in;
    for (unsigned char bit = 1; bit < 1u << (2 * extents); bit = static_cast<unsigned char>(bit << 1))
      if ((bounded & bit) != 0)
        piece.in = static_cast<unsigned char>(is_in(middle, bit, cell) ? piece.in | bit : piece.in & ~unsigned{bit});
    std::rotate(piece.corners.begin(),
                std::min_element(piece.corners.begin(), piece.corners.end(),
                                 [](const Corner& a, const Corner& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; }),
                piece.corners.end());
  }
  return pieces_;
}

void RimCutter::cut_along(const BorderSide& side, const RimCell& cell) {
  next_.clear();
  for (const RimPiece& piece : pieces_) cut(piece, side, cell);
  std::swap(pieces_, next_);
}

/// At the nodes of the cell exact but for one rounding.
double RimCutter::height_over(const BorderSide& side, const Corner& c, const RimCell& cell) const {
  const Point2 &p = xy_[side.from], &q = xy_[side.to];
  for (const Index v : cell.nodes)
    if (xy_[v].x == c.x && xy_[v].y == c.y) return exact::twice_area(p, q, xy_[v]);
  return twice_area(p, q, {c.x, c.y});
}

/// Both parts of a piece, if the side parts it.
void RimCutter::cut(const RimPiece& piece, const BorderSide& side, const RimCell& cell) {
  const std::size_t n = piece.corners.size();
  RimPiece left, right;
  double least = 0, most = 0;
  std::vector<double> height(n);
  for (std::size_t k = 0; k < n; ++k) {
    height[k] = height_over(side, piece.corners[k], cell);
    least = std::min(least, height[k]), most = std::max(most, height[k]);
  }
  if (!(least < 0) || !(most > 0)) {
    next_.push_back(piece);
    return;
  }
  for (std::size_t k = 0; k < n; ++k) {
    const RimCorner &a = piece.corners[k], &b = piece.corners[(k + 1) % n];
    const double ha = height[k], hb = height[(k + 1) % n];
    if (ha >= 0) left.corners.push_back(ha == 0 ? on_border(a, side) : a);
    if (ha <= 0) right.corners.push_back(ha == 0 ? on_border(a, side) : a);
    if (!((ha < 0 && hb > 0) || (ha > 0 && hb < 0))) continue;
    // From left to right, whichever piece asks: neighbours get the same point.
    const RimCorner &l = ha > 0 ? a : b, &r = ha > 0 ? b : a;
    const double hl = std::max(ha, hb), hr = std::min(ha, hb), s = hl / (hl - hr);
    RimCorner c;
    static_cast<Corner&>(c) = {l.x + s * (r.x - l.x), l.y + s * (r.y - l.y), l.z1 + s * (r.z1 - l.z1),
                               l.z2 + s * (r.z2 - l.z2)};
    c.sides = l.sides & r.sides;
    for (std::size_t scan = 0; scan < 2; ++scan)
      if (l.border[scan] == r.border[scan]) c.border[scan] = l.border[scan];
    c = on_border(c, side);
    left.corners.push_back(c);
    right.corners.push_back(c);
  }
  next_.push_back(std::move(left));
  next_.push_back(std::move(right));
}

/// The corner with the height that the scan of the border has there.
RimCorner RimCutter::on_border(RimCorner c, const BorderSide& side) const {
  const Index a = std::min(side.from, side.to), b = std::max(side.from, side.to);
  const double share = std::clamp(share_along(xy_[a], xy_[b], c), 0.0, 1.0);
  const auto between = [&](std::span<const double> z) { return z[a] + share * (z[b] - z[a]); };
  constexpr unsigned of_a = (1u << extents) - 1;
  if ((side.of & of_a) != 0) c.z1 = between(z_[0]), c.border[0] = {a, b};
  if ((side.of & ~of_a) != 0) c.z2 = between(z_[1]), c.border[1] = {a, b};
  return c;
}

void RimCutter::settle_heights(const RimCell& cell) {
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t scan = 0; scan < 2; ++scan) settle_heights(cell, k, scan);
}

/// Side k of the cell: what was cut while a border was still to come had its height from a node beyond that.
void RimCutter::settle_heights(const RimCell& cell, std::size_t k, std::size_t scan) {
  const std::size_t ends[2] = {k, (k + 1) % 3};
  const Point2 &p = xy_[cell.nodes[ends[0]]], &q = xy_[cell.nodes[ends[1]]];
  const auto share = [&](const Corner& c) { return share_along(p, q, c); };
  const auto height = [&](Corner& c) -> double& { return scan == 0 ? c.z1 : c.z2; };
  std::vector<std::pair<double, double>> known;  // share, height
  for (std::size_t e = 0; e < 2; ++e)
    if ((cell.outside[ends[e]] & in_footprint << (extents * scan)) == 0)
      known.emplace_back(static_cast<double>(e), z_[scan][cell.nodes[ends[e]]]);
  const bool all_known = known.size() == 2;
  for (RimPiece& piece : pieces_)
    for (RimCorner& c : piece.corners)
      if ((c.sides >> k & 1) != 0 && c.border[scan][0] != no_index) known.emplace_back(share(c), height(c));
  if (all_known && known.size() == 2) return;
  std::sort(known.begin(), known.end());
  for (RimPiece& piece : pieces_)
    for (RimCorner& c : piece.corners) {
      const bool is_inside_the_side = c.sides == 1u << k;
      if (!is_inside_the_side || c.border[scan][0] != no_index) continue;
      const double s = share(c);
      const auto after = std::find_if(known.begin(), known.end(), [&](const auto& x) { return x.first >= s; });
      if (after == known.end() || after == known.begin()) continue;
      const auto& [s0, z0] = *(after - 1);
      const auto& [s1, z1] = *after;
      height(c) = z0 + (s - s0) / (s1 - s0) * (z1 - z0);
    }
}

bool RimCutter::is_in(const Point2& at, unsigned char extent, const RimCell& cell) const {
  const auto bounds = [&](const RimCrossing& c) { return (sides_[c.side].of & extent) != 0; };
  const auto is_left = [&](const RimCrossing& c, const Point2& point) {
    const BorderSide& s = sides_[c.side];
    return orientation(xy_[s.from], xy_[s.to], point) > 0;
  };
  constexpr unsigned hulls = in_hull | in_hull << extents;
  if ((extent & hulls) != 0)
    return std::all_of(cell.across.begin(), cell.across.end(),
                       [&](const RimCrossing& c) { return !bounds(c) || is_left(c, at); });
  Point2 from{0, 0};
  bool in = false;
  const RimCrossing* beside = nullptr;
  const auto corner = std::find_if(cell.outside.begin(), cell.outside.end(),
                                   [&](unsigned char outside) { return (outside & extent) != 0; });
  if (corner != cell.outside.end()) {
    from = xy_[cell.nodes[static_cast<std::size_t>(corner - cell.outside.begin())]];
  } else {
    beside = &*std::find_if(cell.across.begin(), cell.across.end(), bounds);
    from = middle_across(sides_[beside->side], cell);
    in = is_left(*beside, at);
  }
  for (const RimCrossing& c : cell.across)
    if (&c != beside && bounds(c) && is_left(c, at) != is_left(c, from)) in = !in;
  return in;
}

/// Halfway along what of a side lies in the cell.
Point2 RimCutter::middle_across(const BorderSide& side, const RimCell& cell) const {
  const Point2 &p = xy_[side.from], &q = xy_[side.to];
  double begin = 0, end = 1;
  for (std::size_t k = 0; k < 3; ++k) {
    const Point2 &a = xy_[cell.nodes[k]], &b = xy_[cell.nodes[(k + 1) % 3]];
    const double hp = twice_area(a, b, p), hq = twice_area(a, b, q);
    if (hp < 0 && hq > 0) begin = std::max(begin, hp / (hp - hq));
    if (hp > 0 && hq < 0) end = std::min(end, hp / (hp - hq));
  }
  const double middle = (begin + end) / 2;
  return {p.x + middle * (q.x - p.x), p.y + middle * (q.y - p.y)};
}

}  // namespace isopach
