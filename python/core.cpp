// isopach._core: the verbs of cli/ for Python. No logic of its own: words and scans go in, an answer with its JSON and
// its arrays comes out. What is friendly to users stands in python/isopach/*.py.
//
// A verb runs in a thread of its own while Python's waits for it without the GIL, wakes every few hundredths of a
// second to ask for signals (Ctrl-C), and tells progress and warnings from there: no call into Python comes from
// elsewhere.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

#include "cells.hpp"
#include "cli/answer.hpp"
#include "cli/command.hpp"
#include "cli/input_words.hpp"
#include "cli/session.hpp"
#include "cli/verbs.hpp"
#include "isopach/base/option_key.hpp"
#include "isopach/base/thread_limit.hpp"
#include "isopach/io/polygons.hpp"
#include "isopach/io/read.hpp"
#include "isopach/io/write.hpp"
#include "isopach/report/draw/map.hpp"
#include "isopach/report/match.hpp"
#include "isopach/report/report.hpp"
#include "isopach/version.hpp"

namespace nb = nanobind;

namespace isopach::python {
namespace {

using cli::Answer;
using cli::Session;

PyObject* failure_type = nullptr;  // isopach._core.Failure(exit_code, message)

/// The texts of the library go to Python as bytes that may be no UTF-8 (names of files): as os.fsdecode reads them.
nb::str to_str(const std::string& text) {
  PyObject* made = PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "surrogateescape");
  if (made == nullptr) throw nb::python_error();
  return nb::steal<nb::str>(made);
}

std::string to_string(const nb::bytes& bytes) { return {bytes.c_str(), bytes.size()}; }

[[noreturn]] void raise_failure(ExitCode code, const std::string& message) {
  nb::object args = nb::make_tuple(static_cast<int>(code), to_str(message));
  PyErr_SetObject(failure_type, args.ptr());
  throw nb::python_error();
}

// --- work beside the interpreter -------------------------------------------------------------------------------------

/// Runs `work` in a thread of its own and waits for it. Signals are looked for, progress and warnings told, by this
/// one.
class Beside {
 public:
  Beside(nb::object progress, nb::object warn) : progress_(std::move(progress)), warn_(std::move(warn)) {}

  [[nodiscard]] const std::atomic<bool>& cancelled() const { return cancelled_; }
  [[nodiscard]] bool tells_progress() const { return !progress_.is_none(); }
  void step(std::string_view stage, double fraction) {  // of the worker
    const std::lock_guard lock(mutex_);
    if (!steps_.empty() && steps_.back().first == stage)
      steps_.back().second = fraction;
    else
      steps_.emplace_back(stage, fraction);
  }
  void hear(const std::string& warning) {  // of the worker
    const std::lock_guard lock(mutex_);
    warnings_.push_back(for_shell(warning));
  }

  template <class Work>
  void run(Work&& work) {
    std::exception_ptr failure;
    std::exception_ptr stopped;  // a Python exception: KeyboardInterrupt, or what a callback raised
    std::thread worker([&] {
      try {
        work();
      } catch (...) {
        failure = std::current_exception();
      }
      const std::lock_guard lock(mutex_);
      done_ = true;
      wake_.notify_one();
    });
    while (!wait()) {
      try {
        if (!stopped && PyErr_CheckSignals() != 0) throw nb::python_error();
        if (!stopped) tell();
      } catch (...) {
        stopped = std::current_exception();
        cancelled_ = true;
      }
    }
    {
      nb::gil_scoped_release released;
      worker.join();
    }
    if (!stopped && !failure) tell();
    if (stopped) std::rethrow_exception(stopped);
    if (failure) std::rethrow_exception(failure);
  }

 private:
  bool wait() {
    nb::gil_scoped_release released;
    std::unique_lock lock(mutex_);
    return wake_.wait_for(lock, std::chrono::milliseconds(20), [&] { return done_; });
  }
  void tell() {
    std::vector<std::pair<std::string, double>> steps;
    std::vector<std::string> warnings;
    {
      const std::lock_guard lock(mutex_);
      steps.swap(steps_), warnings.swap(warnings_);
    }
    if (!progress_.is_none())
      for (const auto& [stage, fraction] : steps) progress_(to_str(stage), fraction);
    if (!warn_.is_none())
      for (const std::string& warning : warnings) warn_(to_str(warning));
  }

  nb::object progress_, warn_;
  std::atomic<bool> cancelled_{false};
  std::mutex mutex_;
  std::condition_variable wake_;
  bool done_ = false;
  std::vector<std::pair<std::string, double>> steps_;
  std::vector<std::string> warnings_;
};

/// Runs `work` beside the interpreter, in a session; failures of the library come out as Failure, those of memory as
/// MemoryError.
template <class Work>
void run_in(Session& session, Beside& beside, Work&& work) {
  session.shell = false;
  session.cancelled = &beside.cancelled();
  if (beside.tells_progress())
    session.progress = [&](std::string_view stage, double fraction) { beside.step(stage, fraction); };
  session.warn = [&](const std::string& warning) { beside.hear(warning); };
  ExitCode code = ExitCode::done;
  std::string message;
  beside.run([&] {
    const cli::SessionScope scope(session);
    try {
      work();
    } catch (const Error& error) {
      code = error.code();
      message = for_shell(error.what());
      if (code == ExitCode::input || code == ExitCode::no_overlap) message = cli::naming_a_scan(message);
    }
  });
  session.cancelled = nullptr, session.progress = nullptr, session.warn = nullptr;
  if (code != ExitCode::done) raise_failure(code, message);
}

/// Work that has no words.
template <class Work>
void compute(Work&& work) {
  Session session;
  Beside beside{nb::none(), nb::none()};
  run_in(session, beside, [&] {
    Context context;
    context.cancelled = session.cancelled;
    work(context);
  });
}

// --- arrays ----------------------------------------------------------------------------------------------------------

template <class T>
nb::object view1(const T* data, std::size_t n, nb::handle owner, std::int64_t stride = 1) {
  const std::size_t shape[1] = {n};
  const std::int64_t strides[1] = {stride};
  return nb::cast(nb::ndarray<nb::numpy, const T>(data, 1, shape, owner, strides));
}
template <class T>
nb::object view2(const T* data, std::size_t n, std::size_t columns, nb::handle owner) {
  const std::size_t shape[2] = {n, columns};
  return nb::cast(nb::ndarray<nb::numpy, const T>(data, 2, shape, owner));
}

/// Arrays that are made on demand belong to the array that shows them.
template <class A>
nb::capsule owner_of(std::shared_ptr<A> array) {
  return nb::capsule(new std::shared_ptr<A>(std::move(array)),
                     [](void* p) noexcept { delete static_cast<std::shared_ptr<A>*>(p); });
}
template <class T>
nb::object given1(Array<T> values) {
  auto shared = std::make_shared<Array<T>>(std::move(values));
  const T* data = shared->data();
  const std::size_t n = shared->size();
  return view1(data, n, owner_of(std::move(shared)));
}

using InDoubles = nb::ndarray<const double, nb::device::cpu>;
using InMesh = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using InValues = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using InTriangles = nb::ndarray<const std::int32_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

// --- scans -----------------------------------------------------------------------------------------------------------

/// A scan: of a file, whose arrays it owns, or a view of arrays of Python's, which it keeps alive.
struct Scan {
  CloudView view;
  std::shared_ptr<const Cloud> cloud;  ///< that the view is of; null: of arrays of Python's
  nb::object points, faces;            ///< these arrays
  std::vector<std::pair<std::string, nb::object>> attributes;
};

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

Scan scan_of_cloud(std::shared_ptr<const Cloud> cloud) {
  Scan scan;
  scan.view = CloudView(cloud);
  scan.cloud = std::move(cloud);
  return scan;
}

Scan read_scan(const nb::bytes& path, int threads, nb::object progress) {
  Session session;
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
    *cloud = read_cloud(name, all, context);
  });
  return scan_of_cloud(cloud);
}

// --- answers ---------------------------------------------------------------------------------------------------------

/// An answer, and what the scans in it refer to.
struct Found {
  std::unique_ptr<Answer> answer;
  std::string verb;
  std::vector<std::string> words;
  std::vector<nb::object> scans;
  std::mutex writing;
};

using Rings = std::vector<std::vector<std::pair<double, double>>>;

PolygonSet polygon_set(const std::string& name, const std::string& crs,
                       const std::vector<std::pair<std::string, Rings>>& polygons) {
  PolygonSet set;
  set.path = name, set.crs = crs, set.geo = geo_functions();
  for (const auto& [title, rings] : polygons) {
    Polygon polygon;
    polygon.name = title;
    for (const auto& ring : rings) {
      polygon.rings.emplace_back();
      for (const auto& [x, y] : ring) polygon.rings.back().push_back({x, y});
    }
    set.polygons.push_back(std::move(polygon));
  }
  return set;
}

struct Given {
  std::vector<std::pair<std::string, nb::object>> scans;
  std::map<std::string, std::array<double, 16>> poses;
  std::map<std::string, std::string> matchings;
  std::map<std::string, std::tuple<std::string, std::string, std::vector<std::pair<std::string, Rings>>>> polygons;
};

const std::map<std::string, int (*)(const cli::Arguments&)>& verbs() {
  static const std::map<std::string, int (*)(const cli::Arguments&)> all{
      {"compare", cli::run_compare},     {"match", cli::run_match},       {"distance", cli::run_distance},
      {"asymmetry", cli::run_asymmetry}, {"accuracy", cli::run_accuracy}, {"scanners", cli::run_scanners},
      {"roughness", cli::run_roughness}, {"sequence", cli::run_sequence}, {"combine", cli::run_combine},
      {"info", cli::run_info},           {"simulate", cli::run_simulate}, {"convert", cli::run_convert},
  };
  return all;
}

Found* run_verb(const std::string& verb, const std::vector<nb::bytes>& words, const Given& given, nb::object progress,
                nb::object warn) {
  auto found = std::make_unique<Found>();
  found->verb = verb;
  cli::Arguments arguments;
  for (const nb::bytes& word : words) arguments.push_back(to_string(word));
  Session session;
  for (const auto& [word, scan] : given.scans) {
    session.scans.emplace(word, nb::cast<const Scan&>(scan).view);
    found->scans.push_back(scan);
  }
  for (const auto& [word, m] : given.poses) session.poses[word].m = m;
  session.matchings = given.matchings;
  for (const auto& [word, set] : given.polygons)
    session.polygons[word] = polygon_set(std::get<0>(set), std::get<1>(set), std::get<2>(set));
  Beside beside(std::move(progress), std::move(warn));
  run_in(session, beside, [&] { verbs().at(verb)(arguments); });
  found->answer = std::move(session.answer);
  found->words = std::move(session.words);
  return found.release();  // Python's from now on
}

nb::list options_of(const std::string& verb) {
  std::vector<cli::OptionRow> rows;
  Session session;
  session.shell = false;
  session.table = &rows;
  {
    const cli::SessionScope scope(session);
    verbs().at(verb)({});
  }
  nb::list all;
  for (const cli::OptionRow& row : rows) {
    nb::dict entry;
    entry["names"] = nb::cast(row.names);
    entry["positional"] = row.positional, entry["flag"] = row.flag, entry["list"] = row.list;
    entry["required"] = row.required, entry["heading"] = row.heading, entry["type"] = row.type;
    entry["value"] = row.value, entry["description"] = row.description;
    all.append(entry);
  }
  return all;
}

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

void write_scan(const Scan& scan, const nb::bytes& path) {
  const std::string name = to_string(path);
  compute([&](const Context& context) { write_cloud(name, copy_of(scan.view), context); });
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
}  // namespace isopach::python

NB_MODULE(_core, m) {
  using namespace isopach::python;
  m.doc() = "The verbs of isopach, as the package isopach uses them; not for direct use.";
  m.attr("version") = std::string(isopach::version);
  failure_type = PyErr_NewException("isopach._core.Failure", PyExc_Exception, nullptr);
  m.attr("Failure") = nb::borrow(failure_type);

  nb::class_<Scan>(m, "Scan")
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
  m.def("scan", &scan_of_arrays, nb::arg("points_object"), nb::arg("points").noconvert(), nb::arg("attributes"),
        nb::arg("faces").none(), nb::arg("unit"), nb::arg("vertical_unit"), nb::arg("crs"), nb::arg("name"));
  m.def("read", &read_scan, nb::arg("path"), nb::arg("threads"), nb::arg("progress").none());

  nb::class_<Given>(m, "Given")
      .def(nb::init<>())
      .def("add_scan", [](Given& g, const std::string& word, nb::object scan) { g.scans.emplace_back(word, scan); })
      .def("add_pose",
           [](Given& g, const std::string& word, const std::array<double, 16>& pose) { g.poses[word] = pose; })
      .def("add_matching", [](Given& g, const std::string& word, const std::string& json) { g.matchings[word] = json; })
      .def("add_polygons", [](Given& g, const std::string& word, const std::string& name, const std::string& crs,
                              const std::vector<std::pair<std::string, Rings>>& polygons) {
        g.polygons[word] = {name, crs, polygons};
      });

  nb::class_<Found>(m, "Found")
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
  m.def("run", &run_verb, nb::arg("verb"), nb::arg("words"), nb::arg("given"), nb::arg("progress").none(),
        nb::arg("warn").none());
  m.def("options", &options_of);
  m.def("pixels", &pixels);
  m.def("values_at", &values_at);
  m.def("section", &section);
  m.def("verbs", [] {
    std::vector<std::string> names;
    for (const auto& [name, run] : verbs()) names.push_back(name);
    return names;
  });
}
