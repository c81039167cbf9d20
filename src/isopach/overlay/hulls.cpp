#include "isopach/overlay/hulls.hpp"

#include <algorithm>
#include <vector>

#include "isopach/base/sum.hpp"

namespace isopach {

namespace {

// The lower and upper boundary of a convex polygon as functions of x.
struct Chains {
  std::vector<Point2> lower, upper;  // both by ascending x

  explicit Chains(std::span<const Point2> polygon) {
    const auto [first, last] = std::minmax_element(polygon.begin(), polygon.end(), lexicographic_less);
    const auto n = polygon.size();
    const auto i0 = static_cast<std::size_t>(first - polygon.begin()),
               i1 = static_cast<std::size_t>(last - polygon.begin());
    for (std::size_t i = i0;; i = (i + 1) % n) {
      lower.push_back(polygon[i]);
      if (i == i1) break;
    }
    for (std::size_t i = i0;; i = (i + n - 1) % n) {
      upper.push_back(polygon[i]);
      if (i == i1) break;
    }
  }
};

// Value of a chain at x, moving `at` forward; x never falls between calls.
double value(const std::vector<Point2>& chain, std::size_t& at, double x) {
  while (at + 2 < chain.size() && chain[at + 1].x <= x) ++at;
  const Point2 &a = chain[at], &b = chain[at + 1];
  return b.x > a.x ? a.y + (b.y - a.y) * std::clamp((x - a.x) / (b.x - a.x), 0.0, 1.0) : b.y;
}

struct Line {  // over one slab of width 1
  double left, right;
  [[nodiscard]] double at(double s) const { return left + (right - left) * s; }
};

// ∫ over a slab of max(0, min(u1, u2) − max(l1, l2)), all linear on it.
double slab_area(const Line& l1, const Line& l2, const Line& u1, const Line& u2, double width) {
  std::array<double, 6> cuts{0, 1};  // ascending
  std::size_t count = 2;
  const auto cut = [&](const Line& a, const Line& b) {
    const double d0 = a.left - b.left, d1 = a.right - b.right;
    if ((d0 < 0) == (d1 < 0) || d0 == d1) return;
    const double s = std::clamp(d0 / (d0 - d1), 0.0, 1.0);
    std::size_t i = count++;
    for (; i > 0 && cuts[i - 1] > s; --i) cuts[i] = cuts[i - 1];
    cuts[i] = s;
  };
  cut(l1, l2), cut(u1, u2), cut(u1, l2), cut(u2, l1);
  const auto gap = [&](double s) { return std::max(0.0, std::min(u1.at(s), u2.at(s)) - std::max(l1.at(s), l2.at(s))); };
  double area = 0;
  for (std::size_t i = 0; i + 1 < count; ++i) area += (cuts[i + 1] - cuts[i]) * (gap(cuts[i]) + gap(cuts[i + 1])) / 2;
  return area * width;
}

}  // namespace

double polygon_area(std::span<const Point2> polygon) {
  Sum sum;
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i) {
    const Point2 &o = polygon[0], &a = polygon[i], &b = polygon[i + 1];
    sum.add(0.5 * ((a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x)));
  }
  return sum.value();
}

double shared_area(std::span<const Point2> p, std::span<const Point2> q) {
  if (p.size() < 3 || q.size() < 3) return 0;
  const Chains a(p), b(q);
  const double low = std::max(a.lower.front().x, b.lower.front().x),
               high = std::min(a.lower.back().x, b.lower.back().x);
  if (!(low < high)) return 0;
  std::vector<double> stops{low, high};
  for (const auto* chain : {&a.lower, &a.upper, &b.lower, &b.upper})
    for (const Point2& v : *chain)
      if (v.x > low && v.x < high) stops.push_back(v.x);
  std::sort(stops.begin(), stops.end());
  stops.erase(std::unique(stops.begin(), stops.end()), stops.end());
  std::array<std::size_t, 4> at{};
  Sum sum;
  for (std::size_t i = 0; i + 1 < stops.size(); ++i) {
    const double x0 = stops[i], x1 = stops[i + 1];
    // Within a slab a chain is one line: its value at the right end is read off the piece that the left end is on.
    std::array<Line, 4> lines;
    const std::array<const std::vector<Point2>*, 4> chains{&a.lower, &b.lower, &a.upper, &b.upper};
    for (std::size_t k = 0; k < 4; ++k) {
      lines[k].left = value(*chains[k], at[k], x0);
      const Point2 &v = (*chains[k])[at[k]], &w = (*chains[k])[at[k] + 1];
      lines[k].right = w.x > v.x ? v.y + (w.y - v.y) * std::clamp((x1 - v.x) / (w.x - v.x), 0.0, 1.0) : w.y;
    }
    sum.add(slab_area(lines[0], lines[1], lines[2], lines[3], x1 - x0));
  }
  return sum.value();
}

}  // namespace isopach
