#include "isopach/report/scanners.hpp"

#include <fmt/format.h>

#include <cmath>

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
constexpr Typography ascii = Typography::plain, fine = Typography::fine;

Json input_json(const InputSummary& in, const char* role) {
  return {{"role", role}, {"path", in.path}, {"points", in.points}, {"nodes", in.nodes}, {"unit", in.unit}};
}

Json scanner_json(const Scanner& s, const char* role, const std::string& unit) {
  return {{"role", role},
          {"pose", {{"matrix", matrix(s.pose)}}},
          {"converged", s.converged},
          {"verdict", verdict_json(s.verdict, unit)},
          {"noise", real(s.spot.noise)},
          {"spot", s.spot.width > 0 ? real(s.spot.width) : Json(nullptr)},
          {"bias", real(s.residuals.bias)},
          {"form", real(s.residuals.form)},
          {"rms", real(s.residuals.rms)},
          {"rho", real(s.rho)},
          {"rho_dv", real(s.rho_dv)},
          {"coverage", real(s.coverage)},
          {"spacing", real(s.spacing)},
          {"resolved", s.resolved > 0 ? real(s.resolved) : Json(nullptr)}};
}

/// Who sees the detail of one size.
std::string seen_by(const DetailScale& d) { return d.seen[0] ? d.seen[1] ? "both" : "A" : d.seen[1] ? "B" : "none"; }

Json detail_json(const Scanners& s) {
  Json rows = Json::array();
  for (const DetailScale& d : s.detail)
    rows.push_back({{"length", real(d.length)},
                    {"reference", real(d.reference)},
                    {"gain", Json::array({real(d.gain[0]), real(d.gain[1])})},
                    {"error", Json::array({real(d.error[0]), real(d.error[1])})},
                    {"seen_by", seen_by(d)},
                    {"stretches", d.stretches}});
  return rows;
}

std::string words_of(const Scanners& s) {
  const auto finer = s.scan[0].resolved, other = s.scan[1].resolved;
  if (finer == 0 && other == 0) return "neither resolves any detail of the reference";
  if (finer == other) return "both resolve the same detail";
  const bool a = other == 0 || (finer > 0 && finer < other);
  return std::string(a ? "A" : "B") + " resolves finer detail than " + (a ? "B" : "A");
}

class Page : public ViewPage {
 public:
  Page(const Scanners& s, const std::string& json, const MapOptions& look)
      : ViewPage(json),
        s_(s),
        look_(look),
        title_(look.title.empty() ? "Scanners of " + input_name(s.reference) : clean_utf8(look.title)),
        unit_(unit_text(s.unit)) {}

  std::string write(const std::string& map_png, const ViewWords& words, const MapOptions& look,
                    const Context& context) {
    write(map_png);
    return with_view({{"", &s_.comparison}}, words, look, context);
  }

 private:
  std::string write(const std::string& map_png) {
    open_page(title_);
    out_ += "<header>\n";
    sign("", look_.logo.png);
    out_ += "<h1>" + escaped(title_) + "</h1>\n<p class=\"lead\">" + escaped(words_of(s_)) + "; A has a noise of " +
            brief("scanners.0.noise") + "\u00a0" + unit_ + ", B of " + brief("scanners.1.noise") + "\u00a0" + unit_ +
            ".</p>\n<p class=\"soft\">A: " + escaped(input_name(s_.scan[0].input)) +
            ", B: " + escaped(input_name(s_.scan[1].input)) + ", both against " + escaped(input_name(s_.reference)) +
            ". Lengths: " + unit_sentence(s_.unit) + ".</p>\n";
    sign(signature(s_.comparison, look_, " · "), "");
    out_ += "</header>\n<div class=\"cards\">\n";
    card(brief("between.rho"), unit_, "ρ: mean |B − A|");
    card(brief("between.rho_dv"), unit_, "ρ<sub>dV</sub>: at the detail both hold");
    card(datum("between.bias", signed_number(value("between.bias"), fine, 3)), unit_, "bias of B against A");
    out_ += "</div>\n";
    warnings();
    out_ += view_place;
    if (!map_png.empty()) picture(map_png, "Map of B less A");
    each();
    detail();
    finish_page();
    return out_;
  }

  [[nodiscard]] std::string brief(const std::string& key) const { return datum(key, number(value(key), fine, 3)); }

  void each() {
    open_table("Each against the reference",
               "<th></th><th class=\"n\">A</th><th class=\"n\">B</th><th>unit</th><th>what it says</th>");
    const auto shown = [&](const std::string& key) {
      return key.ends_with(".bias") ? datum(key, signed_number(value(key), fine, 3)) : brief(key);
    };
    const auto both = [&](const std::string& name, const std::string& key, const std::string& unit,
                          const std::string& why) {
      out_ += "<tr><th scope=\"row\">" + name + "</th>";
      for (const char* k : {"0", "1"})
        out_ += "<td class=\"n\">" + shown("scanners." + std::string(k) + "." + key) + "</td>";
      out_ += "<td class=\"u\">" + unit + "</td><td class=\"why\">" + why + "</td></tr>\n";
    };
    both("noise", "noise", unit_, "what neighbouring points do not share, one standard deviation");
    both("bias", "bias", unit_, "mean height of its points above the reference");
    both("form", "form", unit_, "what neighbouring points share, about the bias");
    both("ρ<sub>V</sub>", "rho", unit_, "mean |d| against the reference");
    both("ρ<sub>dV</sub>", "rho_dv", unit_, "with the detail that only the finer scan holds averaged out");
    both("spacing", "spacing", unit_, "side of the square a point stands for");
    both("spot", "spot", unit_, "width of the disc it averages over, found by the least noise");
    both("resolved", "resolved", unit_, "shortest wavelength of the reference's detail that it shows");
    close_table();
  }

  void detail() {
    open_table("Who sees what",
               "<th class=\"n\">wavelength, " + unit_ + "</th><th class=\"n\">detail of the reference, " + unit_ +
                   "</th><th class=\"n\">A shows, %</th><th class=\"n\">B shows, %</th><th class=\"n\">error of A, " +
                   unit_ + "</th><th class=\"n\">error of B, " + unit_ + "</th><th>seen by</th>");
    for (std::size_t i = 0; i < s_.detail.size(); ++i) {
      const std::string key = "detail." + std::to_string(i) + ".";
      out_ += "<tr>";
      for (const std::string& cell : {brief(key + "length"), brief(key + "reference"), percent(key + "gain.0"),
                                      percent(key + "gain.1"), brief(key + "error.0"), brief(key + "error.1")})
        out_ += "<td class=\"n\">" + cell + "</td>";
      out_ += "<td>" + seen_by(s_.detail[i]) + "</td></tr>\n";
    }
    close_table();
    out_ +=
        "<p class=\"soft\">Detail: the means over stretches of nodes of the reference, less the quadratic surface "
        "through 16 neighbours. A scan sees it where less than half of its energy is lost or wrong, and never where "
        "the "
        "wavelength is less than two spacings of its points.</p>\n";
  }

  const Scanners& s_;
  const MapOptions& look_;
  std::string title_, unit_;
};

}  // namespace

std::string scanners_json(const Scanners& s, const std::vector<std::string>& outputs) {
  Json parameters = {{"align", s.options.align}, {"reference_sigma", real(s.options.reference_sigma)}};
  add_alignment(parameters, s.options.match, s.options.align, s.unit);
  const Json report = {
      {"schema", "isopach.scanners/1"},
      {"tool", {{"name", tool_name}, {"version", version}}},
      {"inputs", Json::array({input_json(s.scan[0].input, "A"), input_json(s.scan[1].input, "B"),
                              input_json(s.reference, "reference")})},
      {"parameters", parameters},
      {"scanners", Json::array({scanner_json(s.scan[0], "A", s.unit), scanner_json(s.scan[1], "B", s.unit)})},
      {"between",
       {{"rho", real(s.rho)},
        {"rho_dv", real(s.rho_dv)},
        {"bias", real(s.bias)},
        {"coarser", s.coarser},
        {"coverage", real(s.comparison.coverage)}}},
      {"detail", detail_json(s)},
      {"outputs", outputs},
      {"warnings", messages(s.warnings)},
      {"timing_s", timing(s.timing)}};
  return report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string scanners_text(const Scanners& s) {
  const std::string unit = unit_text(s.unit);
  const auto n = [](double v) { return number(v, ascii, 3); };
  std::string out = fmt::format("{} (A), {} (B) against {}: {}\n", input_name(s.scan[0].input),
                                input_name(s.scan[1].input), input_name(s.reference), words_of(s));
  for (std::size_t k = 0; k < 2; ++k) {
    const Scanner& scan = s.scan[k];
    line(out, k == 0 ? "A" : "B",
         fmt::format("noise {} {}, bias {} {}, form {} {}, rho_V {} {}, rho_dV {} {}", n(scan.spot.noise), unit,
                     signed_number(scan.residuals.bias, ascii, 3), unit, n(scan.residuals.form), unit, n(scan.rho),
                     unit, n(scan.rho_dv), unit));
    line(out, "",
         fmt::format("{} points, {} {} apart{}; resolves {}", count(scan.input.points, ascii), n(scan.spacing), unit,
                     scan.spot.width > 0
                         ? fmt::format(", each the mean over a spot {} {} wide", n(scan.spot.width), unit)
                         : std::string(),
                     scan.resolved > 0 ? fmt::format("wavelengths down to {} {}", n(scan.resolved), unit)
                                       : std::string("no detail of the reference")));
  }
  line(out, "B - A",
       fmt::format("rho_V {} {}, rho_dV {} {}, bias {} {}", n(s.rho), unit, n(s.rho_dv), unit,
                   signed_number(s.bias, ascii, 3), unit));
  out += fmt::format("  {:>16}{:>14}{:>10}{:>10}{:>14}{:>14}  {}\n", "wavelength", "reference", "A shows", "B shows",
                     "error of A", "error of B", "seen by");
  for (const DetailScale& d : s.detail)
    out += fmt::format("  {:>16}{:>14}{:>8} %{:>8} %{:>14}{:>14}  {}\n", n(d.length), n(d.reference),
                       fixed_number(100 * d.gain[0], 0, ascii), fixed_number(100 * d.gain[1], 0, ascii), n(d.error[0]),
                       n(d.error[1]), seen_by(d));
  if (s.unit == "unknown" || s.unit.empty()) line(out, "units", unit_sentence(s.unit));
  line(out, "time", fmt::format("{:.2f} s", s.timing.total));
  for (const std::string& w : s.warnings) out += "warning: " + message_text(w) + "\n";
  return out;
}

void write_scanners_map(const std::string& path, const Scanners& s, const MapOptions& look, const Context& context) {
  MapOptions options = look;
  if (options.title.empty()) options.title = input_name(s.scan[1].input) + " − " + input_name(s.scan[0].input);
  options.words.above = "B above A", options.words.below = "B below A";
  write_map(path, s.comparison, options, context);
}

void write_scanners_html(const std::string& path, const Scanners& s, const std::string& map_png,
                         const std::string& json, const MapOptions& look, const Context& context) {
  context.check();
  write_text_atomically(path, Page(s, json, look).write(map_png, {}, look, context));
}

}  // namespace isopach
