#include "isopach/report/distance.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "isopach/io/write.hpp"
#include "isopach/report/page/values.hpp"
#include "isopach/report/page/words.hpp"
#include "isopach/version.hpp"

namespace isopach {
namespace {

using namespace values;
constexpr Typography plain = Typography::plain;

const char* to_text(MeshSource source) {
  return source == MeshSource::automatic ? "auto" : source == MeshSource::delaunay ? "delaunay" : "faces";
}

std::string measures_text(const DistanceMeasures& m) {
  std::string all;
  const auto add = [&](bool asked, const char* name) {
    if (asked) all += (all.empty() ? "" : ",") + std::string(name);
  };
  add(m.c2c, "c2c"), add(m.c2s, "c2s"), add(m.normal, "normal"), add(m.vertical, "vertical");
  add(m.surface, "surface"), add(m.hausdorff, "hausdorff"), add(m.m3c2, "m3c2");
  return all;
}

Json input_json(const InputSummary& in, std::size_t kept, std::size_t faces, bool own, double trimmed) {
  return {{"role", in.role},
          {"path", in.path},
          {"points", in.points},
          {"measured", kept},
          {"faces", faces == 0 ? Json(nullptr) : Json(faces)},
          {"surface", faces == 0 ? Json(nullptr) : Json(own ? "faces" : "delaunay")},
          {"trimmed_area", faces == 0 || own ? Json(nullptr) : real(trimmed)},
          {"unit", in.unit},
          {"vertical_unit", in.vertical_unit},
          {"crs", text_or_null(in.crs)},
          {"format", in.format}};
}

Json parameters_json(const Distances& d) {
  const DistanceOptions& o = d.options;
  const auto& r = d.frame.rotation;
  const auto of_m3c2 = [&](double value) { return o.measures.m3c2 ? real(value) : Json(nullptr); };
  return {{"measure", measures_text(o.measures)},
          {"mesh", to_text(o.mesh)},
          {"border", to_text(o.border)},
          {"max_edge", o.max_edge > 0 ? real(o.max_edge) : Json(nullptr)},
          {"tolerance", d.hausdorff ? real(o.tolerance) : Json(nullptr)},
          {"samples", d.surface ? Json(o.samples) : Json(nullptr)},
          {"normal_scale", of_m3c2(o.m3c2.normal_scale)},
          {"projection_scale", of_m3c2(o.m3c2.projection_scale)},
          {"max_depth", of_m3c2(o.m3c2.max_depth)},
          {"registration_error", of_m3c2(o.m3c2.registration_error)},
          {"duplicates", to_text(o.project.duplicates)},
          {"direction", point({r[6], r[7], r[8]})},
          {"direction_rule", to_text(o.project.direction.kind)},
          {"class", o.project.classes.empty() ? Json(nullptr) : Json(o.project.classes)},
          {"crop", crop_box(o.project.crop)},
          {"unit", d.unit},
          {"allow_crs", o.allow_crs}};
}

Json figures_json(const Figures& f, bool has_sign) {
  Json out{{"count", f.count}, {"missing", f.missing}};
  const auto value = [&](const char* name, double v) { out[name] = f.count > 0 ? real(v) : Json(nullptr); };
  value("mean", f.mean), value("rms", f.rms), value("max", f.max), value("median", f.median), value("p95", f.p95);
  if (has_sign) value("signed_mean", f.signed_mean), value("signed_std", f.signed_std);
  return out;
}

template <class T, class F>
Json both_json(const std::optional<BothWays<T>>& value, F&& one) {
  if (!value) return nullptr;
  return {{"a_to_b", one(value->a_to_b)}, {"b_to_a", one(value->b_to_a)}};
}

Json surface_json(const SurfaceFigures& f) {
  return {{"area", real(f.area)}, {"samples", f.samples},
          {"mean", real(f.mean)}, {"mean_error", real(f.mean_error)},
          {"rms", real(f.rms)},   {"rms_error", real(f.rms_error)},
          {"max", real(f.max)}};
}

Json hausdorff_json(const std::optional<BothWays<HausdorffBound>>& h) {
  if (!h) return nullptr;
  const auto one = [](const HausdorffBound& b) -> Json {
    return {{"lower", real(b.lower)}, {"upper", real(b.upper)}, {"at", point(b.at)}, {"pieces", b.pieces}};
  };
  return {{"lower", real(std::max(h->a_to_b.lower, h->b_to_a.lower))},
          {"upper", real(std::max(h->a_to_b.upper, h->b_to_a.upper))},
          {"a_to_b", one(h->a_to_b)},
          {"b_to_a", one(h->b_to_a)}};
}

Json m3c2_json(const std::optional<M3c2Result>& m) {
  if (!m) return nullptr;
  Json out{{"cores", m->cores.size()},
           {"measured", m->measured},
           {"with_lod", m->with_lod},
           {"significant", m->significant},
           {"median_lod", m->with_lod > 0 ? real(m->median_lod) : Json(nullptr)}};
  out["distance"] = figures_json(m->figures, true);
  return out;
}

class Summary {
 public:
  explicit Summary(const Distances& d) : unit_(unit_text(d.unit)) {}
  void line(const std::string& label, const std::string& text) { isopach::line(out_, label, text); }
  void free_line(const std::string& text) { out_ += text + "\n"; }
  [[nodiscard]] std::string length(double v) const { return number(v, plain) + " " + unit_; }
  [[nodiscard]] std::string signed_length(double v) const { return signed_number(v, plain) + " " + unit_; }
  [[nodiscard]] const std::string& str() const { return out_; }

  void figures(const char* name, const char* what, const std::optional<BothWays<Figures>>& both, bool has_sign) {
    if (!both) return;
    line(name, what);
    direction("A to B", both->a_to_b, has_sign);
    direction("B to A", both->b_to_a, has_sign);
  }
  void direction(const char* way, const Figures& f, bool has_sign) {
    if (f.count == 0) return line("", fmt::format("{}: no point has one", way));
    std::string text = fmt::format("{}: mean {}, rms {}, max {}, median {}, 95 % {}", way, length(f.mean),
                                   length(f.rms), length(f.max), length(f.median), length(f.p95));
    if (has_sign) text += fmt::format("; B - A {} ± {}", signed_length(f.signed_mean), length(f.signed_std));
    if (f.missing > 0) text += fmt::format("; {} points without", count(f.missing, plain));
    line("", text);
  }

 private:
  std::string unit_, out_;
};

void add_input(Summary& s, const InputSummary& in, std::size_t kept, std::size_t faces, bool own, double trimmed) {
  std::string text = fmt::format("{}: {} points", input_name(in), count(in.points, plain));
  if (kept != in.points) text += fmt::format(", {} measured", count(kept, plain));
  if (faces > 0) text += fmt::format(", {} {}", count(faces, plain), own ? "faces" : "Delaunay triangles");
  if (trimmed > 0) text += fmt::format(" (border: without {:.2g} % of the area of the hull)", 100 * trimmed);
  s.line(in.role, text);
}

void add_surfaces(Summary& s, const Distances& d) {
  if (d.surface) {
    s.line("surface", "distance to the other surface by area (Metro) ± standard error of the sampling");
    const auto one = [&](const char* way, const SurfaceFigures& f) {
      s.line("", fmt::format("{}: mean {} ± {:.1g}, rms {} ± {:.1g}, max of {} samples {}", way, s.length(f.mean),
                             f.mean_error, s.length(f.rms), f.rms_error, count(f.samples, plain), s.length(f.max)));
    };
    one("A to B", d.surface->a_to_b), one("B to A", d.surface->b_to_a);
  }
  if (!d.hausdorff) return;
  const HausdorffBound &ab = d.hausdorff->a_to_b, &ba = d.hausdorff->b_to_a;
  s.line("Hausdorff", fmt::format("{} (proven: at most {:.3g} more)", s.length(std::max(ab.lower, ba.lower)),
                                  std::max(ab.upper, ba.upper) - std::max(ab.lower, ba.lower)));
  const auto one = [&](const char* way, const HausdorffBound& b) {
    s.line("", fmt::format("{}: {} to {}", way, number(b.lower, plain, 8), number(b.upper, plain, 8)));
  };
  one("A to B", ab), one("B to A", ba);
}

void add_m3c2(Summary& s, const M3c2Result& m) {
  s.line("m3c2", fmt::format("{} core points, {} measured, {} with a level of detection, {} significant at 95 %",
                             count(m.cores.size(), plain), count(m.measured, plain), count(m.with_lod, plain),
                             count(m.significant, plain)));
  if (m.measured == 0) return;
  s.line("", fmt::format("B - A: mean {} ± {}, largest {}, median level of detection {}",
                         s.signed_length(m.figures.signed_mean), s.length(m.figures.signed_std),
                         s.length(m.figures.max), s.length(m.median_lod)));
}

}  // namespace

std::string distance_json(const Distances& d, const std::vector<std::string>& outputs) {
  const auto unsigned_figures = [](const Figures& f) { return figures_json(f, false); };
  const auto signed_figures = [](const Figures& f) { return figures_json(f, true); };
  const Json report = {{"schema", "isopach.distance/1"},
                       {"tool", {{"name", tool_name}, {"version", version}}},
                       {"inputs", Json::array({input_json(d.a, d.points_a, d.faces_a, d.own_faces_a, d.trimmed_a),
                                               input_json(d.b, d.points_b, d.faces_b, d.own_faces_b, d.trimmed_b)})},
                       {"parameters", parameters_json(d)},
                       {"pose", {{"matrix", matrix(d.options.pose)}}},
                       {"c2c", both_json(d.c2c, unsigned_figures)},
                       {"c2s", both_json(d.c2s, unsigned_figures)},
                       {"normal", both_json(d.normal, signed_figures)},
                       {"vertical", both_json(d.vertical, signed_figures)},
                       {"surface", both_json(d.surface, surface_json)},
                       {"hausdorff", hausdorff_json(d.hausdorff)},
                       {"m3c2", m3c2_json(d.m3c2)},
                       {"outputs", outputs},
                       {"warnings", messages(d.warnings)},
                       {"timing_s", timing(d.timing)}};
  return report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string distance_text(const Distances& d) {
  Summary s(d);
  add_input(s, d.a, d.points_a, d.faces_a, d.own_faces_a, d.trimmed_a);
  add_input(s, d.b, d.points_b, d.faces_b, d.own_faces_b, d.trimmed_b);
  s.figures("c2c", "to the nearest point of the other scan", d.c2c, false);
  s.figures("c2s", "to the closest point of the other surface", d.c2s, false);
  s.figures("normal", "along the normal of the other surface", d.normal, true);
  s.figures("vertical", "along the direction", d.vertical, true);
  add_surfaces(s, d);
  if (d.m3c2) add_m3c2(s, *d.m3c2);
  if (d.unit == "unknown" || d.unit.empty()) s.line("units", unit_sentence(d.unit));
  s.line("time", fmt::format("{:.2f} s", d.timing.total));
  for (const std::string& w : d.warnings) s.free_line("warning: " + message_text(w));
  return s.str();
}

void write_distance_points(const std::string& path, const CloudView& cloud, const std::vector<Attribute>& fields,
                           const Context& context) {
  Cloud out;
  out.points = cloud.points.copy();
  out.unit = cloud.unit;
  out.vertical_unit = cloud.vertical_unit;
  out.crs = cloud.crs;
  out.attributes = fields;
  write_cloud(path, out, context);
}

void write_core_points(const std::string& path, const Distances& d, const Context& context) {
  if (!d.m3c2) throw Error(ExitCode::internal, path + ": m3c2 was not measured");
  const M3c2Field& f = d.m3c2->field;
  Cloud out;
  out.points = d.m3c2->cores;
  out.unit = d.unit;
  out.attributes = {{"distance", f.distance},
                    {"lod", f.lod},
                    {"significant", f.significant},
                    {"sigma1", f.sigma1},
                    {"sigma2", f.sigma2},
                    {"n1", f.n1},
                    {"n2", f.n2}};
  const auto axis = [&](const char* name, double Point3::*component) {
    Attribute a{name, Array<double>(f.normal.size())};
    for (std::size_t i = 0; i < f.normal.size(); ++i) a.values[i] = f.normal[i].*component;
    out.attributes.push_back(std::move(a));
  };
  axis("nx", &Point3::x), axis("ny", &Point3::y), axis("nz", &Point3::z);
  write_cloud(path, out, context);
}

}  // namespace isopach
