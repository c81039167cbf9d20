// The bare triangulation: Delaunay, of points in any order, with exact decisions.
#include <iostream>
#include <vector>

#include "isopach/delaunay/triangulate.hpp"
#include "isopach/delaunay/validate.hpp"

int main() try {
  std::vector<isopach::Point2> points;
  for (int i = 0; i < 300; ++i)  // a grid: every four neighbours lie on one circle
    for (int j = 0; j < 300; ++j) points.push_back({0.1 * i, 0.1 * j});
  points.push_back(points.front());  // duplicates are allowed

  const isopach::SortedTriangulation s = isopach::triangulate_unsorted(points, {});
  const isopach::Triangulation& t = s.triangulation;
  double area = 0;
  for (isopach::Index k = 0; k < t.real; ++k) {  // behind the real triangles stand the ghosts of the hull
    const auto [a, b, c] = t.triangles[k].v;
    area +=
        0.5 * ((s.xy[b].x - s.xy[a].x) * (s.xy[c].y - s.xy[a].y) - (s.xy[b].y - s.xy[a].y) * (s.xy[c].x - s.xy[a].x));
  }
  std::cout << points.size() << " points, " << t.nodes << " nodes, " << t.real << " triangles, "
            << isopach::hull_nodes(t, s.xy).size() << " nodes on the hull, area " << area << "\n";
  const auto wrong = isopach::validate(t, s.xy);  // every triangle, every edge; nothing if all is well
  if (wrong) std::cout << *wrong << "\n";
  return !wrong && t.real == 2 * 299 * 299 && s.node_of.front() == s.node_of.back() ? 0 : 1;
} catch (const isopach::Error& error) {
  std::cerr << error.what() << "\n";
  return static_cast<int>(error.code());
}
