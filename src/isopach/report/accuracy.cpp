#include "isopach/report/accuracy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "isopach/io/output_file.hpp"
#include "isopach/report/page/alignment_values.hpp"
#include "isopach/report/page/furniture.hpp"
#include "isopach/report/page/page.hpp"
#include "isopach/report/page/verdict_values.hpp"
#include "isopach/report/page/words.hpp"
#include "isopach/report/view/view_page.hpp"
#include "isopach/version.hpp"

namespace isopach {
namespace {

using namespace values;
constexpr Typography plain_signs = Typography::plain, fine = Typography::fine;

const char* to_text(Align align) { return align == Align::none ? "none" : align == Align::rigid ? "rigid" : "scale"; }

double most(const DifferenceStatistics& d) { return std::max(d.max_above, d.max_below); }
double hausdorff(const Accuracy& a) {
  return a.distances.hausdorff ? std::max(a.distances.hausdorff->a_to_b.upper, a.distances.hausdorff->b_to_a.upper)
                               : std::numeric_limits<double>::quiet_NaN();
}

Json input_json(const InputSummary& in, const char* role) {
  Json input = aligned_input(in, role);
  input["bounds"] = {{"min", point(in.bounds.min)}, {"max", point(in.bounds.max)}};
  return input;
}

Json parameters_json(const Accuracy& a) {
  Json out = {{"align", to_text(a.options.align)},
              {"within", a.options.within > 0 ? real(a.options.within) : Json(nullptr)}};
  add_alignment(out, a.options.match, a.options.align != Align::none, a.unit);
  return out;
}

Json alignment_json(const Accuracy& a) {
  Json out = {{"convention", "reference = matrix * reconstruction, row-major, input coordinates"},
              {"matrix", matrix(a.pose)},
              {"scale", real(a.scale)}};
  const bool matched = a.matching.has_value();
  out["iterations"] = matched ? Json(a.matching->iterations) : Json(nullptr);
  out["converged"] = matched ? Json(a.matching->converged) : Json(nullptr);
  out["reason"] = matched ? message(a.matching->reason) : Json(nullptr);
  out["overlap"] = matched ? real(a.matching->overlap) : Json(nullptr);
  out["nominal"] = matched ? Json(a.matching->nominal_fixed) : Json(nullptr);
  out["verdict"] = matched ? verdict_json(a.matching->verdict, a.unit) : Json(nullptr);
  out["rho_before"] = matched ? real(a.matching->before.rho) : Json(nullptr);
  out["weak_directions"] = matched ? messages(a.matching->weak_directions) : Json::array();
  return out;
}

Json differences_json(const Measures& m) {
  const DifferenceStatistics& d = m.difference;
  Json percentiles;
  for (std::size_t k = 0; k < percentile_levels.size(); ++k)
    percentiles[std::to_string(percentile_levels[k])] = real(d.abs_percentiles[k]);
  return {{"bias", real(d.mean)},
          {"median", real(d.median)},
          {"rho", real(m.rho)},
          {"rms", real(d.rms)},
          {"std", real(d.std)},
          {"nmad", real(d.nmad)},
          {"max_above", real(d.max_above)},
          {"max_below", real(d.max_below)},
          {"abs_percentiles", percentiles}};
}

Json points_json(const PointResiduals& p) {
  return {{"count", p.count},   {"bias", real(p.bias)},   {"rms", real(p.rms)},
          {"std", real(p.std)}, {"noise", real(p.noise)}, {"form", real(p.form)}};
}

Json figures_json(const Figures& f) {
  return {{"count", f.count},         {"mean", real(f.mean)}, {"rms", real(f.rms)},
          {"median", real(f.median)}, {"p95", real(f.p95)},   {"max", real(f.max)}};
}

Json space_json(const Accuracy& a) {
  const Distances& d = a.distances;
  const auto bound = [](const HausdorffBound& h) { return Json{{"lower", real(h.lower)}, {"upper", real(h.upper)}}; };
  return {
      {"to_reference", figures_json(d.c2s->b_to_a)},
      {"to_reconstruction", figures_json(d.c2s->a_to_b)},
      {"hausdorff", {{"to_reference", bound(d.hausdorff->b_to_a)}, {"to_reconstruction", bound(d.hausdorff->a_to_b)}}}};
}

Json verdict_json(const std::vector<AccuracyCheck>& checks) {
  Json rows = Json::array();
  bool passed = true;
  for (const AccuracyCheck& c : checks) {
    rows.push_back({{"statistic", c.limit.statistic},
                    {c.limit.least ? "at_least" : "at_most", real(c.limit.limit)},
                    {"value", real(c.value)},
                    {"passed", c.passed}});
    passed = passed && c.passed;
  }
  return {{"passed", checks.empty() ? Json(nullptr) : Json(passed)}, {"checks", rows}};
}

class Page : public ViewPage {
 public:
  Page(const Accuracy& a, const std::string& json, const MapOptions& look)
      : ViewPage(json),
        a_(a),
        look_(look),
        title_(look.title.empty() ? "Accuracy of " + input_name(a.comparison.b) : clean_utf8(look.title)),
        unit_(unit_text(a.unit)),
        height_(unit_text(height_unit(a.comparison))) {}

  std::string write(const std::string& map_png, const ViewWords& words, const MapOptions& look,
                    const Context& context) {
    write(map_png);
    return with_view({{"", &a_.comparison}}, words, look, context);
  }

 private:
  std::string write(const std::string& map_png) {
    open_page(title_);
    head();
    warnings();
    out_ += view_place;
    if (!map_png.empty()) picture(map_png, "Map of reconstruction less reference");
    checks();
    numbers();
    alignment();
    finish_page();
    return out_;
  }

  void head() {
    out_ += "<header>\n";
    sign("", look_.logo.png);
    out_ += "<h1>" + escaped(title_) + "</h1>\n<p class=\"lead\">It lies " + brief_sign("normal.bias") + "\u00a0" +
            height_ + " from the reference on average, RMS " + brief("normal.rms") + "\u00a0" + height_ +
            "; 95\u00a0% of the area agree to within " + brief("normal.abs_percentiles.95") + "\u00a0" + height_ +
            ", and " + percent("completeness.share") + "\u00a0% of the reference is there.</p>\n<p class=\"soft\">" +
            escaped(input_name(a_.comparison.b)) + " against the reference " + escaped(input_name(a_.comparison.a)) +
            ": d = reconstruction − reference. Lengths: " + unit_sentence(a_.unit) + ".</p>\n";
    sign(signature(a_.comparison, look_, " · "), "");
    out_ += "</header>\n";
    out_ += "<div class=\"cards\">\n";
    card(brief_sign("normal.bias"), height_, "bias: mean deviation along the normal");
    card(brief("normal.rms"), height_, "RMS along the normal");
    card(brief("normal.abs_percentiles.95"), height_, "95 % of the area agree to within");
    card(brief("space.hausdorff.to_reference.upper"), unit_, "farthest point from the reference");
    card(percent("completeness.share"), "%", "of the reference's area is there");
    out_ += "</div>\n";
  }

  void checks() {
    const Json& rows = at("verdict.checks");
    if (rows.empty()) return;
    open_table("Verdict: " + std::string(at("verdict.passed").get<bool>() ? "passed" : "not passed"),
               "<th>statistic</th><th class=\"n\">value</th><th class=\"n\">limit</th><th></th>");
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const std::string key = "verdict.checks." + std::to_string(i) + ".";
      const std::string limit = rows[i].contains("at_most") ? "at_most" : "at_least";
      out_ += "<tr><th scope=\"row\">" + escaped(rows[i].at("statistic").get<std::string>()) + "</th><td class=\"n\">" +
              plain(key + "value") + "</td><td class=\"n\">" + (limit == "at_most" ? "≤ " : "≥ ") + plain(key + limit) +
              "</td><td>" + (rows[i].at("passed").get<bool>() ? "passed" : "<strong>not passed</strong>") +
              "</td></tr>\n";
    }
    close_table();
  }

  void numbers() {
    open_table("Surface against surface, along the normal", "<th>name</th><th></th><th>unit</th><th>what it says</th>",
               " class=\"told\"");
    row("bias", with_sign("normal.bias"), height_, "mean by area: the offset that is left after the alignment");
    row("ρ, mean |d|", plain("normal.rho"), height_, "how far apart on average");
    row("RMS", plain("normal.rms"), height_, "root of the mean of squares");
    row("standard deviation", plain("normal.std"), height_, "about the bias");
    row("NMAD", plain("normal.nmad"), height_, "the spread without the outliers");
    for (const int level : percentile_levels)
      row("|d| at " + std::to_string(level) + "\u00a0%", plain("normal.abs_percentiles." + std::to_string(level)),
          height_, std::to_string(level) + "\u00a0% of the area agree to within this");
    row("largest above", plain("normal.max_above"), height_, "");
    row("largest below", plain("normal.max_below"), height_, "");
    close_table();
    open_table("The same along the direction", "<th>name</th><th></th><th>unit</th><th>what it says</th>",
               " class=\"told\"");
    row("bias", with_sign("surface.bias"), height_, "mean of d by area");
    row("ρ, mean |d|", plain("surface.rho"), height_, "how far apart on average");
    row("RMS", plain("surface.rms"), height_, "root of the mean of d²");
    row("|d| at 95\u00a0%", plain("surface.abs_percentiles.95"), height_, "95 % of the area agree to within this");
    row("folds", percent("folds.share"), "%", escaped(fold_sentence(a_.comparison)));
    close_table();
    open_table("Points against the reference surface", "<th>name</th><th></th><th>unit</th><th>what it says</th>",
               " class=\"told\"");
    row("points", whole("points.count"), "", "of the reconstruction, over the reference");
    row("RMS", plain("points.rms"), height_, "");
    row("noise", plain("points.noise"), height_, "what neighbouring points do not share");
    row("form", plain("points.form"), height_, "what they share, about the bias: deviations of the shape");
    close_table();
    open_table("In space, and what is there", "<th>name</th><th></th><th>unit</th><th>what it says</th>",
               " class=\"told\"");
    row("to the reference, RMS", plain("space.to_reference.rms"), unit_, "points to the closest place of the surface");
    row("to the reference, 95\u00a0%", plain("space.to_reference.p95"), unit_, "likewise");
    row("Hausdorff, accuracy", plain("space.hausdorff.to_reference.upper"), unit_,
        "no point of the reconstruction's surface is farther from the reference");
    row("Hausdorff, completeness", plain("space.hausdorff.to_reconstruction.upper"), unit_,
        "no point of the reference's surface is farther from the reconstruction");
    row("completeness", percent("completeness.share"), "%", "of the reference's area lies under the reconstruction");
    if (at("completeness.within").is_number())
      row("… within tolerance", percent("completeness.within"), "%",
          "and agrees to within " + plain("parameters.within") + "\u00a0" + height_);
    close_table();
  }

  void alignment() {
    open_table("Alignment", "", " class=\"pairs\"");
    const auto pair = [&](const std::string& name, const std::string& what) {
      out_ += "<tr><th scope=\"row\">" + name + "</th><td class=\"wrap\">" + what + "</td></tr>\n";
    };
    std::string rows;
    for (const Json& r : at("alignment.matrix")) rows += escaped(r.dump()) + "<br>";
    pair("pose, row-major", "<code>" + rows + "</code>");
    pair("scale", datum("alignment.scale", number(value("alignment.scale"), fine, 8)));
    if (at("alignment.overlap").is_number())
      pair("fitted", percent("alignment.overlap") + "\u00a0% of the common area; the rest differs more than noise");
    if (at("alignment.reason").is_string()) pair("search", escaped(at("alignment.reason").get<std::string>()));
    close_table();
  }

  const Accuracy& a_;
  const MapOptions& look_;
  std::string title_, unit_, height_;
};

}  // namespace

const std::vector<AccuracyStatistic>& accuracy_statistics() {
  static const std::vector<AccuracyStatistic> all{
      {"bias", "|mean d|", [](const Accuracy& a) { return std::fabs(a.normal.difference.mean); }},
      {"rho", "mean |d|", [](const Accuracy& a) { return a.normal.rho; }},
      {"rms", "of d", [](const Accuracy& a) { return a.normal.difference.rms; }},
      {"std", "of d", [](const Accuracy& a) { return a.normal.difference.std; }},
      {"p95", "of |d|", [](const Accuracy& a) { return a.normal.difference.abs_percentiles[2]; }},
      {"max", "of |d|", [](const Accuracy& a) { return most(a.normal.difference); }},
      {"noise", "of the points", [](const Accuracy& a) { return a.points.noise; }},
      {"hausdorff", "both ways", hausdorff},
      {"scale", "|scale - 1|", [](const Accuracy& a) { return std::fabs(a.scale - 1); }},
      {"completeness", "share", [](const Accuracy& a) { return a.completeness.share; }},
      {"within", "share",
       [](const Accuracy& a) { return a.completeness.within.value_or(std::numeric_limits<double>::quiet_NaN()); }}};
  return all;
}

std::vector<AccuracyCheck> verdict(const Accuracy& a, const std::vector<AccuracyLimit>& limits) {
  std::vector<AccuracyCheck> checks;
  for (const AccuracyLimit& limit : limits)
    for (const AccuracyStatistic& s : accuracy_statistics())
      if (limit.statistic == s.name) {
        const double v = s.of(a);
        checks.push_back({limit, v, limit.least ? v >= limit.limit : v <= limit.limit});
      }
  return checks;
}

std::string failed(const Accuracy& a, const std::vector<AccuracyCheck>& checks) {
  std::string all;
  for (const AccuracyCheck& c : checks) {
    if (c.passed) continue;
    const bool share =
        c.limit.statistic == "completeness" || c.limit.statistic == "within" || c.limit.statistic == "scale";
    const std::string unit = share ? "" : " " + unit_text(height_unit(a.comparison));
    all +=
        fmt::format("{}{} is {}{}, {} {}{}", all.empty() ? "" : "; ", c.limit.statistic, number(c.value, plain_signs),
                    unit, c.limit.least ? "below" : "above", number(c.limit.limit, plain_signs), unit);
  }
  return all;
}

std::string accuracy_json(const Accuracy& a, const std::vector<AccuracyCheck>& checks,
                          const std::vector<std::string>& outputs) {
  const Comparison& c = a.comparison;
  const Json report = {{"schema", "isopach.accuracy/1"},
                       {"tool", {{"name", tool_name}, {"version", version}}},
                       {"inputs", Json::array({input_json(c.b, "reconstruction"), input_json(c.a, "reference")})},
                       {"parameters", parameters_json(a)},
                       {"alignment", alignment_json(a)},
                       {"normal", differences_json(a.normal)},
                       {"surface", differences_json(c.measures)},
                       {"folds", folds(c)},
                       {"points", points_json(a.points)},
                       {"space", space_json(a)},
                       {"completeness",
                        {{"reference_area", real(a.completeness.reference_area)},
                         {"area", real(c.domain_area)},
                         {"share", real(a.completeness.share)},
                         {"within", a.completeness.within ? real(*a.completeness.within) : Json(nullptr)}}},
                       {"verdict", verdict_json(checks)},
                       {"outputs", outputs},
                       {"warnings", messages(a.warnings)},
                       {"timing_s", timing(a.timing)}};
  return report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string accuracy_text(const Accuracy& a, const std::vector<AccuracyCheck>& checks) {
  const Comparison& c = a.comparison;
  const DifferenceStatistics& d = a.normal.difference;
  const std::string unit = unit_text(a.unit), height = unit_text(height_unit(c));
  const auto n = [](double v) { return number(v, plain_signs, 4); };
  std::string out = fmt::format("{} against {}: bias {} {}, rms {} {} along the normal\n", input_name(c.b),
                                input_name(c.a), signed_number(d.mean, plain_signs), height, n(d.rms), height);
  line(out, "surface",
       fmt::format("mean |d| (rho) {} {}, 95 % of the area within {} {}, largest {} {}", n(a.normal.rho), height,
                   n(d.abs_percentiles[2]), height, n(most(d)), height));
  line(out, "along direction",
       fmt::format("bias {} {}, rms {} {}, largest {} {}", signed_number(c.measures.difference.mean, plain_signs),
                   height, n(c.measures.difference.rms), height, n(most(c.measures.difference)), height));
  if (c.folds.area > 0) line(out, "folds", fold_sentence(c));
  line(out, "points",
       fmt::format("{}: noise {} {}, form {} {}", count(a.points.count, plain_signs), n(a.points.noise), height,
                   n(a.points.form), height));
  line(out, "in space",
       fmt::format("to the closest surface: rms {} {}, 95 % {} {}", n(a.distances.c2s->b_to_a.rms), unit,
                   n(a.distances.c2s->b_to_a.p95), unit));
  line(out, "hausdorff",
       fmt::format("{} {} to the reference, {} {} from it", n(a.distances.hausdorff->b_to_a.upper), unit,
                   n(a.distances.hausdorff->a_to_b.upper), unit));
  line(out, "completeness",
       fmt::format("{} % of the reference's area{}", fixed_number(100 * a.completeness.share, 1, plain_signs),
                   a.completeness.within
                       ? fmt::format(", {} % within {} {}", fixed_number(100 * *a.completeness.within, 1, plain_signs),
                                     n(a.options.within), height)
                       : ""));
  line(out, "alignment",
       a.matching ? fmt::format("{}, scale {}: {}", to_text(a.options.align), number(a.scale, plain_signs, 8),
                                message_text(a.matching->reason))
                  : std::string("none"));
  for (const AccuracyCheck& check : checks)
    line(out, check.passed ? "passed" : "NOT passed",
         fmt::format("{} {} ({} {})", check.limit.statistic, n(check.value), check.limit.least ? "at least" : "at most",
                     n(check.limit.limit)));
  if (a.unit == "unknown" || a.unit.empty()) line(out, "units", unit_sentence(a.unit));
  line(out, "time", fmt::format("{:.2f} s", a.timing.total));
  for (const std::string& w : a.warnings) out += "warning: " + message_text(w) + "\n";
  return out;
}

void write_accuracy_map(const std::string& path, const Accuracy& a, const MapOptions& look, const Context& context) {
  MapOptions options = look;
  const Comparison& c = a.comparison;
  if (options.title.empty()) options.title = input_name(c.b) + " − " + input_name(c.a);
  const DifferenceStatistics& d = a.normal.difference;
  const std::string unit = "\u00a0" + unit_text(height_unit(c));
  options.words.headline = "bias " + signed_number(d.mean, fine) + unit + "   ·   RMS " + number(d.rms, fine) + unit +
                           "   ·   95\u00a0% within " + number(d.abs_percentiles[2], fine) + unit;
  options.words.where = fixed_number(100 * a.completeness.share, 1, fine) + " % of the area of the reference";
  options.words.above = "above the reference", options.words.below = "below the reference";
  options.words.zero = "agrees";
  options.words.note = "d = reconstruction − reference";
  write_map(path, c, options, context);
}

void write_accuracy_html(const std::string& path, const Accuracy& a, const std::string& map_png,
                         const std::string& json, const MapOptions& look, const Context& context) {
  context.check();
  const ViewWords words{"reference", "reconstruction", "above the reference", "below the reference", true, ""};
  write_text_atomically(path, Page(a, json, look).write(map_png, words, look, context));
}

}  // namespace isopach
