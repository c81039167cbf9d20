// Two node sets and their union, ready to be triangulated in one of several ways; and sets made of sets.
#pragma once
#include "isopach/overlay/common.hpp"
#include "tests/support/mesh.hpp"
#include "tests/support/points.hpp"

namespace isopach::test {

struct Case {
  CurveBox box;
  Points g1, g2;
  UnitedNodes g;
};

inline Case make_case(const Points& a, const Points& b) {
  Case c;
  c.g1 = distinct(a);
  c.g2 = distinct(b);
  Box2 extent;
  for (const Point2& p : c.g1) extent.add(p);
  for (const Point2& p : c.g2) extent.add(p);
  c.box = curve_box(extent);
  c.g1 = in_order(c.g1, c.box);
  c.g2 = in_order(c.g2, c.box);
  c.g = unite(c.g1, c.g2, c.box);
  return c;
}

inline Points moved(Points points, double dx, double dy) {
  for (Point2& p : points) p = {p.x + dx, p.y + dy};
  return points;
}

inline Points scaled(Points points, double factor) {
  for (Point2& p : points) p = {p.x * factor, p.y * factor};
  return points;
}

inline Points some_of(const Points& points, std::size_t keep) {
  Points kept;
  for (std::size_t i = 0; i < points.size(); i += keep) kept.push_back(points[i]);
  return kept;
}

inline Points joined(Points a, const Points& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

}  // namespace isopach::test
