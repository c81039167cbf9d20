// Answers of verbs: their JSON, arrays and cells, and what writes them to files.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "arrays.hpp"
#include "beside.hpp"
#include "bindings.hpp"
#include "cli/command.hpp"
#include "isopach/compare/measured_cells.hpp"
#include "isopach/report/draw/map.hpp"
#include "isopach/report/match.hpp"
#include "isopach/report/report.hpp"

namespace isopach::python {
namespace {

using cli::Answer;
using cli::Session;

nb::object required(const Found& found) {
  try {
    found.answer->require();
  } catch (const Error& error) {
    return nb::make_tuple(static_cast<int>(error.code()), to_str(for_shell(error.what())));
  }
  return nb::none();
}

void save(Found& found, const nb::bytes& folder, const std::vector<nb::bytes>& words, nb::object progress) {
  cli::Arguments arguments;
  for (const nb::bytes& word : words) arguments.push_back(to_string(word));
  const std::string path = to_string(folder);
  Session session;
  Beside beside(std::move(progress), nb::none());
  run_in(session, beside, [&] {
    const std::lock_guard lock(found.writing);
    cli::Delivery delivery;
    cli::Command command(found.verb, "", "");
    found.answer->add_output_options(command, delivery);
    if (!command.parse(arguments)) return;
    session.words = found.words;  // inputs are no files of an earlier result
    cli::RunOptions options;
    cli::Run run(options);
    cli::OutputFolder out(path);
    found.answer->deliver(delivery, &out, run);
  });
}

nb::list output_options(const Found& found) {
  std::vector<cli::OptionRow> rows;
  Session session;
  session.table = &rows;
  {
    const cli::SessionScope scope(session);
    cli::Delivery delivery;
    cli::Command command(found.verb, "", "");
    found.answer->add_output_options(command, delivery);
    (void)command.parse({});
  }
  nb::list names;
  for (const cli::OptionRow& row : rows)
    if (!row.names.empty()) names.append(row.names.front());
  return names;
}

/// The map as a PNG file; false where a verb has none.
bool draw(Found& found, const nb::bytes& path, int width) {
  const std::string name = to_string(path);
  MapOptions look;
  look.width = width;
  bool drawn = false;
  compute([&](const Context& context) {
    const std::lock_guard lock(found.writing);
    drawn = found.answer->draw(name, look, context);
  });
  return drawn;
}

template <class T>
void put(nb::dict& all, const std::string& name, const Array<T>& values, nb::handle owner) {
  if (!values.empty()) all[to_str(name)] = view1(values.data(), values.size(), owner);
}
void put(nb::dict& all, const std::string& name, const Array<Point3>& values, nb::handle owner) {
  if (!values.empty())
    all[to_str(name)] = view2(reinterpret_cast<const double*>(values.data()), values.size(), 3, owner);
}
template <class E>
void put_codes(nb::dict& all, const std::string& name, const Array<E>& values, nb::handle owner) {
  static_assert(sizeof(E) == 1);
  if (!values.empty())
    all[to_str(name)] = view1(reinterpret_cast<const std::uint8_t*>(values.data()), values.size(), owner);
}
void put_all(nb::dict& all, const std::string& room, const std::vector<Attribute>& fields, nb::handle owner) {
  for (const Attribute& field : fields) put(all, room + "." + field.name, field.values, owner);
}
void put_fields(nb::dict& all, const std::string& room, const PointFields& fields, nb::handle owner) {
  put(all, room + ".dz_signed", fields.dz_signed, owner);
  put(all, room + ".lod", fields.lod, owner);
}

/// Views of the arrays of a result, by "room.name"; `self` lives as long as one of them.
nb::dict arrays_of(nb::handle self) {
  const Found& found = nb::cast<const Found&>(self);
  nb::dict all;
  if (const auto* c = dynamic_cast<const cli::CompareAnswer*>(found.answer.get())) {
    put_fields(all, "points_a", c->comparison.fields_a, self);
    put_fields(all, "points_b", c->comparison.fields_b, self);
  } else if (const auto* m = dynamic_cast<const cli::MatchAnswer*>(found.answer.get())) {
    put_codes(all, "points_moving.stable", m->matching.stable, self);
    put_codes(all, "points_moving.agreement", m->matching.agreement, self);
  } else if (const auto* d = dynamic_cast<const cli::DistanceAnswer*>(found.answer.get())) {
    put_all(all, "points_a", d->distances.fields_a, self);
    put_all(all, "points_b", d->distances.fields_b, self);
    if (d->distances.m3c2) {
      const M3c2Result& r = *d->distances.m3c2;
      put(all, "core_points.xyz", r.cores, self);
      put(all, "core_points.distance", r.field.distance, self);
      put(all, "core_points.lod", r.field.lod, self);
      put(all, "core_points.significant", r.field.significant, self);
      put(all, "core_points.sigma1", r.field.sigma1, self);
      put(all, "core_points.sigma2", r.field.sigma2, self);
      put(all, "core_points.n1", r.field.n1, self);
      put(all, "core_points.n2", r.field.n2, self);
      put(all, "core_points.normal", r.field.normal, self);
    }
  } else if (const auto* a = dynamic_cast<const cli::AccuracyAnswer*>(found.answer.get())) {
    put_fields(all, "points_reference", a->accuracy.comparison.fields_a, self);
    put_fields(all, "points_reconstruction", a->accuracy.comparison.fields_b, self);
  } else if (const auto* s = dynamic_cast<const cli::ScannersAnswer*>(found.answer.get())) {
    put_fields(all, "points_a", s->scanners.comparison.fields_a, self);
    put_fields(all, "points_b", s->scanners.comparison.fields_b, self);
  } else if (const auto* f = dynamic_cast<const cli::AsymmetryAnswer*>(found.answer.get())) {
    put(all, "points.asymmetry", f->asymmetry.of_point, self);
  } else if (const auto* r = dynamic_cast<const cli::RoughnessAnswer*>(found.answer.get())) {
    put_all(all, "points", r->roughness.scan.fields, self);
    if (r->roughness.after) put_all(all, "points_after", r->roughness.after->fields, self);
  } else if (const auto* q = dynamic_cast<const cli::SequenceAnswer*>(found.answer.get())) {
    put(all, "points.xyz", q->sequence.points, self);
    put(all, "points.id", q->sequence.ids, self);
    put(all, "points.blend", q->sequence.blend, self);
    put_codes(all, "points.part", q->sequence.label, self);
  } else if (const auto* b = dynamic_cast<const cli::CombineAnswer*>(found.answer.get())) {
    put(all, "points.xyz", b->combination.points, self);
    put_codes(all, "points.part", b->combination.part, self);
  }
  return all;
}

const Comparison* comparison_of(const Answer& answer) {
  if (const auto* c = dynamic_cast<const cli::CompareAnswer*>(&answer)) return &c->comparison;
  if (const auto* a = dynamic_cast<const cli::AccuracyAnswer*>(&answer)) return &a->accuracy.comparison;
  if (const auto* s = dynamic_cast<const cli::ScannersAnswer*>(&answer)) return &s->scanners.comparison;
  if (const auto* f = dynamic_cast<const cli::AsymmetryAnswer*>(&answer)) return &f->asymmetry.comparison;
  return nullptr;
}

nb::object as_dict(MeasuredCells cells) {
  auto shared = std::make_shared<MeasuredCells>(std::move(cells));
  const MeasuredCells& m = *shared;
  const nb::capsule owner = owner_of(shared);
  nb::dict all;
  all["xy"] = view2(reinterpret_cast<const double*>(m.xy.data()), m.xy.size(), 2, owner);
  all["z_a"] = view1(m.z1.data(), m.z1.size(), owner);
  all["z_b"] = view1(m.z2.data(), m.z2.size(), owner);
  all["lod"] = m.lod.empty() ? nb::none() : view1(m.lod.data(), m.lod.size(), owner);
  all["triangles"] = view2(reinterpret_cast<const std::int32_t*>(m.triangles.data()), m.triangles.size(), 3, owner);
  all["offset"] = nb::cast(m.offset);
  all["axes"] = nb::cast(m.axes);
  return all;
}

/// The measured cells of a result, `which` scan of a roughness; None where there are none.
nb::object cells_of(const Found& found, const std::string& which) {
  if (const Comparison* c = comparison_of(*found.answer)) return as_dict(measured_cells(*c));
  if (const auto* r = dynamic_cast<const cli::RoughnessAnswer*>(found.answer.get())) {
    if (which == "after" && !r->roughness.after) return nb::none();
    const Texture& x = which == "after" ? *r->roughness.after : r->roughness.scan;
    return as_dict(measured_cells(x.cells, r->roughness.frame));
  }
  return nb::none();
}

nb::list scans_of(const Found& found) {
  nb::list all;
  const auto* scene = dynamic_cast<const cli::SceneAnswer*>(found.answer.get());
  if (scene == nullptr) return all;
  for (const auto& [name, cloud] : scene->scans) {
    all.append(nb::make_tuple(name, nb::cast(scan_of_cloud(cloud))));
  }
  return all;
}

}  // namespace

void bind_answers(nb::module_& module) {
  nb::class_<Found>(module, "Found")
      .def("json", [](const Found& f) { return to_str(f.answer->json({})); })
      .def("text", [](const Found& f) { return to_str(isopach::for_shell(f.answer->text())); })
      .def_prop_ro("warnings",
                   [](const Found& f) {
                     nb::list all;
                     for (const std::string& w : f.answer->warnings()) all.append(to_str(isopach::for_shell(w)));
                     return all;
                   })
      .def_prop_ro("failure", &required)
      .def("arrays", [](nb::handle self) { return arrays_of(self); })
      .def("cells", &cells_of, nb::arg("which"))
      .def("scans", &scans_of)
      .def("save", &save, nb::arg("folder"), nb::arg("words"), nb::arg("progress").none())
      .def("draw", &draw)
      .def("output_options", &output_options);
}

}  // namespace isopach::python
