// result.json: the keys of schema isopach.compare/1 in their order (docs/schema/compare-1.json).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "isopach/report/page/alignment_values.hpp"
#include "isopach/report/page/change_values.hpp"
#include "isopach/report/page/matched.hpp"
#include "isopach/report/page/uncertainty.hpp"
#include "isopach/report/page/values.hpp"
#include "isopach/report/page/verdict_values.hpp"
#include "isopach/report/page/words.hpp"
#include "isopach/report/report.hpp"
#include "isopach/version.hpp"

namespace isopach {
namespace {

using namespace values;

Json reals(const std::vector<double>& values) {
  Json out = Json::array();
  for (const double v : values) out.push_back(real(v));
  return out;
}

Json input_json(const InputSummary& in) {
  const Cleaning& k = in.cleaning;
  return {{"role", in.role},
          {"path", in.path},
          {"points", in.points},
          {"nodes", in.nodes},
          {"duplicates", k.duplicates},
          {"unit", in.unit},
          {"crs", text_or_null(in.crs)},
          {"bounds", {{"min", point(in.bounds.min)}, {"max", point(in.bounds.max)}}},
          {"format", in.format},
          {"vertical_unit", in.vertical_unit},
          {"dropped",
           {{"nonfinite", k.dropped_nonfinite},
            {"class", k.dropped_class},
            {"crop", k.dropped_crop},
            {"nodata", in.nodata}}},
          {"duplicate_max_spread", real(k.duplicate_max_spread)},
          {"layered_share", real(in.layered_share)}};
}

Json sigma_json(const SigmaSource& s) {
  switch (s.kind) {
    case SigmaSource::Kind::none:
      return nullptr;
    case SigmaSource::Kind::constant:
      return real(s.value);
    case SigmaSource::Kind::attribute:
      return "@" + s.name;
    case SigmaSource::Kind::raster:
      return s.name;
  }
  return nullptr;
}

Json paths_of(const std::vector<PolygonSet>& sets) {
  Json paths = Json::array();
  for (const PolygonSet& set : sets) paths.push_back(set.path);
  return paths;
}

Json registration_json(const UncertaintyOptions& o) {
  if (o.registration_covariance) return o.registration_source;
  return o.registration_error > 0 ? real(o.registration_error) : Json(nullptr);
}

Json parameters_json(const Comparison& c) {
  const CompareOptions& o = c.options;
  const auto& r = c.frame.rotation;
  return {{"surface", to_text(o.surface)},
          {"interpolation", o.interpolation == Interpolation::cubic ? "cubic" : "linear"},
          {"border", to_text(o.border)},
          {"folds", to_text(o.folds)},
          {"max_edge", o.max_edge > 0 ? real(o.max_edge) : Json(nullptr)},
          {"alpha", o.alpha > 0 ? real(o.alpha) : Json(nullptr)},
          {"domain", to_text(o.domain)},
          {"include", paths_of(o.area.include)},
          {"exclude", paths_of(o.area.exclude)},
          {"budget", paths_of(o.area.budget)},
          {"mask", o.area.mask ? Json(o.area.mask->path) : Json(nullptr)},
          {"measure", to_text(o.measure)},
          {"sigma", o.currents.sigma > 0 ? real(o.currents.sigma) : Json(nullptr)},
          {"currents_error", real(o.currents.error)},
          {"weight", text_or_null(to_text(o.weight))},
          {"duplicates", to_text(o.project.duplicates)},
          {"direction", point({r[6], r[7], r[8]})},
          {"direction_rule", to_text(o.project.direction.kind)},
          {"class", o.project.classes.empty() ? Json(nullptr) : Json(o.project.classes)},
          {"crop", crop_box(o.project.crop)},
          {"unit", c.unit},
          {"height_unit", height_unit(c)},
          {"locate", to_text(o.locate)},
          {"sigma1", sigma_json(o.uncertainty.sigma1)},
          {"sigma2", sigma_json(o.uncertainty.sigma2)},
          {"lod", o.uncertainty.lod > 0 ? real(o.uncertainty.lod) : Json(nullptr)},
          {"confidence", real(o.uncertainty.confidence)},
          {"uncertainty_model", to_text(o.uncertainty.model)},
          {"correlation", to_text(o.uncertainty.correlation)},
          {"correlation_range",
           o.uncertainty.correlation_range > 0 ? real(o.uncertainty.correlation_range) : Json(nullptr)},
          {"registration_error", registration_json(o.uncertainty)},
          {"noise_floor", o.noise_floor},
          {"min_coverage", real(o.min_coverage)},
          {"allow_crs", o.allow_crs},
          {"check_layers", o.check_layers}};
}

/// The sums over T, over the exact overlay, and what the second has more than the first. Null where one of them only
/// was asked for.
Json surfaces_json(const Comparison& c) {
  if (!c.overlay) return nullptr;
  const auto sums = [](const Measures& m, const Measures& less) {
    return Json{{"area", real(m.area - less.area)},
                {"rho", real(m.rho - less.rho)},
                {"above", real(m.volume.above - less.volume.above)},
                {"below", real(m.volume.below - less.volume.below)},
                {"net", real(m.volume.net - less.volume.net)},
                {"absolute", real(m.volume.absolute - less.volume.absolute)}};
  };
  return {{"common", sums(c.measures, {})},
          {"overlay", sums(*c.overlay, {})},
          {"overlay_minus_common", sums(*c.overlay, c.measures)}};
}

Json budget_json(const Comparison& c) {
  Json rows = Json::array();
  for (const BudgetRow& r : c.budget)
    rows.push_back({{"name", r.name},
                    {"file", r.file},
                    {"restricts", r.restricts},
                    {"above", real(r.volume.above)},
                    {"below", real(r.volume.below)},
                    {"net", real(r.volume.net)},
                    {"absolute", real(r.volume.absolute)},
                    {"area", real(r.area)},
                    {"mean", r.area > 0 ? real(r.mean) : Json(nullptr)},
                    {"rho", r.area > 0 ? real(r.rho) : Json(nullptr)},
                    {"polygon_area", real(r.polygon_area)},
                    {"coverage", real(r.coverage)}});
  return rows;
}

Json difference_json(const DifferenceStatistics& d) {
  Json percentiles;
  for (const Percentile& p : all_percentiles(d)) percentiles[fmt::format("{}", p.level)] = real(p.value);
  return {{"mean", real(d.mean)},
          {"rms", real(d.rms)},
          {"std", real(d.std)},
          {"median", real(d.median)},
          {"nmad", real(d.nmad)},
          {"max_above", real(d.max_above)},
          {"max_below", real(d.max_below)},
          {"abs_percentiles", percentiles},
          {"histogram", {{"edges", reals(d.histogram.edges)}, {"areas", reals(d.histogram.areas)}}}};
}

Json weight_json(const Comparison& c) {
  if (!c.weighted) return nullptr;
  const WeightedMeasures& w = *c.weighted;
  return {{"kind", to_text(c.options.weight.kind)},
          {"expression", to_text(c.options.weight)},
          {"integral", real(w.integral)},
          {"rho", real(w.rho)},
          {"above", real(w.above)},
          {"below", real(w.below)},
          {"net", real(w.net)},
          {"error_estimate", real(w.error_estimate)},
          {"integral_error", real(w.integral_error)}};
}

Json currents_json(const Comparison& c) {
  if (!c.currents) return nullptr;
  const Currents& s = c.currents->sums;
  return {{"sigma", real(s.sigma)},
          {"distance", real(c.currents->distance())},
          {"relative", real(c.currents->relative())},
          {"norm_a", real(std::sqrt(std::max(0.0, s.norm_a2)))},
          {"norm_b", real(std::sqrt(std::max(0.0, s.norm_b2)))},
          {"rho", real(s.rho)},
          {"rho_error", real(s.error_bound)},
          {"inner", real(s.inner)},
          {"inner_error", real(s.inner_bound)},
          {"reached", s.reached},
          {"triangles_a", c.currents->triangles_a},
          {"triangles_b", c.currents->triangles_b}};
}

Json detail_json(const std::optional<DetailMeasure>& d) {
  if (!d) return nullptr;
  return {{"coarser", d->coarser_is_b ? "B" : "A"},
          {"mean", real(d->mean)},
          {"area", real(d->area)},
          {"averaged", d->averaged},
          {"bare", d->bare}};
}

/// What was not asked for is null: no ±0 for want of data.
Json uncertainty_json(const Comparison& c) {
  const Uncertainty& u = c.uncertainty;
  const Json none = nullptr;
  const auto of = [&](double VolumeTriple::*part) { return u.sigma ? real((*u.sigma).*part) : none; };
  const auto net = net_interval(c);
  const std::optional<NoiseFloor>& floor = c.noise_floor;
  return {{"model", to_text(c.options.uncertainty.model)},
          {"confidence", real(c.options.uncertainty.confidence)},
          {"lod", u.lod ? real(*u.lod) : none},
          {"lod_rule", u.lod ? Json(u.lod_is_given ? "given" : "sigmas") : none},
          {"sigma_net", of(&VolumeTriple::net)},
          {"sigma_net_registration", u.sigma_net_registration ? real(*u.sigma_net_registration) : none},
          {"sigma_above", of(&VolumeTriple::above)},
          {"sigma_below", of(&VolumeTriple::below)},
          {"interval_net", net ? Json::array({real(net->first), real(net->second)}) : none},
          {"rectification_bias_max", u.rectification_bias ? real(*u.rectification_bias) : none},
          {"thresholded", u.detected ? Json{{"above", real(u.detected->above)},
                                            {"below", real(u.detected->below)},
                                            {"area", real(u.detected->area)}}
                                     : none},
          {"significant_area", u.detected ? real(u.detected->area / c.domain_area) : none},
          {"noise_floor",
           {{"rho", floor ? real(floor->rho) : none},
            {"above", floor ? real(floor->above) : none},
            {"below", floor ? real(floor->below) : none},
            {"absolute", floor ? real(floor->above + floor->below) : none}}},
          {"debiased", floor ? Json{{"rho", real(floor->debiased_rho)},
                                    {"above", real(floor->debiased.above)},
                                    {"below", real(floor->debiased.below)},
                                    {"absolute", real(floor->debiased.absolute)}}
                             : none}};
}

/// Keys that are there where changes were asked for alone: those of options behind the other options, the objects in
/// front of the list of files.
void add_changes(Json& report, const Comparison& c) {
  if (!c.changes) return;
  const ChangeOptions& o = c.options.changes;
  Json& parameters = report["parameters"];
  parameters["changes"] = true;
  parameters["change_height"] = o.height > 0 ? real(o.height) : Json(nullptr);
  parameters["min_change_volume"] = real(o.min_volume);
  parameters["min_change_area"] = o.min_area ? real(*o.min_area) : Json(nullptr);
  Json with;
  for (auto& [key, value] : report.items()) {
    if (key == "outputs") with["change_summary"] = change_summary_json(c), with["changes"] = changes_json(c);
    with[key] = std::move(value);
  }
  report = std::move(with);
}

/// The stages every comparison has come first, each the sum of the stages of that name; others follow by their own
/// names.
Json timing_json(const Timing& timing) {
  Json out;
  for (const char* stage : {"read", "delaunay", "spanning_tree", "localise", "merge", "measure", "write"})
    out[stage] = 0.0;
  out["total"] = real(timing.total);
  for (const auto& [stage, seconds] : timing.stages) {
    if (stage == "total") continue;
    const double before = out.contains(stage) && out[stage].is_number() ? out[stage].get<double>() : 0.0;
    out[stage] = real(before + seconds);
  }
  return out;
}

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace

std::string histogram_csv(const Comparison& c) {
  const Histogram& h = c.measures.difference.histogram;
  std::string out = "d_from,d_to,area\n";
  for (std::size_t i = 0; i < h.areas.size(); ++i)
    out += real(h.edges[i]).dump() + "," + real(h.edges[i + 1]).dump() + "," + real(h.areas[i]).dump() + "\n";
  return out;
}

std::string budget_csv(const Comparison& c) {
  // The words of the summary and the report for what result.json calls above, below and absolute.
  std::string out = "name,gained,lost,net,gross,area,mean,rho,polygon_area,coverage,file\n";
  const Json rows = budget_json(c);
  for (const Json& row : rows) {
    out += csv_field(row["name"].get<std::string>());
    for (const char* key : {"above", "below", "net", "absolute", "area", "mean", "rho", "polygon_area", "coverage"})
      out += "," + (row[key].is_null() ? "" : row[key].dump());
    out += "," + csv_field(row["file"].get<std::string>()) + "\n";
  }
  return out;
}

std::string comparison_json(const Comparison& c, const std::vector<std::string>& outputs) {
  return comparison_json(c, outputs, nullptr);
}

std::string comparison_json(const Comparison& c, const std::vector<std::string>& outputs, const Matching* matched) {
  const Measures& m = c.measures;
  const Json none = nullptr;
  Json report = {
      {"schema", "isopach.compare/1"},
      {"tool", {{"name", tool_name}, {"version", version}}},
      {"inputs", Json::array({input_json(c.a), input_json(c.b)})},
      {"parameters", parameters_json(c)},
      {"pose", {{"matrix", matrix(c.options.pose)}}},
      {"matched", matched_json(matched)},
      {"verdict", matched != nullptr ? verdict_json(matched->verdict, matched->unit) : none},
      {"domain", {{"area", real(c.domain_area)}, {"area_union", real(c.area_union)}, {"coverage", real(c.coverage)}}},
      {"measure",
       {{"rho", real(m.rho)},
        {"rho_dv", c.detail ? real(c.detail->rho) : none},
        {"detail", detail_json(c.detail)},
        {"error_estimate", real(m.error_estimate)},
        {"weight", weight_json(c)},
        {"currents", currents_json(c)}}},
      {"volume",
       {{"above", real(m.volume.above)},
        {"below", real(m.volume.below)},
        {"net", real(m.volume.net)},
        {"absolute", real(m.volume.absolute)}}},
      {"surfaces", surfaces_json(c)},
      {"budget", budget_json(c)},
      {"difference", difference_json(m.difference)},
      {"triangulations", {{"t1", c.t1}, {"t2", c.t2}, {"common", c.common}, {"interface", c.interface}}},
      {"localisation",
       {{"method", to_text(c.options.locate)},
        {"visited_1_in_2", c.visited_1_in_2},
        {"visited_2_in_1", c.visited_2_in_1}}},
      {"uncertainty", uncertainty_json(c)},
      {"border",
       {{"rule", to_text(c.options.border)},
        {"trimmed_area", real(c.trimmed_area)},
        {"trimmed_volume", real(c.trimmed_volume)},
        {"sliver_area", real(c.sliver_area)},
        {"sliver_volume", real(c.sliver_volume)}}},
      {"folds", folds(c)},
      {"outputs", outputs},
      {"warnings", messages(c.warnings)},
      {"timing_s", timing_json(c.timing)}};
  add_changes(report, c);
  // File names may hold any bytes; JSON is UTF-8.
  return report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace isopach
