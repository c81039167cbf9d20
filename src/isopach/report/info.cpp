#include "isopach/report/info.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "isopach/report/draw/canvas.hpp"
#include "isopach/report/page/page.hpp"
#include "isopach/report/page/words.hpp"
#include "isopach/report/view/space.hpp"
#include "isopach/report/view/view.hpp"

namespace isopach {
namespace {

constexpr Typography fine = Typography::fine;

/// Last part of a path, as input_name gives it.
std::string name_of(const std::string& path) {
  InputSummary in;
  in.path = path, in.role = "scan";
  return input_name(in);
}

class InfoPage : HtmlPage {
 public:
  explicit InfoPage(const std::string& record) : HtmlPage(record) {}

  std::string write(std::span<const Point3> points, const Context& context) {
    const Json& files = at("files");
    const std::string first = files.empty() ? "nothing" : name_of(at("files.0.path").get<std::string>());
    open_page("Contents of " + first);
    out_ += "<header>\n<h1>" + escaped(first) + (files.size() > 1 ? " <span>and others</span>" : "") + "</h1>\n";
    std::string view;
    if (!files.empty()) {
      lead();
      view = heights(first, points, context);
    } else {
      out_ += "</header>\n";
    }
    for (std::size_t i = 0; i < files.size(); ++i) file("files." + std::to_string(i) + ".");
    record();
    close_page();
    add_view(view, view_policy());
    return out_;
  }

 private:
  [[nodiscard]] std::string text(const std::string& key) const {
    return at(key).is_string() ? escaped(at(key).get<std::string>()) : std::string("none");
  }
  [[nodiscard]] std::string unit(const std::string& key) const {
    return escaped(unit_text(at(key).get<std::string>()));
  }

  void lead() {
    const std::string key = "files.0.";
    out_ += "<p class=\"lead\">" + whole(key + "points") + " points as " + text(key + "format") + ", " +
            escaped(unit_sentence(at(key + "unit").get<std::string>())) + ".</p>\n</header>\n<div class=\"cards\">\n";
    card(whole(key + "points"), "", "points");
    if (!at(key + "bounds").is_null())
      for (const auto& [axis, name, of] :
           {std::tuple{"0", "wide, along x", "unit"}, std::tuple{"1", "wide, along y", "unit"},
            std::tuple{"2", "from the lowest to the highest", "vertical_unit"}})
        card(number(value(key + "bounds.max." + axis) - value(key + "bounds.min." + axis), fine), unit(key + of), name);
    card(brief(key + "spacing"), unit(key + "unit"), "from a point to the next, about");
    out_ += "</div>\n";
  }

  std::string heights(const std::string& name, std::span<const Point3> points, const Context& context) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Point3& p : points)
      if (is_finite(p)) low = std::min(low, p.z), high = std::max(high, p.z);
    if (!(low <= high)) return "";
    const double middle = low + (high - low) / 2;
    Array<double> values(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) values[i] = points[i].z - middle;
    SpaceScene s;
    s.title = name + ", coloured by height";
    s.unit = unit_text(at("files.0.unit").get<std::string>());
    s.points = points, s.values = values;
    s.parts = {{name, "#999999"}};
    s.value_name = "height over the middle";
    s.has_sign = true, s.limit = (high - low) / 2;
    if (at("files.0.unit") == "mm") {  // an object is looked at along z, ground from the side
      s.azimuth = -18, s.elevation = 14;
    } else {
      s.upright.m = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1};
      s.azimuth = 25, s.elevation = 42;
    }
    const SpaceSample sample = sample_space(s, default_space_points, context);
    if (sample.chosen.empty()) return "";
    out_ += "<h2>The points</h2>\n" + std::string(view_place);
    picture_of(png_of(space_picture(s, sample, 1400, 900)), "Points of " + name + ", coloured by height",
               "Coloured by height, from " + number(low, fine, 6) + " to " + number(high, fine, 6) + "\u00a0" +
                   unit("files.0.vertical_unit") + "; white in the middle." +
                   (sample.is_whole ? "" : " Of neighbouring points one is shown."));
    return space_view(s, sample);
  }

  void file(const std::string& key) {
    open_table(escaped(name_of(at(key + "path").get<std::string>())),
               "<th>name</th><th></th><th>unit</th><th>what it says</th>", " class=\"told\"");
    row("points", whole(key + "points"), "", text(key + "format") + ", " + text(key + "path"));
    row("faces", whole(key + "faces"), "", "triangles of the file");
    if (!at(key + "bounds").is_null())
      for (const auto& [axis, name, of] :
           {std::tuple{"0", "x", "unit"}, std::tuple{"1", "y", "unit"}, std::tuple{"2", "z", "vertical_unit"}}) {
        const std::string least = key + "bounds.min." + axis, most = key + "bounds.max." + axis;
        const int decimals = decimals_for(value(most) - value(least));
        row(std::string(name) + ", least", datum(least, fixed_number(value(least), decimals, fine)), unit(key + of),
            "");
        row(std::string(name) + ", largest", datum(most, fixed_number(value(most), decimals, fine)), unit(key + of),
            "");
      }
    row("spacing", brief(key + "spacing"), unit(key + "unit"),
        "median distance to the nearest point in the plane, about");
    row("duplicates", whole(key + "duplicates"), "", "points with the x and y of another");
    row("layers", percent(key + "layered_share"), "%",
        "of the area with several surfaces above one another; 0 to compare");
    row("not finite", whole(key + "nonfinite"), "", "points left out");
    row("no data", whole(key + "nodata"), "", "of a raster");
    close_table();
    std::string names;
    for (const Json& attribute : at(key + "attributes"))
      names += (names.empty() ? "" : ", ") + escaped(attribute.get<std::string>());
    out_ += "<p class=\"soft\" style=\"overflow-wrap:anywhere\">Coordinate system: " + text(key + "crs") +
            ". Attributes: " + (names.empty() ? "none" : names) + ".</p>\n";
    for (const Json& note : at(key + "notes")) out_ += "<p>" + escaped(note.get<std::string>()) + "</p>\n";
  }

  void record() {
    out_ += "<h2>Everything, exactly</h2>\n<details><summary>result.json</summary><pre>";
    for (std::size_t i = 0, end = 0; i < text_.size(); i = end + 1) {
      end = std::min(text_.find('\n', i), text_.size());
      out_ += escaped(std::string_view(text_).substr(i, end - i)) + "\n";
    }
    out_ += "</pre></details>\n<footer>isopach · schema " + text("schema") +
            " · numbers on this page are rounded; point at one to see it in full</footer>\n";
  }
};

}  // namespace

std::string info_html(const std::string& record, std::span<const Point3> points, const Context& context) {
  context.check();
  return InfoPage(record).write(points, context);
}

}  // namespace isopach
