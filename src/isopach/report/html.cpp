// report.html: one page that opens from disk, without a network and without a script. Every number is taken from the
// text of result.json, shown rounded, with the exact value as its title and its key as data-key.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "isopach/io/write.hpp"
#include "isopach/report/map.hpp"
#include "isopach/report/palette.hpp"
#include "isopach/report/report.hpp"
#include "isopach/report/uncertainty.hpp"
#include "isopach/report/words.hpp"

namespace isopach {
namespace {

using Json = nlohmann::ordered_json;
constexpr Typography fine = Typography::fine;

constexpr const char* style = R"css(
:root{color-scheme:light dark;--paper:#fff;--ink:#1d2126;--soft:#5b636e;--line:#dfe2e6;--tint:#f5f6f7;--bar:#9aa1ab;
--warn:#fff4d6;--warn-line:#d9a514;--accent:#0f4f8b}
@media(prefers-color-scheme:dark){:root{--paper:#15181c;--ink:#e6e8eb;--soft:#9aa3ae;--line:#30363d;--tint:#1d2126;
--bar:#6f7884;--warn:#3a3115;--warn-line:#c99a1a;--accent:#8ab8ea}}
*{box-sizing:border-box}
body{margin:0;background:var(--paper);color:var(--ink);font:16px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,
"Helvetica Neue","DejaVu Sans",sans-serif;-webkit-font-smoothing:antialiased}
main{max-width:1060px;margin:0 auto;padding:44px 28px 64px}
h1{font-size:29px;line-height:1.2;margin:0 0 10px;letter-spacing:-.012em;overflow-wrap:anywhere}
h1 span{color:var(--soft);font-weight:400}
h2{font-size:19px;margin:46px 0 12px;letter-spacing:-.005em}
p{margin:0 0 12px;max-width:50em}
.soft{max-width:60em}
.scroll+p{margin-top:12px}
.lead{font-size:20px;line-height:1.45}
.soft,caption,figcaption,footer{color:var(--soft);font-size:14px}
.cards{display:grid;grid-template-columns:repeat(auto-fit,minmax(170px,1fr));gap:1px;margin:26px 0;
border:1px solid var(--line);border-radius:8px;overflow:hidden}
.cards div{box-shadow:0 0 0 1px var(--line);padding:14px 16px}
.cards b{display:block;font-size:22px;font-weight:600;font-variant-numeric:tabular-nums;white-space:nowrap}
.cards b small{font-size:14px;font-weight:400;color:var(--soft)}
.cards span{color:var(--soft);font-size:14px}
.warnings{background:var(--warn);border-left:4px solid var(--warn-line);border-radius:4px;padding:12px 18px;margin:22px 0}
.warnings ul{margin:4px 0 0;padding-left:20px}
figure{margin:26px 0}
figure img{display:block;width:100%;height:auto;border-radius:8px;border:1px solid var(--line);background:#fff}
svg{display:block;width:100%;height:auto;color:var(--soft)}
table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums}
th,td{text-align:left;padding:7px 14px 7px 0;border-bottom:1px solid var(--line);vertical-align:baseline}
thead th{font-size:13px;font-weight:500;color:var(--soft)}
tbody th{font-weight:500;min-width:11.5em}
table.pairs th{width:17em}
thead th.n{text-align:right;padding-right:6px}
td.n{text-align:right;white-space:nowrap;padding-right:6px}
td.u{color:var(--soft);white-space:nowrap}
td.why{color:var(--soft);font-size:14.5px}
td.wrap{overflow-wrap:anywhere}
code,pre{font:13px/1.45 ui-monospace,SFMono-Regular,Menlo,Consolas,"DejaVu Sans Mono",monospace}
pre{background:var(--tint);border-radius:8px;padding:14px 16px;overflow:auto;max-height:70vh}
summary{cursor:pointer;color:var(--accent)}
footer{margin-top:52px;padding-top:14px;border-top:1px solid var(--line)}
.scroll{overflow-x:auto}
@media(max-width:640px){main{padding:28px 16px}table.told thead{display:none}
table.told tr{display:flex;flex-wrap:wrap;border-bottom:1px solid var(--line);padding:7px 0}
table.told th,table.told td{border:0;padding:0 6px 0 0}table.told th{flex:1}table.told .why{flex:0 0 100%}}
@media print{:root{color-scheme:light;--paper:#fff;--ink:#000;--soft:#444;--line:#bbb;--tint:#f5f5f5;--warn:#fff}
body{font-size:11pt}main{padding:0;max-width:none}details{display:none}figure,tr,.cards{break-inside:avoid}
h2{break-after:avoid}@page{margin:16mm}}
)css";

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : clean_utf8(text)) switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  return out;
}

std::string base64(const std::string& bytes) {
  static constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](std::size_t k) {
      return i + k < bytes.size() ? static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[i + k])) : 0u;
    };
    const std::uint32_t three = byte(0) << 16 | byte(1) << 8 | byte(2);
    for (std::size_t k = 0; k < 4; ++k) out += i + k <= bytes.size() ? digits[three >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

std::string read_bytes(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path + ": the map cannot be read; write it before the report");
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

class Page {
 public:
  Page(const Comparison& c, const std::string& json, const MapOptions& look)
      : c_(c), text_(json), json_(Json::parse(json)), look_(look) {}

  [[nodiscard]] std::string write(const std::string& map_png, const std::optional<Truth>& truth) {
    const std::string title =
        look_.title.empty() ? input_name(c_.a) + " → " + input_name(c_.b) : clean_utf8(look_.title);
    out_ +=
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
        "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n"
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src "
        "'unsafe-inline'\">\n<title>" +
        escaped(title) + "</title>\n<style>" + style + "</style>\n</head>\n<body>\n<main>\n";
    head();
    warnings();
    map(map_png);
    if (truth) truth_table(*truth);
    numbers();
    histogram();
    inputs();
    parameters();
    working();
    raw();
    out_ += "</main>\n</body>\n</html>\n";
    return out_;
  }

 private:
  // --- pieces -------------------------------------------------------------------------------------------------------

  [[nodiscard]] const Json& at(const std::string& key) const {
    std::string pointer = "/" + key;
    std::replace(pointer.begin(), pointer.end(), '.', '/');
    return json_.at(Json::json_pointer(pointer));
  }

  /// A number of result.json: `shown` for people, the exact one as title and value.
  [[nodiscard]] std::string datum(const std::string& key, const std::string& shown) const {
    const std::string exact = at(key).dump();
    return "<data data-key=\"" + key + "\" value=\"" + exact + "\" title=\"" + exact + "\">" + shown + "</data>";
  }
  [[nodiscard]] double value(const std::string& key) const {
    const Json& v = at(key);
    return v.is_number() ? v.get<double>() : std::nan("");
  }
  [[nodiscard]] std::string plain(const std::string& key) const { return datum(key, number(value(key), fine)); }
  [[nodiscard]] std::string with_sign(const std::string& key) const {
    return datum(key, signed_number(value(key), fine));
  }
  [[nodiscard]] std::string whole(const std::string& key) const {
    return datum(key, count(at(key).get<std::uint64_t>(), fine));
  }
  [[nodiscard]] std::string percent(const std::string& key) const {
    return "<data data-key=\"" + key + "\" data-percent value=\"" + at(key).dump() + "\" title=\"" + at(key).dump() +
           "\">" + fixed_number(100 * value(key), 1, fine) + "</data>";
  }
  [[nodiscard]] std::string unit(int power) const { return measured_unit(c_, power); }

  void card(const std::string& number_html, const std::string& unit_html, const std::string& label) {
    out_ += "<div><b>" + number_html + " <small>" + unit_html + "</small></b><span>" + label + "</span></div>\n";
  }
  void row(const std::string& name, const std::string& number_html, const std::string& unit_html,
           const std::string& why) {
    out_ += "<tr><th scope=\"row\">" + name + "</th><td class=\"n\">" + number_html + "</td><td class=\"u\">" +
            unit_html + "</td><td class=\"why\">" + why + "</td></tr>\n";
  }
  void open_table(const std::string& title, const std::string& columns, const std::string& kind = "") {
    out_ += "<h2>" + title + "</h2>\n<div class=\"scroll\"><table" + kind + ">\n";
    if (!columns.empty()) out_ += "<thead><tr>" + columns + "</tr></thead>\n";
    out_ += "<tbody>\n";
  }
  void close_table() { out_ += "</tbody></table></div>\n"; }

  // --- sections, in the order of the page ---------------------------------------------------------------------------

  void head() {
    const std::string names = escaped(input_name(c_.a)) + " <span>→</span> " + escaped(input_name(c_.b));
    out_ += "<header>\n<h1>" + (look_.title.empty() ? names : escaped(look_.title)) + "</h1>\n";
    const auto quantity = [&](const std::string& key, double magnitude, int power) {
      return datum(key, number(magnitude, fine)) + "\u00a0" + unit(power);
    };
    out_ += "<p class=\"lead\">" + headline(c_, quantity) + "</p>\n";
    out_ += "<p class=\"soft\">A is the reference (before), B is compared with it (after): " + std::string(sign_rule) +
            (c_.unit == "unknown" ? ". Lengths: " : ". Lengths in ") + unit_sentence(c_.unit) +
            (height_unit(c_) == c_.unit ? "" : ", heights in " + unit_sentence(height_unit(c_))) +
            "; statistics are by area.</p>\n</header>\n<div class=\"cards\">\n";
    card(with_sign("volume.net"), unit(3), "net = gained − lost");
    card(plain("volume.above"), unit(3), "gained (B above A)");
    card(plain("volume.below"), unit(3), "lost (B below A)");
    if (c_.options.measure == MeasureKind::dV)
      card(plain("measure.rho_dv"), unit(1), "at shared detail (ρ<sub>dV</sub>)");
    card(plain("measure.rho"), unit(1), "mean |d| (ρ)");
    card(percent("domain.coverage"), "%", "of the area of both scans compared");
    out_ += "</div>\n";
  }

  void warnings() {
    const Json& list = json_.at("warnings");
    if (list.empty()) return;
    out_ += "<section class=\"warnings\" role=\"note\"><strong>Before you rely on the numbers</strong><ul>\n";
    for (const Json& w : list) out_ += "<li>" + escaped(w.get<std::string>()) + "</li>\n";
    out_ += "</ul></section>\n";
  }

  void map(const std::string& png) {
    if (png.empty()) return;
    out_ += "<figure><img alt=\"Map of the difference B − A in colours centred on zero\" src=\"data:image/png;base64," +
            base64(read_bytes(png)) + "\">\n</figure>\n";
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
    line("lost", truth.below, "volume.below", 3);
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

  void numbers() {
    open_table("The numbers", "<th>name</th><th></th><th>unit</th><th>what it says</th>", " class=\"told\"");
    row("gained (above)", plain("volume.above"), unit(3), "volume between the surfaces where B lies above A");
    row("lost (below)", plain("volume.below"), unit(3), "volume between the surfaces where B lies below A");
    row("net", with_sign("volume.net"), unit(3), "gained − lost; gains and losses cancel in it");
    row("gross (absolute)", plain("volume.absolute"), unit(3), "gained + lost; nothing cancels in it");
    row("ρ, mean |d|", plain("measure.rho"), unit(1), "gross volume ÷ area: how far apart the surfaces are on average");
    if (at("measure.rho_dv").is_number())
      row("ρ<sub>dV</sub>", plain("measure.rho_dv"), unit(1),
          "the same with the detail only the finer scan holds averaged out");
    if (at("measure.weight").is_object()) {
      const std::string by = "with the weight “" + escaped(clean_utf8(to_text(c_.options.weight))) + "”";
      row("ρ, weighted", plain("measure.weight.rho"), unit(1), "weighted gross volume ÷ area, " + by);
      row("gained, weighted", plain("measure.weight.above"), unit(3), "∫ d μ where B lies above A, " + by);
      row("lost, weighted", plain("measure.weight.below"), unit(3), "likewise where B lies below A");
      row("net, weighted", with_sign("measure.weight.net"), unit(3), "the first less the second");
      row("∫ of the weight", plain("measure.weight.integral"), unit(2), "weighted net ÷ this: the weighted mean of d");
      row("error of ρ, weighted", plain("measure.weight.error_estimate"), unit(1),
          "of the integration; 0 in closed form");
    }
    row("mean d", with_sign("difference.mean"), unit(1), "net volume ÷ area: the offset of B from A (bias)");
    row("median d", with_sign("difference.median"), unit(1), "half of the area has a smaller d");
    row("RMS", plain("difference.rms"), unit(1), "root of the mean of d²; large differences weigh more");
    row("standard deviation", plain("difference.std"), unit(1), "spread of d about its mean");
    row("NMAD", plain("difference.nmad"), unit(1), "1.4826 × median |d − median d|: the spread without the outliers");
    for (const int level : percentile_levels)
      row("|d| at " + std::to_string(level) + "\u00a0%", plain("difference.abs_percentiles." + std::to_string(level)),
          unit(1), std::to_string(level) + "\u00a0% of the area differs by no more than this");
    row("largest above", plain("difference.max_above"), unit(1), "the highest B rises over A");
    row("largest below", plain("difference.max_below"), unit(1), "the deepest B falls under A");
    row("area compared", plain("domain.area"), unit(2), "where both surfaces are known, seen along the direction");
    row("area of both", plain("domain.area_union"), unit(2), "covered by at least one of the scans");
    row("coverage", percent("domain.coverage"), "%", "area compared ÷ area of both");
    row("error of the integral", plain("measure.error_estimate"), unit(1),
        "of ρ, by the integration alone; 0 where it is in closed form. Noise of the scans is not in it");
    if (c_.noise_floor) {
      row("noise floor, gained", plain("uncertainty.noise_floor.above"), unit(3),
          "what two scans of an unchanged surface would show, by the roughness and noise of these");
      row("noise floor, lost", plain("uncertainty.noise_floor.below"), unit(3), "likewise");
      row("noise floor, ρ", plain("uncertainty.noise_floor.rho"), unit(1), "likewise");
      row("gross, debiased", plain("uncertainty.debiased.absolute"), unit(3),
          "the gross volume without what roughness and noise add to it");
      row("ρ, debiased", plain("uncertainty.debiased.rho"), unit(1), "that ÷ area");
    }
    if (at("surfaces").is_object()) {
      row("gained, exact overlay", plain("surfaces.overlay.above"), unit(3),
          "the same between the two triangulations themselves, not over the common one");
      row("lost, exact overlay", plain("surfaces.overlay.below"), unit(3), "likewise");
      row("net, exact overlay", with_sign("surfaces.overlay.net"), unit(3), "likewise");
      row("gross, overlay − common", with_sign("surfaces.overlay_minus_common.absolute"), unit(3),
          "how much the choice of triangles alone matters");
    }
    close_table();
    if (c_.noise_floor)
      out_ +=
          "<p>By the noise floor, " +
          noise_floor_sentence(c_, [&](const std::string& key, double v,
                                       int power) { return datum(key, number(v, fine)) + "\u00a0" + unit(power); }) +
          ".</p>\n";
    out_ += "<p class=\"soft\">Uncertainty of the scans: model “" +
            escaped(at("uncertainty.model").get<std::string>()) + "”" +
            (at("uncertainty.model") == "none" ? "; no error of the scanners was given, so none is claimed here.</p>\n"
                                               : ".</p>\n");
  }

  void histogram() {
    const Json& edges = at("difference.histogram.edges");
    const Json& areas = at("difference.histogram.areas");
    if (areas.empty()) return;
    constexpr double width = 1000, height = 250, left = 70, right = 18, top = 12, bottom = 44;
    const double low = edges.front().get<double>(), high = edges.back().get<double>(), limit = colour_limit(c_);
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
      const double a = edges[i].get<double>(), b = edges[i + 1].get<double>(), area = areas[i].get<double>();
      const Rgb colour = palette((a + b) / 2 / limit);
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
    out_ += "<figcaption>Area (" + unit(2) +
            ", square-root scale) over the difference d. The outermost bars hold all that lies "
            "beyond.</figcaption></figure>\n";
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
    if (setting.is_number_integer()) return setting.dump();
    if (setting.is_number()) return number(setting.get<double>(), fine);
    std::string list;
    for (const Json& item : setting) list += (list.empty() ? "" : ", ") + setting_text(item);
    return list;
  }

  void parameters() {
    open_table("Options in force", "", " class=\"pairs\"");
    for (const auto& [name, setting] : json_.at("parameters").items()) {
      const std::string shown = setting.is_null()     ? "–"
                                : setting.is_string() ? escaped(setting.get<std::string>())
                                                      : datum("parameters." + name, setting_text(setting));
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
    open_table("Behind the numbers", "", " class=\"told\"");
    row("triangles of A", whole("triangulations.t1"), "", "Delaunay triangulation of the nodes of A");
    row("triangles of B", whole("triangulations.t2"), "", "Delaunay triangulation of the nodes of B");
    row("common triangles", whole("triangulations.common"), "", "of the nodes of both; the measure runs over these");
    row("interface triangles", whole("triangulations.interface"), "", "of those, with corners from both scans");
    row("triangles visited", whole("localisation.visited_1_in_2"), "",
        "to place the nodes of A in B, method " + escaped(at("localisation.method").get<std::string>()));
    row("", whole("localisation.visited_2_in_1"), "", "to place the nodes of B in A");
    row("border trimmed", percent("border.trimmed_area"), "% of area",
        "left out: not supported by the sampling, at the rim and in holes");
    row("", percent("border.trimmed_volume"), "% of volume", "of the gross volume that the hulls alone would give");
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

  void raw() {
    std::string block = text_;
    for (std::size_t i = 0; (i = block.find('<', i)) != std::string::npos; i += 6) block.replace(i, 1, "\\u003c");
    std::string lines;
    for (std::size_t i = 0, end = 0; i < text_.size(); i = end + 1) {
      end = std::min(text_.find('\n', i), text_.size());
      lines += escaped(std::string_view(text_).substr(i, end - i)) + "\n";
    }
    out_ += "<h2>Everything, exactly</h2>\n<details><summary>result.json</summary><pre>" + lines +
            "</pre></details>\n<script type=\"application/json\" id=\"result\">" + block + "</script>\n";
    out_ += "<footer>" + escaped(at("tool.name").get<std::string>()) + " " +
            escaped(at("tool.version").get<std::string>()) + " · schema " + escaped(at("schema").get<std::string>()) +
            " · numbers on this page are rounded; point at one to see it in full</footer>\n";
  }

  const Comparison& c_;
  const std::string& text_;
  Json json_;
  const MapOptions& look_;
  std::string out_;
};

}  // namespace

void write_html(const std::string& path, const Comparison& c, const std::string& map_png, const std::string& json,
                const std::optional<Truth>& truth, const Context& context, const MapOptions& look) {
  context.check();
  const std::string page = Page(c, json, look).write(map_png, truth);
  write_atomically(path, [&](const std::string& temporary) {
    std::ofstream out(temporary, std::ios::binary);
    out << page;
    if (!out.flush()) throw InputError(path + ": cannot be written; check the folder and the disk space");
  });
}

}  // namespace isopach
