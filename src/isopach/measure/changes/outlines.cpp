#include "isopach/measure/changes/outlines.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "isopach/geom/predicates.hpp"

namespace isopach {
namespace {

constexpr double same = 0x1p-36;  // of the size of the coordinates: corners that differ by rounding alone

bool before(const Point2& p, const Point2& q) { return p.x != q.x ? p.x < q.x : p.y < q.y; }
bool equal(const Point2& p, const Point2& q) { return p.x == q.x && p.y == q.y; }
bool side_before(const OutlineSide& a, const OutlineSide& b) {
  return equal(a[0], b[0]) ? before(a[1], b[1]) : before(a[0], b[0]);
}

/// Corners that are the same up to rounding, by one of them.
class Corners {
 public:
  Corners(const std::vector<OutlineSide>& firm, const std::vector<OutlineSide>& loose) {
    for (const auto* sides : {&firm, &loose})
      for (const OutlineSide& s : *sides)
        for (const Point2& p : s) size_ = std::max({size_, std::fabs(p.x), std::fabs(p.y)});
    // Firm ones stand for themselves, and for the loose ones near them.
    for (const OutlineSide& s : firm)
      for (const Point2& p : s) at_.insert({p.x, p.y});
    std::vector<Point2> others;
    for (const OutlineSide& s : loose) others.insert(others.end(), s.begin(), s.end());
    std::sort(others.begin(), others.end(), before);
    for (const Point2& p : others)
      if (equal(of(p), p)) at_.insert({p.x, p.y});
  }

  [[nodiscard]] double reach() const { return same * size_; }
  /// The one that stands for a corner; itself where none does.
  [[nodiscard]] Point2 of(const Point2& p) const {
    if (has(p)) return p;
    Point2 found = p;
    for_near(p.x, p.x, [&](const Point2& q) {
      if (equal(found, p) && std::fabs(q.y - p.y) <= reach()) found = q;
    });
    return found;
  }
  /// f(corner) for those with x from `low` to `high`.
  template <class F>
  void for_near(double low, double high, F&& f) const {
    for (auto q = at_.lower_bound({low - reach(), -HUGE_VAL}); q != at_.end() && q->first <= high + reach(); ++q)
      f(Point2{q->first, q->second});
  }

 private:
  [[nodiscard]] bool has(const Point2& p) const { return at_.count({p.x, p.y}) > 0; }
  double size_ = 0;
  std::set<std::pair<double, double>> at_;
};

/// A side cut at the corners that lie on it.
void cut_at_corners(const OutlineSide& side, const Corners& corners, std::vector<OutlineSide>& parts) {
  const Point2 p = corners.of(side[0]), q = corners.of(side[1]);
  if (equal(p, q)) return;
  const double dx = q.x - p.x, dy = q.y - p.y, length = std::hypot(dx, dy);
  std::vector<std::pair<double, Point2>> on;
  corners.for_near(std::min(p.x, q.x), std::max(p.x, q.x), [&](const Point2& c) {
    if (equal(c, p) || equal(c, q)) return;
    const double along = ((c.x - p.x) * dx + (c.y - p.y) * dy) / length;
    const double beside = ((c.x - p.x) * dy - (c.y - p.y) * dx) / length;
    if (along > 0 && along < length && std::fabs(beside) <= corners.reach()) on.emplace_back(along, c);
  });
  std::sort(on.begin(), on.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  Point2 from = p;
  for (const auto& [along, c] : on) parts.push_back({from, c}), from = c;
  parts.push_back({from, q});
}

/// What is left of sides where those that run against one another cancel.
std::vector<OutlineSide> cancelled(std::vector<OutlineSide> sides) {
  std::sort(sides.begin(), sides.end(), side_before);
  std::map<std::array<double, 4>, int> count;  // by the side in one sense: how many run this way less the other way
  for (const OutlineSide& s : sides) {
    const bool forward = before(s[0], s[1]);
    const Point2 &a = s[forward ? 0 : 1], &b = s[forward ? 1 : 0];
    count[{a.x, a.y, b.x, b.y}] += forward ? 1 : -1;
  }
  std::vector<OutlineSide> left;
  for (const auto& [ends, n] : count) {
    const Point2 a{ends[0], ends[1]}, b{ends[2], ends[3]};
    for (int k = 0; k < std::abs(n); ++k) left.push_back(n > 0 ? OutlineSide{a, b} : OutlineSide{b, a});
  }
  return left;
}

/// Whether b lies before c, turning counter-clockwise round `at` from the direction to `from`, which itself comes last.
bool turns_before(const Point2& at, const Point2& from, const Point2& b, const Point2& c) {
  const auto half = [&](const Point2& p) {
    const int turn = orientation(at, from, p);
    if (turn != 0) return turn > 0 ? 0 : 2;
    const bool back = (p.x - at.x) * (from.x - at.x) + (p.y - at.y) * (from.y - at.y) > 0;
    return back ? 3 : 1;
  };
  const int hb = half(b), hc = half(c);
  return hb != hc ? hb < hc : orientation(at, b, c) > 0;
}

/// Rings of sides that together are closed. At a corner that several rings touch each goes on along the part of the
/// outside it came along: rings touch there, and no ring touches itself.
std::vector<std::vector<Point2>> chained(std::vector<OutlineSide> sides) {
  std::sort(sides.begin(), sides.end(), side_before);
  std::vector<bool> used(sides.size(), false);
  const auto leaving = [&](const Point2& p) {
    return static_cast<std::size_t>(
        std::lower_bound(sides.begin(), sides.end(), p,
                         [](const OutlineSide& s, const Point2& q) { return before(s[0], q); }) -
        sides.begin());
  };
  std::vector<std::vector<Point2>> rings;
  for (std::size_t first = 0; first < sides.size(); ++first) {
    if (used[first]) continue;
    std::vector<Point2> ring;
    for (std::size_t i = first;;) {
      used[i] = true;
      ring.push_back(sides[i][0]);
      const Point2 at = sides[i][1], from = sides[i][0];
      std::size_t best = sides.size();
      for (std::size_t k = leaving(at); k < sides.size() && equal(sides[k][0], at); ++k)
        if ((!used[k] || k == first) && (best == sides.size() || turns_before(at, from, sides[k][1], sides[best][1])))
          best = k;
      if (best == first || best == sides.size()) break;
      i = best;
    }
    if (ring.size() >= 3) rings.push_back(std::move(ring));
  }
  return rings;
}

bool holds(const std::vector<Point2>& ring, const Point2& p) {
  bool in = false;
  for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
    const Point2 &a = ring[i], &b = ring[j];
    if ((a.y > p.y) != (b.y > p.y) && p.x < (b.x - a.x) * (p.y - a.y) / (b.y - a.y) + a.x) in = !in;
  }
  return in;
}

}  // namespace

double ring_area(const std::vector<Point2>& ring) {
  double twice = 0;
  for (std::size_t k = 2; k < ring.size(); ++k)
    twice +=
        (ring[k - 1].x - ring[0].x) * (ring[k].y - ring[0].y) - (ring[k - 1].y - ring[0].y) * (ring[k].x - ring[0].x);
  return twice / 2;
}

std::vector<PolygonWithHoles> OutlineBuilder::polygons() const {
  std::vector<OutlineSide> sides = firm_;
  if (!loose_.empty() || !loose_firm_.empty()) {
    const Corners corners(loose_firm_, loose_);
    std::vector<OutlineSide> parts;
    for (const auto* all : {&loose_firm_, &loose_})
      for (const OutlineSide& s : *all) cut_at_corners(s, corners, parts);
    for (const OutlineSide& s : cancelled(std::move(parts))) sides.push_back(s);
  }
  sides.erase(std::remove_if(sides.begin(), sides.end(), [](const OutlineSide& s) { return equal(s[0], s[1]); }),
              sides.end());
  struct Ring {
    double area;
    std::vector<Point2> at;
  };
  std::vector<Ring> outer, holes;
  for (std::vector<Point2>& ring : chained(std::move(sides))) {
    const double area = ring_area(ring);
    if (area != 0) (area > 0 ? outer : holes).push_back({area, std::move(ring)});
  }
  std::stable_sort(outer.begin(), outer.end(), [](const Ring& a, const Ring& b) { return a.area > b.area; });
  std::vector<PolygonWithHoles> polygons;
  for (Ring& r : outer) polygons.push_back({{std::move(r.at)}});
  for (Ring& h : holes) {
    const Point2 middle{(h.at[0].x + h.at[1].x) / 2, (h.at[0].y + h.at[1].y) / 2};
    std::size_t in = 0;  // the smallest that holds it
    for (std::size_t k = polygons.size(); k-- > 1;)
      if (holds(polygons[k].rings[0], middle)) {
        in = k;
        break;
      }
    if (!polygons.empty()) polygons[in].rings.push_back(std::move(h.at));
  }
  return polygons;
}

}  // namespace isopach
