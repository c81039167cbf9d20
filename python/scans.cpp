// Scans: of a file, of arrays of Python's.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "arrays.hpp"
#include "beside.hpp"
#include "bindings.hpp"
#include "cli/session.hpp"
#include "isopach/io/read.hpp"
#include "isopach/io/write.hpp"

namespace isopach::python {
namespace {

/// Strides count doubles. The arrays come as objects, too: these are shown again.
Scan scan_of_arrays(nb::object points_object, const InDoubles& points,
                    const std::vector<std::pair<std::string, nb::object>>& attributes, nb::object faces,
                    const std::string& unit, const std::string& vertical_unit, const std::string& crs,
                    const nb::bytes& name) {
  Scan scan;
  const std::size_t n = points.shape(0);
  const std::int64_t down = points.stride(0), across = points.stride(1);
  const double* x = points.data();
  scan.view = CloudView(n == 0 ? PointsView() : PointsView(x, x + across, x + 2 * across, n, down));
  for (const auto& [attribute, object] : attributes) {
    const auto values = nb::cast<InDoubles>(object);
    scan.view.attributes.push_back({attribute, ValuesView(values.data(), n, n == 0 ? 1 : values.stride(0))});
    scan.attributes.emplace_back(attribute, object);
  }
  if (!faces.is_none()) {
    static_assert(sizeof(Index) == sizeof(std::int32_t), "faces are views of int32");
    const auto corners = nb::cast<InTriangles>(faces);
    const auto* first = reinterpret_cast<const std::array<Index, 3>*>(corners.data());
    scan.view.faces = FacesView(first, corners.shape(0));
    scan.faces = std::move(faces);
  }
  scan.view.unit = unit, scan.view.vertical_unit = vertical_unit, scan.view.crs = crs, scan.view.path = to_string(name);
  scan.points = std::move(points_object);
  return scan;
}

nb::object points_of(nb::handle self) {
  const Scan& scan = nb::cast<const Scan&>(self);
  if (scan.points) return scan.points;
  const PointsView& p = scan.view.points;
  return view2(p.empty() ? nullptr : p.address(0), p.size(), 3, self);
}

nb::object attribute_of(nb::handle self, const std::string& name) {
  const Scan& scan = nb::cast<const Scan&>(self);
  if (scan.cloud != nullptr) {
    if (const Attribute* a = scan.cloud->find_attribute(name)) return view1(a->values.data(), a->values.size(), self);
  }
  for (const auto& [known, values] : scan.attributes)
    if (known == name) return values;
  throw nb::key_error(name.c_str());
}

nb::object faces_of(nb::handle self) {
  const Scan& scan = nb::cast<const Scan&>(self);
  if (scan.view.faces.empty()) return nb::none();
  if (scan.faces) return scan.faces;
  return view2(reinterpret_cast<const std::int32_t*>(scan.view.faces.data()), scan.view.faces.size(), 3, self);
}

Scan read_scan(const nb::bytes& path, int threads, nb::object progress) {
  cli::Session session;
  Beside beside(std::move(progress), nb::none());
  auto cloud = std::make_shared<Cloud>();
  const std::string name = to_string(path);
  run_in(session, beside, [&] {
    Context context;
    context.threads = threads;
    context.cancelled = session.cancelled;
    context.progress = session.progress;
    ReadOptions all;
    all.all_attributes = all.faces = true;
    *cloud = cli::cloud_named(name, all, context);
  });
  return scan_of_cloud(cloud);
}

void write_scan(const Scan& scan, const nb::bytes& path) {
  const std::string name = to_string(path);
  compute([&](const Context& context) { write_cloud(name, copy_of(scan.view), context); });
}

}  // namespace

Scan scan_of_cloud(std::shared_ptr<const Cloud> cloud) {
  Scan scan;
  scan.view = CloudView(cloud);
  scan.cloud = std::move(cloud);
  return scan;
}

void bind_scans(nb::module_& module) {
  nb::class_<Scan>(module, "Scan")
      .def_prop_ro("points", [](nb::handle self) { return points_of(self); })
      .def("attribute", [](nb::handle self, const std::string& name) { return attribute_of(self, name); })
      .def_prop_ro("attributes",
                   [](const Scan& s) {
                     std::vector<std::string> names;
                     for (const isopach::AttributeView& a : s.view.attributes) names.push_back(a.name);
                     return names;
                   })
      .def_prop_ro("faces", [](nb::handle self) { return faces_of(self); })
      .def_prop_ro("unit", [](const Scan& s) { return s.view.unit; })
      .def_prop_ro("vertical_unit", [](const Scan& s) { return s.view.vertical_unit; })
      .def_prop_ro("crs", [](const Scan& s) { return to_str(s.view.crs); })
      .def_prop_ro("path", [](const Scan& s) { return to_str(s.view.path); })
      .def_prop_ro("format", [](const Scan& s) { return s.view.format; })
      .def_prop_ro("notes",
                   [](const Scan& s) {
                     nb::list all;
                     for (const std::string& note : s.view.notes) all.append(to_str(isopach::for_shell(note)));
                     return all;
                   })
      .def("write", &write_scan);
  module.def("scan", &scan_of_arrays, nb::arg("points_object"), nb::arg("points").noconvert(), nb::arg("attributes"),
             nb::arg("faces").none(), nb::arg("unit"), nb::arg("vertical_unit"), nb::arg("crs"), nb::arg("name"));
  module.def("read", &read_scan, nb::arg("path"), nb::arg("threads"), nb::arg("progress").none());
}

}  // namespace isopach::python
