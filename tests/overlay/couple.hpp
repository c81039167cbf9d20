// Two surfaces, each located in the other: what an overlay is made of.
#pragma once
#include <utility>
#include <vector>

#include "isopach/delaunay/triangulate.hpp"
#include "isopach/overlay/hulls.hpp"
#include "isopach/overlay/interpolate.hpp"
#include "isopach/overlay/localise.hpp"
#include "isopach/overlay/overlay.hpp"
#include "tests/support/clouds.hpp"
#include "tests/support/mesh.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {

struct Surface {
  SortedTriangulation mesh;
  std::vector<double> z;
};

inline Surface surface(const Points& points, const Height& height) {
  Surface s{triangulate_unsorted(points, {}), {}};
  for (const Point2& p : s.mesh.xy) s.z.push_back(height(p));
  return s;
}
inline Surface rough(const Points& points, std::uint64_t seed) {
  Random random(seed);
  return surface(points, [&](const Point2&) { return random.uniform(-1, 1); });
}

/// Two surfaces, each located in the other.
struct Couple {
  Surface a, b;
  Locations a_in_b, b_in_a;
  Array<double> b_at_a, a_at_b;
  std::vector<unsigned char> kept_a, kept_b;

  Couple(Surface first, Surface second) : a(std::move(first)), b(std::move(second)) {
    a_in_b = localise_in_order(a.mesh.xy, b.mesh.triangulation, b.mesh.xy, {});
    b_in_a = localise_in_order(b.mesh.xy, a.mesh.triangulation, a.mesh.xy, {});
    b_at_a = interpolate(a_in_b, a.mesh.xy, b.mesh.triangulation, b.mesh.xy, b.z, {});
    a_at_b = interpolate(b_in_a, b.mesh.xy, a.mesh.triangulation, a.mesh.xy, a.z, {});
  }
  [[nodiscard]] OverlayMesh first() const { return {a.mesh.triangulation, a.mesh.xy, a.z, a_in_b, b_at_a, kept_a}; }
  [[nodiscard]] OverlayMesh second() const { return {b.mesh.triangulation, b.mesh.xy, b.z, b_in_a, a_at_b, kept_b}; }
  [[nodiscard]] Overlay overlay() const { return {first(), second(), {}}; }
  [[nodiscard]] double shared_hull() const {
    const auto hull = [](const Surface& s) {
      Points polygon;
      for (const Index node : hull_nodes(s.mesh.triangulation, s.mesh.xy)) polygon.push_back(s.mesh.xy[node]);
      return polygon;
    };
    return shared_area(hull(a), hull(b));
  }
};

}  // namespace isopach::test
