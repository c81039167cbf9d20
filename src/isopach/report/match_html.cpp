// report.html of `isopach match`: what the pose is, how good it is, what it rests on.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "isopach/io/output_file.hpp"
#include "isopach/report/match.hpp"
#include "isopach/report/page/moved.hpp"
#include "isopach/report/page/page.hpp"
#include "isopach/report/page/words.hpp"
#include "isopach/report/view/view_page.hpp"

namespace isopach {
namespace {

constexpr Typography fine = Typography::fine;
constexpr double degrees = 180 / std::numbers::pi;

class MatchPage : ViewPage {
 public:
  MatchPage(const Matching& m, const std::string& json) : ViewPage(json), m_(m), unit_(escaped(unit_text(m.unit))) {}

  std::string write(const MatchPictures& files) {
    const std::string title = input_name(m_.moving) + " on " + input_name(m_.fixed);
    open_page(title);
    out_ += "<h1>" + escaped(input_name(m_.moving)) + " <span>on</span> " + escaped(input_name(m_.fixed)) + "</h1>\n";
    verdict();
    lead();
    cards();
    warnings();
    out_ += view_place;
    pictures(files);
    history();
    pose();
    precision();
    evidence();
    quality();
    finish_page();
    return out_;
  }
  /// The same with the surfaces before and after, where they were compared.
  std::string write_with_view(const MatchPictures& files, const Context& context) {
    write(files);
    std::vector<ViewScene> scenes;
    if (m_.comparison_before) scenes.push_back({"before", &*m_.comparison_before});
    if (m_.comparison_after) scenes.push_back({"after", &*m_.comparison_after});
    const ViewWords words{"fixed scan", "moving scan", "moving scan above the fixed", "below it", true, ""};
    MapOptions look;
    look.vertices = files.vertices;
    return with_view(scenes, words, look, context);
  }

 private:
  void verdict() {
    if (m_.verdict)
      out_ += "<p class=\"lead\">The pose is <strong>" +
              escaped(message_text(sentence(*m_.verdict, unit_text(m_.unit)))) + "</strong>.</p>\n";
  }

  void lead() {
    out_ += "<p class=\"lead\">The pose turns the moving scan by " +
            datum("pose.angle_deg", number(value("pose.angle_deg"), fine)) + " degrees";
    if (m_.options.judge)
      out_ += " and takes the mean distance of the surfaces, |d| by area, from " + plain("before.rho") + " to " +
              plain("after.rho") + " " + unit_;
    out_ += m_.converged ? ". The search converged: " : ". <strong>The search did not converge</strong>: ";
    out_ += escaped(message_text(m_.reason)) + ".</p>\n";
    if (m_.unit == "unknown" || m_.unit.empty())
      out_ += "<p class=\"soft\">" + escaped(unit_sentence(m_.unit)) + "</p>\n";
  }

  void cards() {
    out_ += "<div class=\"cards\">\n";
    if (m_.options.judge) {
      card(plain("before.rho"), unit_, "mean |d| before");
      card(plain("after.rho"), unit_, "mean |d| after");
    }
    card(datum("pose.angle_deg", number(value("pose.angle_deg"), fine)), "°", "rotation");
    const Point3 shift = shift_of_centre(m_);
    card(number(std::hypot(shift.x, shift.y, shift.z), fine), unit_, "shift of its middle");
    card(percent("overlap"), "%", "of the common area fitted");
    out_ += "</div>\n";
  }

  void pictures(const MatchPictures& files) {
    if (!files.agreement.empty())
      picture(
          files.agreement, "Map of what agrees, lies in front or lies behind",
          "The moving scan in place: what agrees with the fixed scan, lies in front of it or behind it, and what is "
          "not in its view.");
    if (!files.before.empty())
      picture(
          files.before, "Map of the difference before the matching",
          "Before: B is the moving scan where it started, A the fixed one. Both maps show the same place in the same "
          "colours.");
    if (!files.after.empty())
      picture(files.after, "Map of the difference after the matching",
              "After: what is left is noise, real change, and what the sampling misses.");
  }

  void history() {
    const Json& steps = at("history");
    if (steps.size() < 2) return;
    constexpr double width = 960, height = 260, left = 90, right = 20, top = 16, bottom = 44;
    double low = INFINITY, high = -INFINITY;
    for (const Json& s : steps) {
      const double v = std::max(rho_of(s), 1e-300);
      low = std::min(low, v), high = std::max(high, v);
    }
    const bool is_wide = high > 3 * low;  // then a logarithmic axis
    const auto scaled = [&](double v) { return is_wide ? std::log10(std::max(v, 1e-300)) : v; };
    if (!is_wide) low = 0;  // no drama where little happens
    const double from = scaled(low), to = scaled(high), span = to > from ? to - from : 1;
    const auto x = [&](std::size_t i) {
      return left + (width - left - right) * static_cast<double>(i) / static_cast<double>(steps.size() - 1);
    };
    const auto y = [&](double v) { return top + (height - top - bottom) * (1 - (scaled(v) - from) / span); };
    out_ += fmt::format(
        "<h2>The search on all points</h2>\n<figure><svg viewBox=\"0 0 {} {}\" role=\"img\" "
        "aria-label=\"Mean distance of what is fitted after each accepted step\">\n",
        width, height);
    std::string line;
    for (std::size_t i = 0; i < steps.size(); ++i) line += fmt::format("{:.1f},{:.1f} ", x(i), y(rho_of(steps[i])));
    out_ += "<polyline fill=\"none\" stroke=\"var(--accent)\" stroke-width=\"2\" points=\"" + line + "\"/>\n";
    for (std::size_t i = 0; i < steps.size(); ++i)
      out_ += fmt::format(
          "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\" fill=\"var(--accent)\"><title>step {}: {} "
          "{}</title></circle>\n",
          x(i), y(rho_of(steps[i])), i, number(rho_of(steps[i]), fine, 6), unit_);
    for (const double v : {high, low})
      out_ += fmt::format(
          "<text x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\" fill=\"currentColor\" font-size=\"13\">{}</text>\n",
          left - 10, y(v) + 4, number(v, fine, 5));
    out_ +=
        fmt::format("<text x=\"{}\" y=\"{}\" fill=\"currentColor\" font-size=\"13\">start</text>\n", left, height - 16);
    out_ += fmt::format(
        "<text x=\"{}\" y=\"{}\" text-anchor=\"end\" fill=\"currentColor\" font-size=\"13\">step {}</text>\n</svg>\n",
        width - right, height - 16, steps.size() - 1);
    out_ += "<figcaption>Mean vertical distance (" + unit_ + (is_wide ? ", logarithmic" : "") +
            ") of the nodes that take part, after each accepted step. Steps on thinned copies came "
            "before.</figcaption></figure>\n";
  }

  void pose() {
    open_table("The pose", "", " class=\"pairs\"");
    const auto matrix = [&](const std::string& name, const std::string& key) {
      std::string rows;
      for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t j = 0; j < 4; ++j) {
          const std::string entry = fmt::format("{}.{}.{}", key, i, j);
          rows += (j > 0 ? "&emsp;" : "") + datum(entry, number(value(entry), fine, 10));
        }
        rows += "<br>";
      }
      out_ += "<tr><th scope=\"row\">" + name + "</th><td class=\"wrap\"><code>" + rows + "</code></td></tr>\n";
    };
    matrix("fixed = matrix · moving, row-major; last column in " + unit_ + ", the rest without unit", "pose.matrix");
    matrix("the same about the middle of the moving scan", "pose.local.matrix");
    std::string middle;
    for (std::size_t k = 0; k < 3; ++k)
      middle +=
          (k > 0 ? ", " : "") + datum(fmt::format("centre.{}", k), number(value(fmt::format("centre.{}", k)), fine, 8));
    out_ += "<tr><th scope=\"row\">that middle</th><td>" + middle + " " + unit_ + "</td></tr>\n";
    if (m_.options.freedom.scale)
      out_ += "<tr><th scope=\"row\">scale</th><td>" + datum("pose.scale", number(m_.scale, fine, 9)) + "</td></tr>\n";
    close_table();
  }

  void precision() {
    if (!precision_is_told(m_)) {
      out_ +=
          "<h2>How well it is held</h2>\n<p class=\"soft\">Not told: a precision speaks of errors near the right pose, "
          "and nothing shows that this one is.</p>\n";
      return;
    }
    open_table("How well it is held",
               "<th>motion</th><th class=\"n\">standard deviation</th><th></th><th>in words</th>", " class=\"told\"");
    constexpr std::array<const char*, 6> names{"turn about x",  "turn about y",  "turn about z",
                                               "shift along x", "shift along y", "shift along z"};
    for (std::size_t k = 0; k < 6; ++k) {
      const double variance = m_.covariance[7 * k];
      const double deviation = variance < 0 ? 0 : std::sqrt(variance) * (k < 3 ? degrees : 1);
      row(names[k], std::isnan(deviation) ? "undetermined" : number(deviation, fine, 2), k < 3 ? "°" : unit_, held(k));
    }
    close_table();
    out_ +=
        "<p class=\"soft\">" + correlation() +
        " They come from the residuals as they are, patch by patch; what the sampling of one scan misses everywhere in "
        "the same way is not in them.</p>\n";
    for (const std::string& weak : m_.weak_directions) out_ += "<p>" + escaped(message_text(weak)) + ".</p>\n";
  }

  // What a standard deviation means.
  [[nodiscard]] std::string held(std::size_t k) const {
    const double variance = m_.covariance[7 * k], deviation = variance < 0 ? 0 : std::sqrt(variance);
    if (std::isnan(variance)) return "the scans look the same after it: left as it was at the start";
    if (deviation == 0) return "not searched for";
    if (k >= 3) return "in two of three scans like these the true place is within this";
    return "moves a point at 100 " + unit_ + " from the axis by " + number(100 * deviation, fine, 2) + " " + unit_;
  }

  // The two motions that depend on each other most.
  [[nodiscard]] std::string correlation() const {
    constexpr std::array<const char*, 6> names{"turn about x",  "turn about y",  "turn about z",
                                               "shift along x", "shift along y", "shift along z"};
    double largest = 0;
    std::size_t first = 0, second = 0;
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t j = i + 1; j < 6; ++j) {
        const double scale = std::sqrt(m_.covariance[7 * i] * m_.covariance[7 * j]);
        const double c = scale > 0 ? m_.covariance[6 * i + j] / scale : 0;
        if (std::fabs(c) > std::fabs(largest)) largest = c, first = i, second = j;
      }
    if (std::fabs(largest) < 0.5) return "The errors of the six motions hardly depend on each other.";
    return fmt::format("The errors of {} and {} go together (correlation {}): one stands in for the other.",
                       names[first], names[second], number(largest, fine, 2));
  }

  void quality() {
    open_table("Behind the numbers", "", " class=\"told\"");
    if (m_.options.judge) {
      row("rms of d", plain("before.rms"), unit_, "before, by area");
      row("", plain("after.rms"), unit_, "after");
      row("coverage", percent("before.coverage"), "%", "before: area compared over the area of both scans together");
      row("", percent("after.coverage"), "%", "after");
    }
    row("stable points", whole("stable_points"), "",
        "points of the moving scan that were fitted; the rest differs more than noise");
    row("rms of what was fitted", plain("fitted_rms"), unit_, "of the distances that take part at the end");
    row("steps", whole("iterations"), "", "accepted, on thinned copies and on all points");
    close_table();
  }

  void evidence() {
    if (!m_.verdict) return;
    open_table("What the verdict rests on", "", " class=\"told\"");
    row("agrees", percent("verdict.agree"), "%", "of what both scans see, within their noise; needs 70 %");
    row("shape", plain("verdict.shape"), "", "correlation of the detail of their normals; needs 0.70");
    row("in view", percent("verdict.in_view.0"), "%", "of the moving scan, in the view of the fixed one");
    row("", percent("verdict.in_view.1"), "%", "of the fixed scan, in the view of the moving one");
    row("in front, behind", percent("verdict.in_front"), "%", "of what is in view: where the other scan saw through");
    row("", percent("verdict.behind"), "%", "of what is in view: where the other scan cannot have seen");
    row("noise", plain("verdict.noise.0"), unit_, "of the moving scan, from its own halves");
    row("", plain("verdict.noise.1"), unit_, "of the fixed scan");
    row("detail", plain("verdict.detail.0"), "", "of the moving scan: how well its halves repeat it; needs 0.5");
    row("", plain("verdict.detail.1"), "", "of the fixed scan");
    row("slip", plain("verdict.slip"), "",
        "noises that the distances rise by where the scan slips 1 % of its extent; needs 0.5, less of few points");
    close_table();
  }

  static double rho_of(const Json& step) {
    const Json& v = step.at("rho").is_number() ? step.at("rho") : step.at("rms");
    return v.is_number() ? v.get<double>() : 0;
  }

  const Matching& m_;
  std::string unit_;
};

}  // namespace

void write_match_html(const std::string& path, const Matching& m, const MatchPictures& pictures,
                      const std::string& json, const Context& context) {
  context.check();
  write_text_atomically(path, MatchPage(m, json).write_with_view(pictures, context));
}

}  // namespace isopach
