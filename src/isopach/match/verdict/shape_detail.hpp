// Planes of neighbours, and how well two fields of normals agree in their detail.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "isopach/base/array.hpp"
#include "isopach/base/types.hpp"
#include "isopach/geom/vec.hpp"

namespace isopach {

struct LocalPlane {
  Point3 normal{0, 0, 1};  ///< length 1, of either sign
  Point3 centre{0, 0, 0};
};

/// Least squares of the distances (total). Of fewer than three points, or points on a line: some plane through them.
[[nodiscard]] LocalPlane plane_of(std::span<const Point3> points, std::span<const Index> chosen);

[[nodiscard]] Point3 mean_of(std::span<const Point3> vectors, std::span<const Index> chosen);

/// Pairs of normals at places: the correlation that is left between them once a linear function of the place, which is
/// what the normals of a quadric surface are, is fitted to each of the two and taken off.
class ShapeDetail {
 public:
  void add(const Point3& place, const Point3& first, const Point3& second) {
    samples_.push_back({place, first, second});
  }
  /// sum(a·b) / sqrt(sum a² sum b²) of the remainders, -1 to 1; 0 of fewer than 8 pairs, and where one has none but
  /// rounding. Cost O(n).
  [[nodiscard]] double correlation() const;

 private:
  struct Sample {
    Point3 place, first, second;
  };
  std::vector<Sample> samples_;
};

}  // namespace isopach
