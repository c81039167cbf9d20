// report.html of `isopach distance`.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "isopach/report/distance.hpp"
#include "isopach/report/draw/canvas.hpp"
#include "isopach/report/draw/palette.hpp"
#include "isopach/report/page/page.hpp"
#include "isopach/report/page/words.hpp"
#include "isopach/report/view/space.hpp"
#include "isopach/report/view/view.hpp"

namespace isopach {
namespace {

constexpr Typography fine = Typography::fine;

/// What the colours show: of the measures asked for, the one that says most.
struct Shown {
  std::string key;  ///< in result.json: "m3c2.distance", "normal.a_to_b", …; empty: no distance of points
  std::string name;
  bool has_sign = false;
  Array<Point3> points;
  std::span<const double> values, levels;
  std::span<const std::array<Index, 3>> faces;
};

Shown with_faces(Shown shown, const Distances& d, const CloudView& a) {
  if (d.own_faces_a) shown.faces = a.faces;
  return shown;
}

Shown shown_of(const Distances& d, const CloudView& a) {
  if (d.m3c2 && d.m3c2->measured > 0)
    return {"m3c2.distance",        "M3C2 distance",   true, PointsView(d.m3c2->cores).copy(),
            d.m3c2->field.distance, d.m3c2->field.lod, {}};
  struct Measure {
    const char *field, *name;
    bool has_sign, is_measured;
  };
  for (const Measure& m :
       {Measure{"normal", "distance along the normal", true, d.normal && d.normal->a_to_b.count > 0},
        Measure{"vertical", "distance along the direction", true, d.vertical && d.vertical->a_to_b.count > 0},
        Measure{"c2s", "distance to the surface of B", false, d.c2s && d.c2s->a_to_b.count > 0},
        Measure{"c2c", "distance to the nearest point of B", false, d.c2c && d.c2c->a_to_b.count > 0}})
    for (const Attribute& field : d.fields_a)
      if (m.is_measured && field.name == m.field)
        return with_faces({std::string(m.field) + ".a_to_b", m.name, m.has_sign, a.points.copy(), field.values, {}, {}},
                          d, a);
  return {};
}

class DistancePage : HtmlPage {
 public:
  DistancePage(const Distances& d, const CloudView& a, const std::string& json)
      : HtmlPage(json), d_(d), shown_(shown_of(d, a)), unit_(escaped(unit_text(d.unit))) {
    // Along normals and the direction the other surface may be met far away: sizes are those to its closest place.
    const bool has_closest = d.c2s && d.c2s->a_to_b.count > 0 && !is_m3c2();
    sizes_ = has_closest ? "c2s.a_to_b" : shown_.key;
  }

  std::string write(const Context& context) {
    open_page("Distance from " + input_name(d_.a) + " to " + input_name(d_.b));
    head();
    warnings();
    std::string view;
    if (!shown_.key.empty()) view = surface(context);
    significance();
    table();
    surfaces();
    about();
    finish_page();
    add_view(view, view_policy());
    return out_;
  }

 private:
  [[nodiscard]] std::string length(const std::string& key) const { return plain(key) + "\u00a0" + unit_; }

  void head() {
    out_ += "<header>\n<h1>" + escaped(input_name(d_.a)) + " <span>and</span> " + escaped(input_name(d_.b)) + "</h1>\n";
    if (!shown_.key.empty()) lead();
    out_ += "</header>\n<div class=\"cards\">\n";
    if (!shown_.key.empty()) {
      if (shown_.has_sign) card(brief_sign(shown_.key + ".signed_mean"), unit_, "mean: the offset between the two");
      card(brief(sizes_ + ".rms"), unit_, "RMS: root of the mean of squares");
      card(brief(sizes_ + ".p95"), unit_, "95\u00a0% are within this");
      card(brief(sizes_ + ".max"), unit_, "largest distance of a point");
    }
    if (d_.hausdorff) card(brief("hausdorff.upper"), unit_, "no place of either surface is farther: Hausdorff, proven");
    out_ += "</div>\n";
  }

  void lead() {
    out_ += "<p class=\"lead\">";
    if (shown_.has_sign)
      out_ += "On average B lies " + brief_sign(shown_.key + ".signed_mean") + "\u00a0" + unit_ + " from A; ";
    else
      out_ += "The mean distance is " + brief(sizes_ + ".mean") + "\u00a0" + unit_ + "; ";
    out_ += "95\u00a0% of " + std::string(is_m3c2() ? "the core points are" : "A’s points are") + " within " +
            brief(sizes_ + ".p95") + "\u00a0" + unit_ + (sizes_ == "c2s.a_to_b" ? " of B’s surface" : "") +
            ", the farthest " + brief(sizes_ + ".max") + "\u00a0" + unit_ + ".</p>\n<p class=\"soft\">" +
            (shown_.has_sign ? "Mean and colours: " + escaped(shown_.name) +
                                   ", positive where B lies above A, or outside of a closed surface. "
                             : "Colours: " + escaped(shown_.name) + ", which has no sign. ") +
            "Lengths: " + unit_sentence(d_.unit) + ".</p>\n";
  }
  [[nodiscard]] bool is_m3c2() const { return shown_.key == "m3c2.distance"; }

  [[nodiscard]] SpaceScene scene() const {
    SpaceScene s;
    s.title = shown_.name + ", " + input_name(d_.a) + " to " + input_name(d_.b);
    s.unit = unit_text(d_.unit);
    s.points = shown_.points, s.values = shown_.values, s.levels = shown_.levels, s.faces = shown_.faces;
    s.parts = {{"A", "#999999"}};
    s.value_name = shown_.name, s.has_sign = shown_.has_sign;
    s.limit = space_limit(shown_.values);
    s.flip = paints_excess_red(d_.unit);
    // An object is looked at along the direction, ground from the side.
    const auto& r = d_.frame.rotation;
    s.upright.m = {r[0], r[1], r[2], 0, r[3], r[4], r[5], 0, r[6], r[7], r[8], 0, 0, 0, 0, 1};
    if (d_.unit == "mm") {
      s.azimuth = -18, s.elevation = 14;
    } else {
      s.upright.m = {r[0], r[1], r[2], 0, r[6], r[7], r[8], 0, -r[3], -r[4], -r[5], 0, 0, 0, 0, 1};
      s.azimuth = 25, s.elevation = 42;
    }
    return s;
  }

  std::string surface(const Context& context) {
    const SpaceScene s = scene();
    const SpaceSample sample = sample_space(s, default_space_points, context);
    if (sample.chosen.empty()) return "";
    out_ += "<h2>Where they differ</h2>\n" + std::string(view_place);
    const bool has_levels = !shown_.levels.empty();
    picture_of(
        png_of(space_picture(s, sample, 1400, 900)), "A, coloured by the " + shown_.name,
        legend(s) + "Points of A in their places, coloured by the " + escaped(shown_.name) +
            (has_levels ? "; light grey: within the level of detection" : "") + "; brown-grey: no distance there." +
            (sample.is_whole ? "" : " Of neighbouring points one is shown, and the farthest of each small region."));
    return space_view(s, sample);
  }

  /// A bar of the colours with its ends.
  [[nodiscard]] std::string legend(const SpaceScene& s) const {
    const Palette palette("blue-red", s.flip);
    std::string out =
        "<svg viewBox=\"0 0 420 40\" width=\"420\" style=\"max-width:100%;display:block\" role=\"img\" "
        "aria-label=\"Colours and distances\" font-size=\"13\">";
    constexpr int steps = 40;
    for (int i = 0; i < steps; ++i) {
      const double share = (i + 0.5) / steps;
      const Rgb c = palette(s.has_sign ? 2 * share - 1 : share);
      out += fmt::format("<rect x=\"{}\" y=\"2\" width=\"10.5\" height=\"16\" fill=\"#{:02x}{:02x}{:02x}\"/>",
                         10 + 10 * i, static_cast<int>(std::lround(255 * c.r)),
                         static_cast<int>(std::lround(255 * c.g)), static_cast<int>(std::lround(255 * c.b)));
    }
    const std::string low = s.has_sign ? signed_number(-s.limit, fine, 3) : "0";
    const std::string high = s.has_sign ? signed_number(s.limit, fine, 3) : number(s.limit, fine, 3);
    out += "<text x=\"10\" y=\"34\" fill=\"currentColor\">" + low + (s.has_sign ? " B below A" : "") +
           "</text><text x=\"410\" y=\"34\" text-anchor=\"end\" fill=\"currentColor\">" +
           (s.has_sign ? "B above A " : "") + high + " " + unit_ + "</text></svg>";
    return out;
  }

  void significance() {
    if (!d_.m3c2) return;
    open_table("Is it more than the noise? (M3C2)", "<th>name</th><th></th><th>unit</th><th>what it says</th>",
               " class=\"told\"");
    row("significant", whole("m3c2.significant"), "of " + whole("m3c2.with_lod"),
        "core points whose distance exceeds their level of detection, at 95\u00a0%");
    row("measured", whole("m3c2.measured"), "of " + whole("m3c2.cores"),
        "core points with points of both scans beside");
    if (d_.m3c2->with_lod > 0)
      row("level of detection", plain("m3c2.median_lod"), unit_, "in the median: smaller distances may be noise");
    if (d_.m3c2->measured > 0) {
      row("mean distance", with_sign("m3c2.distance.signed_mean"), unit_, "B less A, along the normals");
      row("standard deviation", plain("m3c2.distance.signed_std"), unit_, "about it");
      row("largest", plain("m3c2.distance.max"), unit_, "of the sizes");
    }
    close_table();
  }

  void figures(const char* key, const std::string& name, bool has_sign) {
    if (at(key).is_null()) return;
    for (const auto& [way, words] : {std::pair{"a_to_b", "A to B"}, std::pair{"b_to_a", "B to A"}}) {
      const std::string k = std::string(key) + "." + way;
      out_ += "<tr><th scope=\"row\">" + name + ", " + words + "</th>";
      for (const char* figure : {"mean", "rms", "median", "p95", "max"})
        out_ += "<td class=\"n\">" + (at(k + ".count") == 0 ? "–" : brief(k + "." + figure, 4)) + "</td>";
      out_ += "<td class=\"n\">" + (has_sign && at(k + ".count") != 0 ? brief_sign(k + ".signed_mean", 4) : "–") +
              "</td><td class=\"n\">" + whole(k + ".missing") + "</td></tr>\n";
    }
  }

  void table() {
    if (!d_.c2c && !d_.c2s && !d_.normal && !d_.vertical) return;
    open_table("Points, in " + unit_text(d_.unit),
               "<th>distance</th><th class=\"n\">mean</th><th class=\"n\">RMS</th><th class=\"n\">median</th><th "
               "class=\"n\">95\u00a0%</th><th class=\"n\">largest</th><th class=\"n\">with sign</th><th "
               "class=\"n\">points without</th>");
    figures("c2c", "to the nearest point", false);
    figures("c2s", "to the surface", false);
    figures("normal", "along the normal", true);
    figures("vertical", "along the direction", true);
    close_table();
    out_ +=
        "<p class=\"soft\">Sizes of the distances; with sign: the mean of B less A, where the distance has a "
        "sign.</p>\n";
  }

  void surfaces() {
    if (d_.surface) {
      open_table("Surfaces, by area", "<th>name</th><th></th><th>unit</th><th>what it says</th>", " class=\"told\"");
      for (const auto& [way, words] : {std::pair{"a_to_b", "A to B"}, std::pair{"b_to_a", "B to A"}}) {
        const std::string k = std::string("surface.") + way;
        row(std::string("mean, ") + words, plain(k + ".mean"), unit_,
            "± " + brief(k + ".mean_error", 2) + " of the sampling");
        row(std::string("RMS, ") + words, plain(k + ".rms"), unit_,
            "± " + brief(k + ".rms_error", 2) + " of the sampling");
      }
      close_table();
    }
    if (!d_.hausdorff) return;
    open_table("The farthest place of all (Hausdorff)",
               "<th>name</th><th class=\"n\">at least</th><th class=\"n\">at most</th><th>unit</th>");
    for (const auto& [way, words] :
         {std::pair{"", "both ways"}, std::pair{"a_to_b.", "A to B"}, std::pair{"b_to_a.", "B to A"}}) {
      const std::string k = std::string("hausdorff.") + way;
      out_ += std::string("<tr><th scope=\"row\">") + words + "</th><td class=\"n\">" + plain(k + "lower") +
              "</td><td class=\"n\">" + plain(k + "upper") + "</td><td>" + unit_ + "</td></tr>\n";
    }
    close_table();
  }

  void about() {
    open_table("What was measured",
               "<th></th><th>file</th><th class=\"n\">points</th><th class=\"n\">measured</th><th>surface</th>");
    for (std::size_t i = 0; i < 2; ++i) {
      const std::string k = fmt::format("inputs.{}.", i);
      out_ += std::string("<tr><th scope=\"row\">") + (i == 0 ? "A" : "B") + "</th><td class=\"wrap\">" +
              escaped(at(k + "path").get<std::string>()) + "</td><td class=\"n\">" + whole(k + "points") +
              "</td><td class=\"n\">" + whole(k + "measured") + "</td><td>" +
              (at(k + "surface").is_null()    ? "points alone"
               : at(k + "surface") == "faces" ? "faces of the file"
                                              : "triangulated (Delaunay)") +
              "</td></tr>\n";
    }
    close_table();
  }

  const Distances& d_;
  Shown shown_;
  std::string unit_;
  std::string sizes_;  ///< key of the figures without a sign
};

}  // namespace

std::string distance_html(const Distances& d, const CloudView& a, const std::string& json, const Context& context) {
  return DistancePage(d, a, json).write(context);
}

}  // namespace isopach
