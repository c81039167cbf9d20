#include "tests/support/mesh.hpp"

#include <algorithm>
#include <cstring>
#include <map>
#include <utility>

namespace isopach::test {
namespace {

Corners rotated(Corners c) {
  std::size_t least = 0;
  for (std::size_t k = 1; k < 3; ++k)
    if (lexicographic_less(c[k], c[least])) least = k;
  std::rotate(c.begin(), c.begin() + static_cast<std::ptrdiff_t>(least), c.end());
  return c;
}

struct Less {
  template <std::size_t N>
  bool operator()(const std::array<Point2, N>& a, const std::array<Point2, N>& b) const {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end(), lexicographic_less);
  }
};

}  // namespace

std::vector<Corners> triangle_set(const Triangulation& t, std::span<const Point2> xy) {
  std::vector<Corners> set;
  for (Index i = 0; i < t.real; ++i) {
    const auto& v = t.triangles[i].v;
    set.push_back(rotated({xy[v[0]], xy[v[1]], xy[v[2]]}));
  }
  std::sort(set.begin(), set.end(), Less());
  return set;
}

std::vector<Corners> triangle_set(const std::vector<Triple>& triangles, std::span<const Point2> xy) {
  std::vector<Corners> set;
  for (const Triple& t : triangles) set.push_back(rotated({xy[t[0]], xy[t[1]], xy[t[2]]}));
  std::sort(set.begin(), set.end(), Less());
  return set;
}

std::vector<std::array<Point2, 2>> edge_set(const std::vector<Corners>& triangles) {
  std::vector<std::array<Point2, 2>> edges;
  for (const Corners& c : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const Point2 &p = c[k], &q = c[(k + 1) % 3];
      edges.push_back(lexicographic_less(p, q) ? std::array{p, q} : std::array{q, p});
    }
  std::sort(edges.begin(), edges.end(), Less());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

Triangulation from_triples(const std::vector<Triple>& triangles, std::size_t n) {
  Triangulation t;
  t.nodes = static_cast<Index>(n);
  t.real = static_cast<Index>(triangles.size());
  std::map<std::pair<Index, Index>, HalfEdge> sides;
  for (const Triple& triple : triangles) {
    const auto id = static_cast<Index>(t.triangles.size());
    Triangle made;
    for (std::size_t k = 0; k < 3; ++k) {
      made.v[k] = static_cast<Index>(triple[k]);
      sides[{static_cast<Index>(triple[k]), static_cast<Index>(triple[(k + 1) % 3])}] =
          half_edge(id, static_cast<Index>(k));
    }
    t.triangles.push_back(made);
  }
  std::map<Index, Index> ghost_from;  // by the node its hull edge starts at
  for (const auto& [ends, h] : std::map(sides)) {
    if (sides.count({ends.second, ends.first}) != 0) continue;
    const auto id = static_cast<Index>(t.triangles.size());
    ghost_from[ends.first] = id;
    sides[{ends.second, ends.first}] = half_edge(id, 0);
    t.triangles.push_back({{ends.second, ends.first, no_index}, {h, no_index, no_index}});
  }
  for (Index i = 0; i < t.real; ++i)
    for (Index k = 0; k < 3; ++k)
      t.triangles[i].n[k] = sides.at({t.target(half_edge(i, k)), t.origin(half_edge(i, k))});
  for (Index g = t.real; g < t.triangles.size(); ++g) {
    const Index following = ghost_from.at(t.triangles[g].v[0]);
    t.triangles[g].n[2] = half_edge(following, 1);
    t.triangles[following].n[1] = half_edge(g, 2);
  }
  return t;
}

Points in_order(const Points& points, const CurveBox& box) {
  Points sorted;
  for (const Index i : curve_order(points, box)) sorted.push_back(points[i]);
  return sorted;
}

bool same_bytes(const Triangulation& a, const Triangulation& b) {
  return a.real == b.real && a.nodes == b.nodes && a.triangles.size() == b.triangles.size() &&
         (a.triangles.empty() ||
          std::memcmp(a.triangles.data(), b.triangles.data(), a.triangles.size() * sizeof(Triangle)) == 0);
}

}  // namespace isopach::test
