// Viewing: how a scan is seen: along a direction, or all round a place. What lies beside, before and behind what in it.
#pragma once
#include <memory>
#include <span>

#include "isopach/base/array.hpp"
#include "isopach/distance/point_tree.hpp"
#include "isopach/geom/vec.hpp"

namespace isopach {

/// A projection of space in which a scan has as few layers as can be. direction: along `axis` (length 1), towards the
/// eye. inside: the eye stands at `centre`, as that of a turning scanner. around: eyes all round, looking at `centre`:
/// an object that was seen from all sides.
struct Viewing {
  enum class Kind { direction, inside, around } kind = Kind::direction;
  Point3 axis{0, 0, 1};
  Point3 centre{0, 0, 0};

  /// Towards the eye, length 1.
  [[nodiscard]] Point3 line_of_sight(const Point3& p) const;
  /// The greater, the nearer to the eye.
  [[nodiscard]] double nearness(const Point3& p) const;
  /// Where p is seen: in the plane across `axis` (third coordinate 0), or on the unit sphere.
  [[nodiscard]] Point3 place(const Point3& p) const;
};

/// The viewing in which the fewest of `queries` have neighbours, among those seen beside them, that lie apart in space.
/// Directions: the principal ones of the normals, each followed to the mean of the normals on its side; places: that of
/// the coordinates' origin (`origin`), where it lies among the points, and the middle of the points. A direction is
/// preferred to a place, and a place to `origin`, unless the other has clearly fewer layers. `reach`: of each query,
/// the distance within which 16 points lie. Cost O(n log n), on at most 4000 points. Test: Viewing.* in
/// tests/match/verdict_test.cpp.
[[nodiscard]] Viewing choose_viewing(std::span<const Point3> points, std::span<const Point3> normals,
                                     std::span<const Index> queries, std::span<const double> reach,
                                     const Point3& origin);

}  // namespace isopach
