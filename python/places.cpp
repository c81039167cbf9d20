// What is asked of the cells of a result, as arrays: values at places, sections, integrals over pixels.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include "arrays.hpp"
#include "beside.hpp"
#include "bindings.hpp"
#include "isopach/compare/measured_cells.hpp"

namespace isopach::python {
namespace {

MeshView mesh_of(const InMesh& xy, const InValues& z1, const InValues& z2, const InTriangles& triangles) {
  const std::size_t nodes = xy.shape(0), cells = triangles.shape(0);
  if (xy.shape(1) != 2 || triangles.shape(1) != 3 || z1.shape(0) != nodes || z2.shape(0) != nodes)
    throw nb::value_error("cells: arrays that do not belong together");
  const std::int32_t* v = triangles.data();
  for (std::size_t i = 0; i < 3 * cells; ++i)
    if (v[i] < 0 || static_cast<std::size_t>(v[i]) >= nodes) throw nb::value_error("cells: a triangle without a node");
  return {{reinterpret_cast<const Point2*>(xy.data()), nodes},
          {z1.data(), nodes},
          {z2.data(), nodes},
          {reinterpret_cast<const std::array<std::int32_t, 3>*>(v), cells}};
}

nb::tuple pixels(const InMesh& xy, const InValues& z1, const InValues& z2, const InTriangles& triangles, double x,
                 double y, double step, std::size_t columns, std::size_t rows) {
  const MeshView mesh = mesh_of(xy, z1, z2, triangles);
  PixelSums sums;
  compute([&](const Context& context) { sums = sum_over_pixels(mesh, {x, y, step, columns, rows}, context); });
  return nb::make_tuple(given1(std::move(sums.area)), given1(std::move(sums.z1)), given1(std::move(sums.z2)),
                        given1(std::move(sums.d)));
}

nb::tuple values_at(const InMesh& xy, const InValues& z1, const InValues& z2, const InTriangles& triangles,
                    const InMesh& places) {
  const MeshView mesh = mesh_of(xy, z1, z2, triangles);
  HeightsAt found;
  compute([&](const Context& context) {
    found = heights_at(mesh, {reinterpret_cast<const Point2*>(places.data()), places.shape(0)}, context);
  });
  return nb::make_tuple(given1(std::move(found.z1)), given1(std::move(found.z2)));
}

nb::object given_vector(const std::vector<double>& values) {
  return given1(Array<double>(values.begin(), values.end()));
}

nb::tuple section(const InMesh& xy, const InValues& z1, const InValues& z2, const InTriangles& triangles,
                  const InMesh& chain) {
  const MeshView mesh = mesh_of(xy, z1, z2, triangles);
  Section found;
  compute([&](const Context& context) {
    found = section_along(mesh, {reinterpret_cast<const Point2*>(chain.data()), chain.shape(0)}, context);
  });
  return nb::make_tuple(given_vector(found.s), given_vector(found.x), given_vector(found.y), given_vector(found.z1),
                        given_vector(found.z2));
}

}  // namespace

void bind_places(nb::module_& module) {
  module.def("pixels", &pixels);
  module.def("values_at", &values_at);
  module.def("section", &section);
}

}  // namespace isopach::python
