// The maps and report.html of `isopach roughness`.
#include <algorithm>
#include <cmath>

#include "isopach/io/output_file.hpp"
#include "isopach/report/page/page.hpp"
#include "isopach/report/roughness.hpp"
#include "isopach/report/view/view_page.hpp"

namespace isopach {
namespace {

constexpr Typography fine = Typography::fine;
constexpr std::size_t most_lines = 60;  // labels of more would hide one another

/// A map draws a comparison: here of the surface with itself, plus the field.
Comparison drawn(const Roughness& r, const Texture& x, const Measures& measures) {
  Comparison c;
  c.frame = r.frame;
  c.unit = r.unit;
  c.a = c.b = x.input;
  c.cells = x.cells;
  c.measures = measures;
  c.domain_area = measures.area;
  c.coverage = measures.area / x.area;
  return c;
}

MapOptions with_words(MapOptions look, const Roughness& r, const Texture& x) {
  const auto length = [&](double v) { return number(v, fine) + "\u00a0" + unit_text(r.unit); };
  const ArealParameters& p = x.parameters;
  if (look.title.empty()) look.title = input_name(x.input);
  look.words.headline = "Sa " + length(p.sa) + "   ·   Sq " + length(p.sq) + "   ·   Sz " + length(p.sz) +
                        "   ·   Sdr " + number(100 * p.sdr, fine) + "\u00a0%";
  look.words.where = number(p.area, fine) + "\u00a0" + unit_text(r.unit, 2) + " evaluated, " +
                     fixed_number(100 * p.area / x.area, 1, fine) + " % of the scan   ·   " + removed_text(r, fine) +
                     (r.unit == "unknown" ? "   ·   units unknown (as in the files)" : "");
  look.words.above = "peaks";
  look.words.below = "valleys";
  look.words.left_out = "scanned, but not evaluated (rim)";
  return look;
}

class Page : public ViewPage {
 public:
  Page(const Roughness& r, const std::string& json) : ViewPage(json), r_(r), unit_(escaped(unit_text(r.unit))) {}

  std::string write_with_view(const std::vector<ReportPicture>& pictures, const MapOptions& look,
                              const Context& context) {
    write(pictures);
    const Comparison before = drawn(r_, r_.scan, r_.scan.relief);
    const Comparison after = r_.after ? drawn(r_, *r_.after, r_.after->relief) : Comparison();
    std::vector<ViewScene> scenes{{r_.after ? "before" : "", &before}};
    if (r_.after) scenes.push_back({"after", &after});
    const ViewWords words{"mean surface", "scan", "peak", "valley", true, ""};
    return with_view(scenes, words, look, context);
  }

 private:
  std::string write(const std::vector<ReportPicture>& pictures) {
    const std::string title = "Roughness of " + input_name(r_.scan.input) +
                              (r_.after ? " and " + input_name(r_.after->input) : std::string());
    open_page(title);
    head(title);
    warnings();
    out_ += view_place;
    for (const ReportPicture& p : pictures) picture(p.path, p.caption, escaped(p.caption));
    numbers();
    wrinkles();
    removed();
    inputs();
    finish_page();
    return out_;
  }

  [[nodiscard]] std::string length(const std::string& key) const { return plain(key) + "\u00a0" + unit_; }

  void head(const std::string& title) {
    out_ += "<header>\n<h1>" + escaped(title) + "</h1>\n<p class=\"lead\">The heights stray by " +
            length("scan.parameters.sa") + " from their mean on average (Sa) and by " + length("scan.parameters.sz") +
            " at most, from peak to pit (Sz)";
    if (r_.after)
      out_ += "; after, by " + length("after.parameters.sa") + " and " + length("after.parameters.sz") +
              ", a change of " + percent("change.parameters.sa") + "\u00a0% and " + percent("change.parameters.sz") +
              "\u00a0%";
    out_ += ". " + whole("scan.wrinkles.count") + " wrinkles were found.</p>\n<p class=\"soft\">" +
            escaped(removed_text(r_, fine)) + ". Lengths: " + escaped(unit_sentence(r_.unit)) +
            "; parameters after ISO 25178-2, over " + percent("scan.evaluated_share") +
            "\u00a0% of the area of the scan.</p>\n</header>\n<div class=\"cards\">\n";
    for (const char* key : {"sa", "sq", "sz"})
      card(plain("scan.parameters." + std::string(key)), unit_,
           key == std::string("sa")   ? "Sa, mean size"
           : key == std::string("sq") ? "Sq, root mean square"
                                      : "Sz, peak to pit");
    card(percent("scan.parameters.sdr"), "%", "Sdr, added area");
    card(whole("scan.wrinkles.count"), "", "wrinkles");
    out_ += "</div>\n";
  }

  void numbers() {
    const std::string after = r_.after ? "<th class=\"n\">after</th><th class=\"n\">change, %</th>" : "";
    open_table("The parameters",
               "<th>name</th><th class=\"n\">scan</th>" + after + "<th>unit</th><th>what it says</th>");
    for (const ParameterName& p : parameter_names()) {
      const std::string key = p.key;
      out_ += "<tr><th scope=\"row\">" + std::string(p.symbol) + "</th><td class=\"n\">" +
              plain("scan.parameters." + key) + "</td>";
      if (r_.after)
        out_ += "<td class=\"n\">" + plain("after.parameters." + key) + "</td><td class=\"n\">" +
                (at("change.parameters." + key).is_number() ? percent("change.parameters." + key) : std::string("–")) +
                "</td>";
      out_ += "<td class=\"u\">" + (p.power > 0 ? unit_ : std::string()) + "</td><td class=\"why\">" + p.meaning +
              "</td></tr>\n";
    }
    close_table();
  }

  void wrinkles() {
    const auto in = [&](const char* name) { return "<th class=\"n\">" + std::string(name) + ", " + unit_ + "</th>"; };
    const std::string after = r_.after ? in("depth after") + in("mean after") + "<th class=\"n\">change, %</th>" : "";
    open_table("Wrinkles", "<th>number</th>" + in("depth") + in("mean depth") + in("length") + in("width") + after);
    for (std::size_t k = 0; k < r_.scan.wrinkles.all.size(); ++k) {
      const std::string w = "scan.wrinkles.list." + std::to_string(k) + ".";
      out_ += "<tr><th scope=\"row\">" + std::to_string(k + 1) + "</th>";
      const auto cell = [&](const std::string& html) { out_ += "<td class=\"n\">" + html + "</td>"; };
      for (const char* key : {"depth", "mean_depth", "length", "width"}) cell(plain(w + key));
      if (r_.after) {
        const std::string c = "change.wrinkles." + std::to_string(k) + ".";
        const auto known = [&](const std::string& key, auto&& html) {
          cell(at(key).is_number() ? html(key) : std::string("–"));
        };
        for (const char* key : {"depth", "mean_depth"})
          known(c + key, [&](const std::string& path) { return plain(path); });
        known(c + "mean_depth_change", [&](const std::string& path) { return percent(path); });
      }
      out_ += "</tr>\n";
    }
    close_table();
    out_ += "<p class=\"soft\">A wrinkle is a valley deeper than " + length("scan.wrinkles.depth_limit") +
            " under the robust mean surface, longer than " + length("scan.wrinkles.length_limit") +
            " and at least three times as long as wide; " + whole("scan.wrinkles.pits") +
            " other valleys are not listed.</p>\n";
  }

  void removed() {
    open_table("What was removed", "<th>name</th><th></th><th>unit</th><th>what it says</th>", " class=\"told\"");
    row("form", plain("scan.form_sq"), unit_, "root mean square of the form about its mean");
    row("waviness", plain("scan.waviness_sq"), unit_, "likewise of the waviness");
    row("spacing", plain("scan.spacing"), unit_, "of the points, on average");
    row("area", plain("scan.area"), unit_ + "²", "that the points support, in the plane");
    row("folds", percent("scan.folded_share"), "%", "of the area has several layers along the direction");
    row("evaluated", plain("scan.evaluated_area"), unit_ + "²", "of it, away from the rim");
    close_table();
  }

  void inputs() {
    open_table("Files", "<th>role</th><th>file</th><th class=\"n\">points</th><th class=\"n\">nodes</th><th>unit</th>");
    for (std::size_t i = 0; i < at("inputs").size(); ++i) {
      const std::string in = "inputs." + std::to_string(i) + ".";
      out_ += "<tr><th scope=\"row\">" + escaped(at(in + "role").get<std::string>()) + "</th><td class=\"wrap\">" +
              escaped(at(in + "path").get<std::string>()) + "</td><td class=\"n\">" + whole(in + "points") +
              "</td><td class=\"n\">" + whole(in + "nodes") + "</td><td>" +
              escaped(unit_sentence(r_.options.compare.unit.empty() ? at(in + "unit").get<std::string>() : r_.unit)) +
              "</td></tr>\n";
    }
    close_table();
  }

  const Roughness& r_;
  std::string unit_;
};

}  // namespace

void write_roughness_map(const std::string& path, const Roughness& r, const Texture& x, const MapOptions& look,
                         const Context& context) {
  MapOptions options = with_words(look, r, x);
  options.words.zero = "at the mean surface";
  options.words.note = "d: roughness, the height over form and waviness";
  write_map(path, drawn(r, x, x.relief), options, context);
}

void write_wrinkle_map(const std::string& path, const Roughness& r, const Texture& x, const MapOptions& look,
                       const Context& context) {
  Comparison c = drawn(r, x, x.valleys);
  for (std::size_t i = 0; i < c.cells.z1.size(); ++i) c.cells.z2[i] = c.cells.z1[i] + x.valley[i];
  MapOptions options = with_words(look, r, x);
  const Wrinkles& w = x.wrinkles;
  const auto length = [&](double v) { return number(v, fine) + "\u00a0" + unit_text(r.unit); };
  options.words.headline = count(w.all.size(), fine) + (w.all.size() == 1 ? " wrinkle" : " wrinkles");
  if (!w.all.empty()) options.words.headline += "   ·   deepest " + length(w.all.front().depth);
  options.words.headline += "   ·   deeper than " + length(w.depth) + " and longer than " + length(w.length);
  options.words.zero = "at the robust mean surface";
  options.words.note = "d: height over form and robust waviness; lines: wrinkles, the deepest is 1";
  for (std::size_t k = 0; k < std::min(w.all.size(), most_lines); ++k)
    options.lines.push_back({w.all[k].line, std::to_string(k + 1)});
  write_map(path, c, options, context);
}

void write_roughness_html(const std::string& path, const Roughness& r, const std::vector<ReportPicture>& pictures,
                          const std::string& json, const MapOptions& look, const Context& context) {
  context.check();
  write_text_atomically(path, Page(r, json).write_with_view(pictures, look, context));
}

}  // namespace isopach
