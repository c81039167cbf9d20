// report.html: one page that opens from disk, without a network; complete without its one script. Every number is taken
// from the text of result.json, shown rounded, with the exact value as its title and its key as data-key.
#include <algorithm>
#include <cctype>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "isopach/io/output_file.hpp"
#include "isopach/report/changes.hpp"
#include "isopach/report/draw/map.hpp"
#include "isopach/report/draw/palette.hpp"
#include "isopach/report/page/detail_told.hpp"
#include "isopach/report/page/furniture.hpp"
#include "isopach/report/page/matched.hpp"
#include "isopach/report/page/moved.hpp"
#include "isopach/report/page/page.hpp"
#include "isopach/report/page/uncertainty.hpp"
#include "isopach/report/page/words.hpp"
#include "isopach/report/report.hpp"
#include "isopach/report/view/view_page.hpp"

namespace isopach {
namespace {

using Json = nlohmann::ordered_json;
constexpr Typography fine = Typography::fine;

constexpr const char* told_columns = "<th>name</th><th class=\"n\"></th><th class=\"u\">unit</th><th>what it says</th>";

class Page : public ViewPage {
 public:
  Page(const Comparison& c, const std::string& json, const MapOptions& look, const Matching* matched)
      : ViewPage(json), c_(c), look_(look), matched_(matched) {}

  std::string write(const std::string& map_png, const std::optional<Truth>& truth) {
    const std::string title =
        look_.title.empty() ? input_name(c_.a) + " → " + input_name(c_.b) : clean_utf8(look_.title);
    open_page(title);
    head();
    warnings();
    map(map_png);
    if (truth) truth_table(*truth);
    numbers();
    uncertainty();
    budget();
    changes();
    histogram();
    inputs();
    parameters();
    working();
    raw();
    close_page();
    return out_;
  }
  /// The same with the surface itself.
  [[nodiscard]] std::string write_with_view(const PageOptions& options, const Context& context) {
    write(options.map_png, options.truth);
    ViewWords words;
    if (look_.words.drawn.empty()) words.command = "isopach compare " + quoted(c_.a.path) + " " + quoted(c_.b.path);
    return with_view({{"", &c_}}, words, look_, context);
  }

 private:
  [[nodiscard]] std::string unit(int power) const { return measured_unit(c_, power); }
  // With no more digits than a standard deviation carries, where one is known.
  [[nodiscard]] std::string plain(const std::string& key) const { return datum(key, told(c_, key, value(key), fine)); }
  [[nodiscard]] std::string with_sign(const std::string& key) const {
    return datum(key, told(c_, key, value(key), fine, true));
  }
  [[nodiscard]] std::string quantity(const std::string& key, double magnitude, int power) const {
    return datum(key, told(c_, key, magnitude, fine)) + "\u00a0" + unit(power);
  }
  [[nodiscard]] Quantity quantities() const {
    return [this](const std::string& key, double magnitude, int power) { return quantity(key, magnitude, power); };
  }

  // --- sections, in the order of the page ---------------------------------------------------------------------------

  [[nodiscard]] static std::string as_sentence(std::string clause) {
    clause[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(clause[0])));
    return clause + ".";
  }

  void head() {
    const std::string names = escaped(input_name(c_.a)) + " <span>→</span> " + escaped(input_name(c_.b));
    out_ += "<header>\n";
    sign("", look_.logo.png);
    out_ += "<h1>" + (look_.title.empty() ? names : escaped(look_.title)) + "</h1>\n";
    out_ += "<p class=\"lead\">" + headline(c_, quantities()) + "</p>\n";
    if (matched_ != nullptr) {
      out_ += "<p class=\"lead\">" + escaped(moved_sentence(*matched_, "B", fine)) + ".</p>\n";
      if (matched_->verdict)
        out_ += "<p>The pose is <strong>" +
                escaped(message_text(sentence(*matched_->verdict, unit_text(matched_->unit)))) + "</strong>.</p>\n";
    }
    if (c_.uncertainty.sigma)
      out_ += "<p class=\"lead\">" + as_sentence(uncertainty_sentences(c_, quantities()).front()) + "</p>\n";
    out_ += "<p class=\"soft\">A is the reference (before), B is compared with it (after): " + std::string(sign_rule) +
            (c_.unit == "unknown" ? ". Lengths: " : ". Lengths in ") + unit_sentence(c_.unit) +
            (height_unit(c_) == c_.unit ? "" : ", heights in " + unit_sentence(height_unit(c_))) +
            "; statistics are by area.</p>\n";
    sign(signature(c_, look_, " · "), "");
    out_ += "</header>\n<div class=\"cards\">\n";
    card(with_sign("volume.net"), unit(3), "net = gained − lost");
    card(plain("volume.above"), unit(3), "gained (B above A)");
    card(plain("volume.below"), unit(3), "lost (B below A)");
    if (c_.options.measure == MeasureKind::dV)
      card(plain("measure.rho_dv"), unit(1), "at shared detail (ρ<sub>dV</sub>)");
    if (c_.options.measure == MeasureKind::currents)
      card(plain("measure.currents.distance"), unit(2), "apart as currents");
    card(plain("measure.rho"), unit(1), "mean |d| (ρ)");
    card(percent("domain.coverage"), "%", "of the area of both scans compared");
    out_ += "</div>\n";
  }

  /// As one word of a shell.
  [[nodiscard]] static std::string quoted(const std::string& word) {
    std::string out = "'";
    for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return out + "'";
  }

  void map(const std::string& png) {
    out_ += view_place;
    if (!png.empty()) picture(png, "Map of the difference B − A in colours centred on zero");
    if (!look_.words.drawn.empty())
      out_ += "<p class=\"soft\">Map and view are " + escaped(look_.words.drawn) +
              "; all numbers are of the cells themselves.</p>\n";
  }

  void truth_table(const Truth& truth) {
    open_table(
        "Against the known truth",
        "<th></th><th class=\"n\">truth</th><th>unit</th><th class=\"n\">measured</th><th class=\"n\">difference</th>"
        "<th class=\"n\">relative</th>");
    const auto line = [&](const std::string& name, double known, const std::string& key, int power) {
      const double measured = value(key), difference = measured - known;
      const std::string relative =
          known == 0 ? "" : signed_number(100 * difference / std::fabs(known), fine, 2) + "\u00a0%";
      out_ += "<tr><th scope=\"row\">" + name + "</th>";
      out_ += fmt::format("<td class=\"n\"><data data-truth value=\"{0}\" title=\"{0}\">{1}</data></td>",
                          Json(known).dump(), number(known, fine, 6));
      out_ += "<td class=\"u\">" + unit(power) + "</td><td class=\"n\">" + datum(key, number(measured, fine, 6)) +
              "</td><td class=\"n\">" + signed_number(difference, fine, 3) + "</td><td class=\"n\">" + relative +
              "</td></tr>\n";
    };
    line("gained", truth.above, "volume.above", 3);
    if (c_.noise_floor) line("gained, without the noise floor", truth.above, "uncertainty.debiased.above", 3);
    line("lost", truth.below, "volume.below", 3);
    if (c_.noise_floor) line("lost, without the noise floor", truth.below, "uncertainty.debiased.below", 3);
    line("net", truth.net, "volume.net", 3);
    line("area", truth.area, "domain.area", 2);
    close_table();
    out_ += "<p class=\"soft\">The scene is simulated, so the true volumes are known" +
            (truth.error > 0 ? " to within " + number(truth.error, fine, 2) + "\u00a0" + unit(3) : " in closed form") +
            ". Of the measured volumes: " + noise_note + ".";
    if (!truth.parts.empty()) {
      out_ += " Features of the scene:";
      std::string separator = " ";
      for (const auto& [name, volume] : truth.parts) {
        std::string words = name;
        std::replace(words.begin(), words.end(), '_', ' ');
        out_ += separator + escaped(words) + " " + number(volume, fine) + "\u00a0" + unit(3);
        separator = ", ";
      }
      out_ += ".";
    }
    out_ += "</p>\n";
  }

  void currents() {
    row("apart as currents", plain("measure.currents.distance"), unit(2),
        "√ρ of equation (5): the norm of the difference of the two surfaces, each the sum of its triangles’ areas and "
        "directions");
    row("width σ", plain("measure.currents.sigma"), unit(1), "of the kernel: detail much smaller than it is not seen");
    row("norm of A", plain("measure.currents.norm_a"), unit(2), "likewise of A alone");
    row("norm of B", plain("measure.currents.norm_b"), unit(2), "likewise of B alone");
    row("apart, relative", percent("measure.currents.relative"), "%",
        "0: the same; 100: nothing in common; of the root of the norms’ squares added up");
  }

  void numbers() {
    open_table("The numbers", told_columns, " class=\"told\"");
    row("gained (above)", plain("volume.above"), unit(3), "volume between the surfaces where B lies above A");
    row("lost (below)", plain("volume.below"), unit(3), "volume between the surfaces where B lies below A");
    row("net", with_sign("volume.net"), unit(3), "gained − lost; gains and losses cancel in it");
    row("gross (absolute)", plain("volume.absolute"), unit(3), "gained + lost; nothing cancels in it");
    row("ρ, mean |d|", plain("measure.rho"), unit(1), "gross volume ÷ area: how far apart the surfaces are on average");
    if (tells_detail(c_))
      row("ρ<sub>dV</sub>", plain("measure.rho_dv"), unit(1),
          "the same with the detail only the finer scan holds averaged out");
    if (at("measure.currents").is_object()) currents();
    if (at("measure.weight").is_object()) {
      const std::string by = "with the weight “" + escaped(clean_utf8(to_text(c_.options.weight))) + "”";
      row("ρ, weighted", plain("measure.weight.rho"), unit(1), "weighted gross volume ÷ area, " + by);
      row("gained, weighted", plain("measure.weight.above"), unit(3), "∫ d μ where B lies above A, " + by);
      row("lost, weighted", plain("measure.weight.below"), unit(3), "likewise where B lies below A");
      row("net, weighted", with_sign("measure.weight.net"), unit(3), "the first less the second");
      row("∫ of the weight", plain("measure.weight.integral"), unit(2), "weighted net ÷ this: the weighted mean of d");
      if (is_seen(value("measure.weight.error_estimate"), value("measure.weight.rho")))
        row("error of ρ, weighted", plain("measure.weight.error_estimate"), unit(1), "of the integration alone");
    }
    row("mean d", with_sign("difference.mean"), unit(1), "net volume ÷ area: the offset of B from A (bias)");
    row("median d", with_sign("difference.median"), unit(1), "half of the area has a smaller d");
    row("RMS", plain("difference.rms"), unit(1), "root of the mean of d²; large differences weigh more");
    row("standard deviation", plain("difference.std"), unit(1), "spread of d about its mean");
    row("NMAD", plain("difference.nmad"), unit(1), "1.4826 × median |d − median d|: the spread without the outliers");
    for (const Percentile& p : all_percentiles(c_.measures.difference)) {
      const std::string level = fmt::format("{}", p.level);
      row("|d| at " + level + "\u00a0%", plain("difference.abs_percentiles." + level), unit(1),
          level + "\u00a0% of the area differs by no more than this");
    }
    row("largest above", plain("difference.max_above"), unit(1), "the highest B rises over A");
    row("largest below", plain("difference.max_below"), unit(1), "the deepest B falls under A");
    row("area compared", plain("domain.area"), unit(2), "where both surfaces are known, seen along the direction");
    row("area of both", plain("domain.area_union"), unit(2), "covered by at least one of the scans");
    row("coverage", percent("domain.coverage"), "%", "area compared ÷ area of both");
    if (is_seen(value("measure.error_estimate"), value("measure.rho")))
      row("error of the integral", plain("measure.error_estimate"), unit(1),
          "of ρ, by the integration alone. Noise of the scans is not in it");
    if (at("surfaces").is_object()) {
      row("gained, exact overlay", plain("surfaces.overlay.above"), unit(3),
          "the same between the two triangulations themselves, not over the common one");
      row("lost, exact overlay", plain("surfaces.overlay.below"), unit(3), "likewise");
      row("net, exact overlay", with_sign("surfaces.overlay.net"), unit(3), "likewise");
      row("gross, overlay − common", with_sign("surfaces.overlay_minus_common.absolute"), unit(3),
          "how much the choice of triangles alone matters");
    }
    close_table();
  }

  void uncertainty() {
    const auto sentences = uncertainty_sentences(c_, quantities());
    if (!c_.uncertainty.sigma && !c_.uncertainty.detected)
      out_ += "<p class=\"soft\">No error of the scanners was given, so none is claimed here.</p>\n";
    if (sentences.empty()) return;
    open_table("How sure the volumes are", told_columns, " class=\"told\"");
    if (c_.uncertainty.sigma) {
      row("net, from", with_sign("uncertainty.interval_net.0"), unit(3),
          fmt::format("lower end of its interval at {:.6g}\u00a0%", 100 * c_.options.uncertainty.confidence));
      row("net, to", with_sign("uncertainty.interval_net.1"), unit(3), "upper end");
      row("σ of net", plain("uncertainty.sigma_net"), unit(3),
          "standard deviation under the model “" + escaped(at("uncertainty.model").get<std::string>()) + "”");
      if (c_.uncertainty.sigma_net_registration)
        row("σ of net, by the registration", plain("uncertainty.sigma_net_registration"), unit(3),
            "the part of it that does not shrink with more points");
      row("σ of gained", plain("uncertainty.sigma_above"), unit(3), "to first order");
      row("σ of lost", plain("uncertainty.sigma_below"), unit(3), "to first order");
    }
    if (c_.uncertainty.detected) {
      row("level of detection", plain("uncertainty.lod"), unit(1),
          "differences up to it may be noise (grey on the map)");
      row("significant area", percent("uncertainty.significant_area"), "%", "of the area differs by more");
      row("gained there", plain("uncertainty.thresholded.above"), unit(3), "of the gain, the part that is significant");
      row("lost there", plain("uncertainty.thresholded.below"), unit(3), "of the loss, likewise");
    }
    if (c_.noise_floor) {
      row("noise floor, gained", plain("uncertainty.noise_floor.above"), unit(3),
          "what two scans of an unchanged surface would show, by the roughness and noise of these");
      row("noise floor, lost", plain("uncertainty.noise_floor.below"), unit(3), "likewise");
      row("noise floor, ρ", plain("uncertainty.noise_floor.rho"), unit(1), "likewise");
      row("gross, debiased", plain("uncertainty.debiased.absolute"), unit(3),
          "the gross volume without what roughness and noise add to it");
      row("ρ, debiased", plain("uncertainty.debiased.rho"), unit(1), "that ÷ area");
    }
    close_table();
    // The first one, of the net, stands at the top of the page.
    for (std::size_t i = c_.uncertainty.sigma ? 1 : 0; i < sentences.size(); ++i)
      out_ += "<p>" + as_sentence(sentences[i]) + "</p>\n";
  }

  void budget() {
    const std::size_t rows = at("budget").size();
    if (rows == 0) return;
    open_table("By polygon", "<th>polygon</th><th class=\"n\">gained, " + unit(3) + "</th><th class=\"n\">lost, " +
                                 unit(3) + "</th><th class=\"n\">net, " + unit(3) + "</th><th class=\"n\">area, " +
                                 unit(2) + "</th><th class=\"n\">mean d, " + unit(1) + "</th><th class=\"n\">ρ, " +
                                 unit(1) + "</th><th class=\"n\">measured, %</th>");
    for (std::size_t i = 0; i < rows; ++i) {
      const std::string row = "budget." + std::to_string(i) + ".";
      out_ += "<tr><th scope=\"row\">" + escaped(at(row + "name").get<std::string>()) + "</th>";
      for (const std::string& cell : {plain(row + "above"), plain(row + "below"), with_sign(row + "net"),
                                      plain(row + "area"), at(row + "mean").is_null() ? "–" : with_sign(row + "mean"),
                                      at(row + "rho").is_null() ? "–" : plain(row + "rho"), percent(row + "coverage")})
        out_ += "<td class=\"n\">" + cell + "</td>";
      out_ += "</tr>\n";
    }
    close_table();
    out_ +=
        "<p class=\"soft\">Each polygon on its own, over its part of the area compared; “measured” is that part as "
        "a share of the polygon. Polygons that overlap count the overlap each.</p>\n";
  }

  void changes() {
    if (!c_.changes) return;
    constexpr std::size_t most_rows = 100;
    const std::size_t rows = at("changes").size();
    const bool has_sigma = rows > 0 && !at("changes.0.sigma_net").is_null();
    const std::string sentence = "<p>" + escaped(as_sentence(change_sentence(c_))) + "</p>\n";
    if (rows == 0) {
      out_ += "<h2>Changes as objects</h2>\n" + sentence;
      return;
    }
    const auto column = [&](const std::string& name, int power) {
      return "<th class=\"n\">" + name + (power > 0 ? ", " + unit(power) : "") + "</th>";
    };
    open_table("Changes as objects", "<th>object</th>" + column("net", 3) +
                                         (has_sigma ? column("σ", 3) + column("net ÷ σ", 0) : "") + column("area", 2) +
                                         column("mean d", 1) + column("largest d", 1) + column("x of it", 0) +
                                         column("y of it", 0) + column("points of A", 0) + column("of B", 0));
    for (std::size_t i = 0; i < std::min(rows, most_rows); ++i)
      change_row("changes." + std::to_string(i) + ".", has_sigma);
    close_table();
    if (rows > most_rows)
      out_ += "<p class=\"soft\">And " + count(rows - most_rows, fine) + " more in changes.csv.</p>\n";
    out_ += sentence + "<p class=\"soft\">Connected regions where |d| exceeds " +
            (c_.changes->level > 0 ? "the height of " + quantity("change_summary.height", c_.changes->level, 1)
                                   : std::string("the level of detection")) +
            ", of at least " + quantity("change_summary.min_area", c_.changes->min_area, 2) +
            ", cut exactly; the largest are numbered on the map. Outlines: " + outlines_file() + ".</p>\n" +
            change_chart(c_);
  }

  /// Its ending is that of the format that was asked for.
  [[nodiscard]] std::string outlines_file() const {
    for (const Json& name : json_.at("outputs"))
      if (const auto file = name.get<std::string>(); file.rfind("changes.", 0) == 0 && file != "changes.csv")
        return escaped(file);
    return "changes.geojson";
  }

  void change_row(const std::string& row, bool has_sigma) {
    const auto place = [&](const std::string& key) {
      return datum(row + key, fixed_number(value(row + key), 1, fine));
    };
    std::vector<std::string> cells{with_sign(row + "net")};
    if (has_sigma) {
      cells.push_back(datum(row + "sigma_net", number(value(row + "sigma_net"), fine, 2)));
      cells.push_back(datum(row + "significance", number(value(row + "significance"), fine, 2)));
    }
    for (const std::string& cell :
         {plain(row + "area"), with_sign(row + "mean"), with_sign(row + "max"), place("max_at.0"), place("max_at.1"),
          whole(row + "points_a"), whole(row + "points_b")})
      cells.push_back(cell);
    out_ += "<tr><th scope=\"row\">" + whole(row + "id") + "</th>";
    for (const std::string& cell : cells) out_ += "<td class=\"n\">" + cell + "</td>";
    out_ += "</tr>\n";
  }

  void histogram() {
    const Json& edges = at("difference.histogram.edges");
    const Json& areas = at("difference.histogram.areas");
    if (areas.empty()) return;
    constexpr double width = 1000, height = 250, left = 70, right = 18, top = 12, bottom = 44;
    const double limit = colour_limit(c_, look_), low = look_.range > 0 ? -limit : edges.front().get<double>(),
                 high = look_.range > 0 ? limit : edges.back().get<double>();
    double most = 0;
    for (const Json& a : areas) most = std::max(most, a.get<double>());
    if (!(high > low) || !(most > 0)) return;
    const Palette palette(look_.palette, look_.flip != paints_excess_red(c_.unit));
    const auto x = [&](double d) { return left + (d - low) / (high - low) * (width - left - right); };
    const auto y = [&](double area) { return height - bottom - std::sqrt(area / most) * (height - top - bottom); };
    out_ += fmt::format(
        "<h2>How the area is spread over d</h2>\n<figure><svg viewBox=\"0 0 {} {}\" role=\"img\" "
        "aria-label=\"Histogram of the difference by area\" font-size=\"13\">\n",
        width, height);
    for (const double share : {0.04, 0.25, 1.0}) {
      out_ += fmt::format("<path d=\"M{0} {1:.1f}H{2}\" stroke=\"currentColor\" stroke-opacity=\".25\"/>", left,
                          y(share * most), width - right);
      out_ += fmt::format("<text x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\" fill=\"currentColor\">{}</text>\n", left - 8,
                          y(share * most) + 4.5, number(share * most, fine, 2));
    }
    for (std::size_t i = 0; i < areas.size(); ++i) {
      const double a = std::max(low, edges[i].get<double>()), b = std::min(high, edges[i + 1].get<double>());
      if (!(a < b)) continue;
      const double area = areas[i].get<double>(), middle = (a + b) / 2;
      const bool is_noise = std::fabs(middle) <= c_.uncertainty.lod.value_or(-1);
      const Rgb colour = is_noise ? noise_colour : palette(middle / limit);
      const auto byte = [](double v) { return static_cast<int>(std::lround(255 * v)); };
      out_ += fmt::format(
          "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"#{:02x}{:02x}{:02x}\" "
          "stroke=\"var(--bar)\" stroke-width=\".7\"><title>{} … {} {}: {} {}</title></rect>\n",
          x(a), y(area), x(b) - x(a), height - bottom - y(area), byte(colour.r), byte(colour.g), byte(colour.b),
          signed_number(a, fine, 3), signed_number(b, fine, 3), unit(1), number(area, fine), unit(2));
    }
    for (int k = 0; k <= 4; ++k) {
      const double d = low + (high - low) * k / 4;
      out_ += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"{}\" fill=\"currentColor\">{}</text>\n", x(d),
                          height - bottom + 19,
                          k == 0   ? "start"
                          : k == 4 ? "end"
                                   : "middle",
                          signed_number(d, fine, 3));
    }
    out_ +=
        fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\" fill=\"currentColor\">d ({})</text>\n</svg>\n",
                    (left + width - right) / 2, height - 6, unit(1));
    out_ += "<figcaption>Area (" + unit(2) + ", square-root scale) over the difference d. " + beyond_words(low, high) +
            (c_.uncertainty.lod ? " Grey: within the level of detection." : "") + "</figcaption></figure>\n";
  }

  /// What lies beyond the ends of the histogram.
  [[nodiscard]] std::string beyond_words(double low, double high) const {
    const Json& edges = at("difference.histogram.edges");
    const Json& areas = at("difference.histogram.areas");
    const double first = edges.front().get<double>(), last = edges.back().get<double>();
    if (look_.range <= 0 || (low <= first && high >= last)) return "The outermost bars hold all that lies beyond.";
    double all = 0, below = 0, above = 0;
    for (std::size_t i = 0; i < areas.size(); ++i) {
      const double a = edges[i].get<double>(), b = edges[i + 1].get<double>(), area = areas[i].get<double>();
      all += area;
      below += area * std::clamp((low - a) / (b - a), 0.0, 1.0);
      above += area * std::clamp((b - high) / (b - a), 0.0, 1.0);
    }
    const auto share = [&](double area) { return number(100 * area / all, fine, 2) + "\u00a0%"; };
    return "About " + share(below) + " of the area lies below it, " + share(above) + " above.";
  }

  void inputs() {
    open_table("The two scans", "<th></th><th>A, reference (before)</th><th>B, compared (after)</th>");
    const auto line = [&](const std::string& name, auto&& cell) {
      out_ += "<tr><th scope=\"row\">" + name + "</th><td class=\"wrap\">" + cell(std::string("inputs.0.")) +
              "</td><td class=\"wrap\">" + cell(std::string("inputs.1.")) + "</td></tr>\n";
    };
    const auto words = [&](const char* key) {
      return [this, key](const std::string& in) {
        const Json& v = at(in + key);
        return v.is_null() || v == "" ? std::string("–") : escaped(v.get<std::string>());
      };
    };
    const auto counted = [&](const char* key) {
      return [this, key](const std::string& in) { return whole(in + key); };
    };
    line("file", words("path"));
    line("format", words("format"));
    line("points", counted("points"));
    line("nodes", counted("nodes"));
    line("duplicates merged", counted("duplicates"));
    line("dropped", [&](const std::string& in) {
      return whole(in + "dropped.nonfinite") + " not finite, " + whole(in + "dropped.class") + " of other classes, " +
             whole(in + "dropped.crop") + " outside the crop, " + whole(in + "dropped.nodata") + " no data";
    });
    line("several layers",
         [&](const std::string& in) { return percent(in + "layered_share") + "\u00a0% of the area"; });
    line("unit", [&](const std::string& in) {
      const std::string plane = at(in + "unit").get<std::string>(), up = at(in + "vertical_unit").get<std::string>();
      if (!c_.options.unit.empty()) {
        const std::string named = plane == "unknown" ? "none" : escaped(unit_text(plane));
        return escaped(unit_text(c_.unit)) + message_text(" (as @unit says; in the file: ") + named + ")";
      }
      return escaped(unit_sentence(plane)) + (up == plane ? "" : "; heights: " + escaped(unit_sentence(up)));
    });
    line("coordinate system", words("crs"));
    for (std::size_t k = 0; k < 3; ++k)
      line(std::string(1, static_cast<char>('x' + static_cast<char>(k))), [&](const std::string& in) {
        const std::string low = in + "bounds.min." + std::to_string(k), high = in + "bounds.max." + std::to_string(k);
        const int decimals = decimals_for(value(high) - value(low));
        return datum(low, fixed_number(value(low), decimals, fine)) + " … " +
               datum(high, fixed_number(value(high), decimals, fine));
      });
    close_table();
  }

  [[nodiscard]] static std::string setting_text(const Json& setting) {
    if (setting.is_boolean()) return setting.get<bool>() ? "yes" : "no";
    if (setting.is_string()) return escaped(setting.get<std::string>());
    if (setting.is_number_integer()) return setting.dump();
    if (setting.is_number()) return fmt::format("{}", setting.get<double>());
    std::string list;
    for (const Json& item : setting) list += (list.empty() ? "" : ", ") + setting_text(item);
    return list;
  }

  /// Of an option that is a length; "" for all others.
  [[nodiscard]] std::string unit_of_setting(const std::string& name) const {
    for (const char* length : {"max_edge", "correlation_range"})
      if (name == length) return unit_text(c_.unit);
    for (const char* height : {"sigma1", "sigma2", "lod", "registration_error"})
      if (name == height) return unit(1);
    return "";
  }

  void parameters() {
    open_table("Options in force", "", " class=\"pairs\"");
    for (const auto& [name, setting] : json_.at("parameters").items()) {
      const bool is_nothing = setting.is_null() || (setting.is_array() && setting.empty());
      const bool is_text = setting.is_string() || (setting.is_array() && !is_nothing && setting[0].is_string());
      const std::string shown = is_nothing ? "–"
                                : is_text  ? setting_text(setting)
                                           : datum("parameters." + name, setting_text(setting)) +
                                                (setting.is_number() ? " " + unit_of_setting(name) : "");
      out_ +=
          "<tr><th scope=\"row\"><code>" + escaped(name) + "</code></th><td class=\"wrap\">" + shown + "</td></tr>\n";
    }
    if (!c_.options.pose.is_identity()) {
      std::string rows;
      for (const Json& r : at("pose.matrix")) rows += escaped(r.dump()) + "<br>";
      out_ += "<tr><th scope=\"row\">pose of B, row-major</th><td class=\"wrap\"><code>" + rows + "</code></td></tr>\n";
    }
    close_table();
  }

  void working() {
    open_table("Behind the numbers", told_columns, " class=\"told\"");
    row("triangles of A", whole("triangulations.t1"), "", "Delaunay triangulation of the nodes of A");
    row("triangles of B", whole("triangulations.t2"), "", "Delaunay triangulation of the nodes of B");
    row("common triangles", whole("triangulations.common"), "", "of the nodes of both; the measure runs over these");
    row("interface triangles", whole("triangulations.interface"), "", "of those, with corners from both scans");
    if (c_.visited_1_in_2 + c_.visited_2_in_1 > 0) {  // tiles do not count them
      row("triangles visited", whole("localisation.visited_1_in_2"), "",
          "to place the nodes of A in B, method " + escaped(at("localisation.method").get<std::string>()));
      row("", whole("localisation.visited_2_in_1"), "", "to place the nodes of B in A");
    }
    row("border trimmed", percent("border.trimmed_area"), "% of area",
        "left out: not supported by the sampling, at the rim and in holes");
    row("", percent("border.trimmed_volume"), "% of volume", "of the gross volume that the hulls alone would give");
    row("folds", percent("folds.share"), "% of area", escaped(fold_sentence(c_)));
    row("border slivers", percent("border.sliver_area"), "% of area",
        "long thin triangles along the border, kept in the measure");
    row("", percent("border.sliver_volume"), "% of volume", "their share of the gross volume");
    for (const auto& [stage, seconds] : json_.at("timing_s").items()) {
      std::string words = stage;
      std::replace(words.begin(), words.end(), '_', ' ');
      row("time: " + escaped(words),
          datum("timing_s." + stage, number(seconds.is_number() ? seconds.get<double>() : std::nan(""), fine, 3)), "s",
          stage == "total" ? "all stages together" : "");
    }
    close_table();
  }

  const Comparison& c_;
  const MapOptions& look_;
  const Matching* matched_;
};

}  // namespace

void write_html(const std::string& path, const Comparison& c, const std::string& json, const PageOptions& options,
                const Context& context) {
  context.check();
  write_text_atomically(path, Page(c, json, options.look, options.matched).write_with_view(options, context));
}

}  // namespace isopach
