#include "isopach/compare/contour_lines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "isopach/base/error.hpp"

namespace isopach {
namespace {

constexpr double most_levels = 1e4;
constexpr double same = 0x1p-36;  // of the size of the coordinates: ends that differ by rounding alone

bool before(const Point2& p, const Point2& q) { return p.x != q.x ? p.x < q.x : p.y < q.y; }
bool equal(const Point2& p, const Point2& q) { return p.x == q.x && p.y == q.y; }

using Side = std::array<Point2, 2>;
bool side_before(const Side& a, const Side& b) { return equal(a[0], b[0]) ? before(a[1], b[1]) : before(a[0], b[0]); }

struct End {
  Point2 at;
  double d;
};

/// Where d is the level between two corners of which one is below it; the same from either.
Point2 crossing(const End& p, const End& q, double level) {
  if (p.d == level) return p.at;
  if (q.d == level) return q.at;
  const bool swapped = before(q.at, p.at);
  const End &a = swapped ? q : p, &b = swapped ? p : q;
  const double share = (level - a.d) / (b.d - a.d);
  return {a.at.x + share * (b.at.x - a.at.x), a.at.y + share * (b.at.y - a.at.y)};
}

/// The stretch of a level in a triangle: from where its border leaves what is higher to where it enters it again.
void add_stretch(const std::array<End, 3>& t, double level, std::vector<Side>& sides) {
  Side side{};
  bool found = false;
  for (std::size_t k = 0; k < 3; ++k) {
    const End &p = t[k], &q = t[(k + 1) % 3];
    if ((p.d >= level) == (q.d >= level)) continue;
    side[p.d >= level ? 0 : 1] = crossing(p, q, level);
    found = true;
  }
  if (found && !equal(side[0], side[1])) sides.push_back(side);
}

/// Corners at which one side ends and none begins, and the other way round.
struct LooseEnds {
  std::vector<Point2> ends, starts;
};
LooseEnds loose_ends(const std::vector<Side>& sides) {
  std::vector<Point2> from, to;
  for (const Side& s : sides) from.push_back(s[0]), to.push_back(s[1]);
  std::sort(from.begin(), from.end(), before), std::sort(to.begin(), to.end(), before);
  LooseEnds loose;
  std::set_difference(to.begin(), to.end(), from.begin(), from.end(), std::back_inserter(loose.ends), before);
  std::set_difference(from.begin(), from.end(), to.begin(), to.end(), std::back_inserter(loose.starts), before);
  return loose;
}

/// Where cells are cut by a border, the same corner was computed from either side of it: lets sides begin where another
/// ends.
void join_loose_ends(std::vector<Side>& sides) {
  double size = 0;
  for (const Side& s : sides) size = std::max({size, std::fabs(s[0].x), std::fabs(s[0].y)});
  const LooseEnds loose = loose_ends(sides);
  std::vector<Side> moved;  // from a start to where it goes
  for (const Point2& end : loose.ends) {
    auto p = std::lower_bound(loose.starts.begin(), loose.starts.end(), Point2{end.x - same * size, -HUGE_VAL}, before);
    for (; p != loose.starts.end() && p->x <= end.x + same * size; ++p)
      if (std::fabs(p->y - end.y) <= same * size) {
        moved.push_back({*p, end});
        break;
      }
  }
  std::sort(moved.begin(), moved.end(), side_before);
  for (Side& s : sides) {
    const auto to = std::lower_bound(moved.begin(), moved.end(), s[0],
                                     [](const Side& m, const Point2& p) { return before(m[0], p); });
    if (to != moved.end() && equal((*to)[0], s[0])) s[0] = (*to)[1];
  }
}

/// One line after the other: first those that begin somewhere, then the closed ones.
void chain(std::vector<Side> sides, double level, std::vector<ContourLine>& lines) {
  join_loose_ends(sides);
  std::sort(sides.begin(), sides.end(), side_before);
  std::vector<bool> used(sides.size(), false);
  const auto leaving = [&](const Point2& p) {
    auto s = std::lower_bound(sides.begin(), sides.end(), p,
                              [](const Side& side, const Point2& q) { return before(side[0], q); });
    for (; s != sides.end() && equal((*s)[0], p); ++s)
      if (!used[static_cast<std::size_t>(s - sides.begin())]) return static_cast<std::size_t>(s - sides.begin());
    return sides.size();
  };
  const auto follow = [&](std::size_t first) {
    ContourLine line{level, {sides[first][0]}};
    for (std::size_t i = first; i != sides.size(); i = leaving(sides[i][1])) {
      used[i] = true;
      line.xy.push_back(sides[i][1]);
      if (equal(sides[i][1], line.xy.front())) break;
    }
    lines.push_back(std::move(line));
  };
  for (const Point2& start : loose_ends(sides).starts)
    for (std::size_t first = leaving(start); first != sides.size(); first = leaving(start)) {
      follow(first);
      if (!equal(lines.back().xy.back(), start)) break;  // else a closed line touches the border there
    }
  for (std::size_t first = 0; first < sides.size(); ++first)
    if (!used[first]) follow(first);
}

std::array<End, 3> corners_of(const MeshView& mesh, std::size_t triangle) {
  std::array<End, 3> t{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto v = static_cast<std::size_t>(mesh.triangles[triangle][k]);
    t[k] = {mesh.xy[v], mesh.z2[v] - mesh.z1[v]};
  }
  return t;
}

}  // namespace

std::vector<ContourLine> contour_lines(const MeshView& mesh, double step, const std::string& option,
                                       const Context& context) {
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (const End& end : corners_of(mesh, i)) low = std::min(low, end.d), high = std::max(high, end.d);
  std::vector<ContourLine> lines;
  if (!(low < high)) return lines;
  const double first = std::ceil(low / step), last = std::floor(high / step);
  if (!(last - first < most_levels))
    throw UsageError(
        fmt::format("{}: {:.4g} levels are too many: choose a larger step than {}", option, last - first + 1, step));
  std::vector<std::vector<Side>> of_level(static_cast<std::size_t>(std::max(0.0, last - first + 1)));
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (i % 4096 == 0) context.check();
    const std::array<End, 3> t = corners_of(mesh, i);
    const double least = std::min({t[0].d, t[1].d, t[2].d}), most = std::max({t[0].d, t[1].d, t[2].d});
    for (double k = std::max(first, std::floor(least / step)); k <= last && k * step <= most; ++k)
      add_stretch(t, k * step, of_level[static_cast<std::size_t>(k - first)]);
  }
  for (std::size_t k = 0; k < of_level.size(); ++k)
    chain(std::move(of_level[k]), (first + static_cast<double>(k)) * step, lines);
  return lines;
}

}  // namespace isopach
