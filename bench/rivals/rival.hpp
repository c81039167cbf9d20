// What isopach is measured against, behind one interface: rivals/cgal.cpp, or rivals/none.cpp where CGAL is not
// installed. Compiled apart from the library: its sources see none of isopach's flags.
#pragma once
#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "isopach/geom/vec.hpp"

namespace isopach::bench::rival {

struct Input;  ///< points in the rival's own type, made before the clock starts
struct Mesh;

[[nodiscard]] bool available();
[[nodiscard]] std::string name();  ///< with its version

[[nodiscard]] std::shared_ptr<Input> input(std::span<const Point2> points);
[[nodiscard]] std::shared_ptr<Input> hilbert_sorted(std::span<const Point2> points);

[[nodiscard]] std::shared_ptr<Mesh> triangulate(const Input& points);  ///< all at once
[[nodiscard]] std::shared_ptr<Mesh> copy(const Mesh& mesh);
[[nodiscard]] std::size_t edges(const Mesh& mesh);

/// Every point located from where the one before it was found. Number of points inside the hull.
[[nodiscard]] std::size_t locate(const Mesh& mesh, const Input& points);

/// Every point inserted from where the one before it went.
void insert(Mesh& mesh, const Input& points);

/// The comparison as one would write it: two triangulations, every node located in the other one in the order of the
/// mesh, the union triangulated from scratch, |d| summed over its cells.
struct Volume {
  double area = 0, above = 0, below = 0;
};
[[nodiscard]] Volume compare(std::span<const Point3> a, std::span<const Point3> b);

}  // namespace isopach::bench::rival
