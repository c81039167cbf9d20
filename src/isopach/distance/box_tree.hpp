// BoxTree: nearest of points that lie in the order of a curve, so that neighbours in the order are neighbours in space:
// boxes of eight points, of eight boxes, and so on.
#pragma once
#include <array>
#include <limits>
#include <span>
#include <vector>

#include "isopach/base/array.hpp"
#include "isopach/base/types.hpp"
#include "isopach/geom/vec.hpp"

namespace isopach {

class BoxTree {
 public:
  /// Copies `points`. Correct for any order of them, fast where it is that of a space-filling curve. Cost O(n).
  explicit BoxTree(std::span<const Point3> points);

  /// The two nearest points and their squared distances; no_index and infinity where there are fewer. Of equally near
  /// ones that of the smaller index is the nearer. Where no squared distance is finite (places beyond 1e154, or that
  /// are no number) the nearest is point 0, at infinity. Oracle: tests/distance/box_tree_test.cpp.
  struct Two {
    Index first = no_index, second = no_index;
    double first2 = std::numeric_limits<double>::infinity(), second2 = std::numeric_limits<double>::infinity();
  };
  [[nodiscard]] Two nearest_two(const Point3& p) const;
  /// The same; faster the nearer points `begin` and those about it in the order are to p.
  [[nodiscard]] Two nearest_two(const Point3& p, Index begin) const;

  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  static constexpr std::size_t width = 8;
  struct Leaf {
    double x[width], y[width], z[width];
  };
  struct Boxes {  ///< of eight children
    double low[3][width], high[3][width];
  };
  template <class Best>
  void descend(const Point3& p, std::size_t level, std::size_t node, std::size_t known, Best& best) const;
  template <class Best>
  void look_in(const Point3& p, std::size_t leaf, Best& best) const;
  template <class Best>
  void look(const Point3& p, Index begin, Best& best) const;

  std::size_t size_;
  Array<Leaf> leaves_;
  std::vector<Array<Boxes>> levels_;  ///< the first: boxes of leaves; the last: one node
};

}  // namespace isopach
