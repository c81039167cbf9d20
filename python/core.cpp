// isopach._core: the verbs of cli/ for Python. No logic of its own: words and scans go in, an answer with its JSON and
// its arrays comes out. What is friendly to users stands in python/isopach/*.py. Here: a call of a verb, and the
// module.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <map>

#include "beside.hpp"
#include "bindings.hpp"
#include "cli/command.hpp"
#include "cli/verbs.hpp"
#include "isopach/base/kept_memory.hpp"
#include "isopach/io/polygons.hpp"
#include "isopach/version.hpp"

namespace isopach::python {
namespace {

using cli::Session;

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

std::vector<std::string> names_of_verbs() {
  std::vector<std::string> names;
  for (const auto& [name, run] : verbs()) names.push_back(name);
  return names;
}

void bind_verbs(nb::module_& module) {
  nb::class_<Given>(module, "Given")
      .def(nb::init<>())
      .def("add_scan", [](Given& g, const std::string& word, nb::object scan) { g.scans.emplace_back(word, scan); })
      .def("add_pose",
           [](Given& g, const std::string& word, const std::array<double, 16>& pose) { g.poses[word] = pose; })
      .def("add_matching", [](Given& g, const std::string& word, const std::string& json) { g.matchings[word] = json; })
      .def("add_polygons", [](Given& g, const std::string& word, const std::string& name, const std::string& crs,
                              const std::vector<std::pair<std::string, Rings>>& polygons) {
        g.polygons[word] = {name, crs, polygons};
      });
  nb::class_<KeptMemory>(module, "KeptMemory").def(nb::init<>());
  module.def("run", &run_verb, nb::arg("verb"), nb::arg("words"), nb::arg("given"), nb::arg("progress").none(),
             nb::arg("warn").none());
  module.def("options", &options_of);
  module.def("verbs", &names_of_verbs);
}

}  // namespace
}  // namespace isopach::python

NB_MODULE(_core, m) {
  using namespace isopach::python;
  nb::set_leak_warnings(false);  // what a cache still holds when the interpreter ends is no fault of anybody's
  m.doc() = "The verbs of isopach, as the package isopach uses them; not for direct use.";
  m.attr("version") = std::string(isopach::version);
  make_failure_type(m);
  bind_scans(m);
  bind_answers(m);
  bind_places(m);
  bind_verbs(m);
}
