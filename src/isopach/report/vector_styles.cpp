#include "isopach/report/vector_styles.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "isopach/report/draw/map.hpp"
#include "isopach/report/draw/palette.hpp"

namespace isopach {
namespace {

struct Property {
  const char* key;
  std::string value;
};

/// A rule of a renderer, with its symbol.
struct Rule {
  std::string label, filter;  ///< filter: an expression of QGIS
  const char* symbol;         ///< "line" or "fill"
  std::vector<Property> properties;
};

std::string rgba(const Rgb& colour, int alpha = 255) {
  const auto byte = [](double v) { return static_cast<int>(std::lround(255 * std::clamp(v, 0.0, 1.0))); };
  return fmt::format("{},{},{},{}", byte(colour.r), byte(colour.g), byte(colour.b), alpha);
}

std::string attribute(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '"' ? "&quot;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : std::string(1, c);
  return out;
}

std::string symbol(std::size_t name, const Rule& rule) {
  const bool line = std::string_view(rule.symbol) == "line";
  std::string out = fmt::format(
      "      <symbol type=\"{}\" name=\"{}\" alpha=\"1\" clip_to_extent=\"1\" force_rhr=\"0\">\n"
      "        <layer class=\"{}\" enabled=\"1\" locked=\"0\" pass=\"0\">\n          <Option type=\"Map\">\n",
      rule.symbol, name, line ? "SimpleLine" : "SimpleFill");
  for (const Property& p : rule.properties)
    out += fmt::format("            <Option type=\"QString\" name=\"{}\" value=\"{}\"/>\n", p.key, p.value);
  out += "          </Option>\n";
  for (const Property& p : rule.properties)  // as QGIS read them before 3.20
    out += fmt::format("          <prop k=\"{}\" v=\"{}\"/>\n", p.key, p.value);
  return out + "        </layer>\n      </symbol>\n";
}

std::string style_of(const std::vector<Rule>& rules) {
  std::string list, symbols;
  for (std::size_t i = 0; i < rules.size(); ++i) {
    list += fmt::format("      <rule key=\"{{{0}}}\" symbol=\"{0}\" label=\"{1}\" filter=\"{2}\"/>\n", i,
                        attribute(rules[i].label), attribute(rules[i].filter));
    symbols += symbol(i, rules[i]);
  }
  return fmt::format(
      "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n"
      "<qgis version=\"3.22\" styleCategories=\"Symbology\">\n"
      "  <renderer-v2 type=\"RuleRenderer\" symbollevels=\"0\" enableorderby=\"0\" forceraster=\"0\">\n"
      "    <rules key=\"{{all}}\">\n{}    </rules>\n    <symbols>\n{}    </symbols>\n  </renderer-v2>\n</qgis>\n",
      list, symbols);
}

std::vector<Property> line_of(const std::string& colour, const char* width, const char* kind = "solid") {
  return {{"line_color", colour},    {"line_style", kind},  {"line_width", width},
          {"line_width_unit", "MM"}, {"capstyle", "round"}, {"joinstyle", "round"}};
}

std::vector<Property> fill_of(const std::string& inside, const std::string& outline, const char* kind = "solid",
                              const char* outline_kind = "solid") {
  return {{"color", inside},          {"style", kind},
          {"outline_color", outline}, {"outline_style", outline_kind},
          {"outline_width", "0.3"},   {"outline_width_unit", "MM"},
          {"joinstyle", "round"}};
}

Palette palette_of(const Comparison& c, const MapOptions& look) {
  return {look.palette, look.flip != paints_excess_red(c.unit)};
}

constexpr Rgb ink{0.13, 0.14, 0.16};

}  // namespace

std::string contours_style(const Comparison& c, const MapOptions& look) {
  constexpr int classes = 4;  // each way
  const Palette palette = palette_of(c, look);
  const double limit = colour_limit(c, look);
  std::vector<Rule> rules{{"no difference", "\"d\" = 0", "line", line_of(rgba(ink), "0.4")}};
  for (const int sign : {1, -1})
    for (int k = 1; k <= classes; ++k) {
      // White is no colour of a line: the lightest one is that of half of the range.
      const Rgb& colour = palette(sign * (0.5 + 0.5 * k / classes));
      const double from = limit * (k - 1) / classes, to = limit * k / classes;
      const std::string d = sign > 0 ? "\"d\"" : "-\"d\"";
      const bool last = k == classes;
      rules.push_back({fmt::format("{} {}{:.4g}{}", sign > 0 ? "gained" : "lost", last ? "over " : "to ",
                                   last ? from : to, c.unit == "unknown" ? "" : " " + c.unit),
                       fmt::format("{0} > {1:.17g}", d, from) + (last ? "" : fmt::format(" AND {} <= {:.17g}", d, to)),
                       "line", line_of(rgba(colour), "0.26")});
    }
  return style_of(rules);
}

std::string changes_style(const Comparison& c, const MapOptions& look) {
  constexpr int seen_through = 90;
  const Palette palette = palette_of(c, look);
  std::vector<Rule> rules;
  for (const auto& [word, colour] : {std::pair{"gained", palette(1)}, std::pair{"lost", palette(-1)}})
    rules.push_back(
        {word, fmt::format("\"change\" = '{}'", word), "fill", fill_of(rgba(colour, seen_through), rgba(colour))});
  return style_of(rules);
}

std::string tile_states_style() {
  const Palette palette(MapOptions{}.palette, false);
  return style_of({{"done", "\"state\" = 'done'", "fill", fill_of(rgba(palette(1), 90), rgba(ink))},
                   {"failed", "\"state\" = 'failed'", "fill", fill_of(rgba(palette(-1), 160), rgba(ink))},
                   {"missing", "\"state\" = 'missing'", "fill", fill_of("0,0,0,0", rgba(ink), "no", "dash")}});
}

std::string outlines_style(const Comparison& c, const MapOptions& look) {
  const Palette palette = palette_of(c, look);
  return style_of(
      {{"compared", "\"name\" = 'domain'", "fill", fill_of(rgba(ink, 30), rgba(ink))},
       {"points of A", "\"name\" = 'footprint_a'", "fill", fill_of("0,0,0,0", rgba(palette(-1)), "no", "dash")},
       {"points of B", "\"name\" = 'footprint_b'", "fill", fill_of("0,0,0,0", rgba(palette(1)), "no", "dot")}});
}

}  // namespace isopach
