#include "isopach/report/combine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "isopach/apps/face_pose.hpp"
#include "isopach/io/write.hpp"
#include "isopach/match/verdict/shape_detail.hpp"
#include "isopach/report/draw/chart.hpp"
#include "isopach/report/page/page.hpp"
#include "isopach/report/page/values.hpp"
#include "isopach/report/page/words.hpp"
#include "isopach/report/view/space.hpp"
#include "isopach/report/view/view.hpp"
#include "isopach/version.hpp"

namespace isopach {
namespace {

using namespace values;
constexpr Typography ascii = Typography::plain;
constexpr double degrees = 180 / std::numbers::pi;
constexpr std::array<const char*, 4> part_names{"face", "jaw", "reference_in_face", "reference_in_jaw"};

Json input_json(const InputSummary& in) {
  return {{"role", in.role}, {"path", in.path}, {"points", in.points}, {"unit", in.unit}, {"format", in.format}};
}

Json located_json(const LocatedReference& l) {
  return {{"matrix", matrix(l.pose)},
          {"rms", real(l.rms)},
          {"pairs", l.pairs},
          {"share", real(l.share)},
          {"covered", real(l.covered)},
          {"centre", point(l.centre)},
          {"covariance", covariance(l.covariance)},
          {"correlation", real(l.correlation)},
          {"slip", real(l.slip)}};
}

Json maybe_matrix(const std::optional<Pose>& pose) { return pose ? matrix(*pose) : Json(nullptr); }

std::string located_line(const LocatedReference& l, const std::string& unit) {
  return fmt::format("{} % of the object found, {} % of the scan is the object, fit {} {} (RMS)",
                     fixed_number(100 * l.share, 1, ascii), fixed_number(100 * l.covered, 1, ascii),
                     number(l.rms, ascii, 3), unit);
}

class CombinePage : HtmlPage {
 public:
  CombinePage(const Combination& c, const std::string& json) : HtmlPage(json), c_(c), unit_(unit_text(c.unit)) {}

  std::string write(const Context& context) {
    open_page(input_name(c_.face_input) + " with " + input_name(c_.jaw_input));
    head();
    warnings();
    pictures();
    numbers();
    pose();
    finish_page();
    add_view(model(context), view_policy());
    return out_;
  }

 private:
  /// Where the pose of the face is not found: the scan's plane faces the viewer, the side that it bulges to in front,
  /// and the jaw is below.
  [[nodiscard]] Pose facing() const {
    if (c_.counts[0] < 3 || c_.counts[1] == 0) return {};
    std::vector<Index> face;
    Point3 jaw{0, 0, 0};
    const double share = 1 / static_cast<double>(c_.counts[1]);
    for (std::size_t i = 0; i < c_.points.size(); ++i) {
      if (c_.part[i] == CombinedPart::face) face.push_back(static_cast<Index>(i));
      if (c_.part[i] != CombinedPart::jaw) continue;
      jaw = {jaw.x + share * c_.points[i].x, jaw.y + share * c_.points[i].y, jaw.z + share * c_.points[i].z};
    }
    const LocalPlane plane = plane_of(c_.points, face);
    const auto from_middle = [&](const Point3& p) {
      return Point3{p.x - plane.centre.x, p.y - plane.centre.y, p.z - plane.centre.z};
    };
    Point3 front = plane.normal;
    double mean = 0, rim = 0;  // of a surface that bulges, what is far from its middle lies behind
    for (const Index i : face)
      mean += dot(from_middle(c_.points[i]), from_middle(c_.points[i])) / static_cast<double>(face.size());
    for (const Index i : face) {
      const Point3 p = from_middle(c_.points[i]);
      rim += dot(front, p) * (dot(p, p) - mean);
    }
    if (rim > 0) front = {-front.x, -front.y, -front.z};
    jaw = from_middle(jaw);
    const double h = dot(front, jaw);
    Point3 up{h * front.x - jaw.x, h * front.y - jaw.y, h * front.z - jaw.z};
    const double size = std::sqrt(dot(up, up));
    if (!(size > 0)) return {};
    up = {up.x / size, up.y / size, up.z / size};
    const Point3 right{up.y * front.z - up.z * front.y, up.z * front.x - up.x * front.z,
                       up.x * front.y - up.y * front.x};
    Pose out;
    out.m = {right.x, right.y, right.z, 0, up.x, up.y, up.z, 0, front.x, front.y, front.z, 0, 0, 0, 0, 1};
    return out;
  }
  [[nodiscard]] static double dot(const Point3& a, const Point3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

  /// The model as the view has it, coloured by where its points are from.
  [[nodiscard]] std::string model(const Context& context) const {
    SpaceScene s;
    s.title = input_name(c_.face_input) + " with " + input_name(c_.jaw_input);
    s.unit = unit_text(c_.unit);
    s.points = c_.points;
    std::vector<unsigned char> parts;
    for (const CombinedPart part : c_.part) parts.push_back(static_cast<unsigned char>(part));
    s.part_of = parts;
    s.parts = {{"face", "#7fa6c9"},
               {"jaw", "#e0a070"},
               {"object in the face scan", "#8fbf8f"},
               {"object in the jaw scan", "#c7a3d1"}};
    s.azimuth = 25, s.elevation = 5;
    s.upright = face_ ? upright(*face_) : facing();
    return space_view(s, sample_space(s, default_space_points, context));
  }

  void head() {
    out_ += "<header>\n<h1>" + escaped(input_name(c_.face_input)) + " <span>with</span> " +
            escaped(input_name(c_.jaw_input)) + "</h1>\n<p class=\"lead\">By " +
            escaped(input_name(c_.reference_input)) +
            ", which is seen in both scans, the middle of the jaw lies in its place to within " +
            brief("uncertainty.sigma_middle", 2) + "\u00a0" + unit_ +
            " (one standard deviation).</p>\n<p class=\"soft\">The model is in coordinates of the face scan.</p>\n"
            "</header>\n<div class=\"cards\">\n";
    card(brief("uncertainty.sigma_middle", 2), unit_, "± at the middle of the jaw");
    card(brief("uncertainty.sigma_farthest", 2), unit_, "± at the jaw's farthest point");
    card(brief("uncertainty.sigma_angle_deg", 2), "°", "± of the turn");
    card(percent("face.share"), "%", "of the object found in the face scan");
    card(percent("jaw.share"), "%", "of the object found in the jaw scan");
    out_ += "</div>\n";
  }

  void pictures() {
    out_ += "<h2>The model</h2>\n" + std::string(view_place);
    face_ = face_of_model();
    const std::optional<FacePose>& face = face_;
    Array<Point3> places = c_.points;
    if (const Pose to_view = face ? upright(*face) : Pose{}; face)
      for (Point3& p : places) p = to_view.apply(p);
    const auto view = [&](const char* title, const char* across, const char* up, double Point3::*x, double Point3::*y) {
      Chart chart;
      chart.title = title;
      chart.x_label = std::string(across) + ", " + c_.unit;
      chart.y_label = std::string(up) + ", " + c_.unit;
      chart.equal_scales = true;
      for (std::size_t k = 0; k < part_names.size(); ++k) {
        ChartSeries s;
        s.name = part_names[k];
        std::replace(s.name.begin(), s.name.end(), '_', ' ');
        s.dots = true;
        const std::size_t step = std::max<std::size_t>(1, c_.counts[k] / 1500);
        std::size_t seen = 0;
        for (std::size_t i = 0; i < c_.points.size(); ++i)
          if (c_.part[i] == static_cast<CombinedPart>(k) && seen++ % step == 0)
            s.points.push_back({places[i].*x, places[i].*y});
        chart.series.push_back(std::move(s));
      }
      out_ += chart_svg(chart);
    };
    if (face) {
      view("Dots of all parts, from the front, R on the left", "from the midline to the patient's left",
           "up from the tip of the nose", &Point3::x, &Point3::y);
      view("Dots of all parts, from the side, the front on the right", "forwards", "up from the tip of the nose",
           &Point3::z, &Point3::y);
    } else {
      view("Dots of all parts along z of the face scan", "x", "y", &Point3::x, &Point3::y);
      view("Dots of all parts along x of the face scan", "z", "y", &Point3::z, &Point3::y);
    }
  }

  /// Of the face scan alone: jaw and object belong to no mean face.
  [[nodiscard]] std::optional<FacePose> face_of_model() const {
    Cloud scan;
    for (std::size_t i = 0; i < c_.points.size(); ++i)
      if (c_.part[i] == CombinedPart::face) scan.points.push_back(c_.points[i]);
    if (scan.points.empty()) return std::nullopt;
    FacePose pose = find_face(scan, {}, {});
    return pose.found() ? std::optional(std::move(pose)) : std::nullopt;
  }

  void numbers() {
    open_table("How the object was found",
               "<th></th><th class=\"n\">face</th><th class=\"n\">jaw</th><th>what it says</th>");
    const auto both_rows = [&](const std::string& name, const std::string& face, const std::string& jaw,
                               const char* why) {
      out_ += std::string("<tr><th scope=\"row\">") + name + "</th><td class=\"n\">" + face + "</td><td class=\"n\">" +
              jaw + "</td><td class=\"why\">" + why + "</td></tr>\n";
    };
    both_rows("found, %", percent("face.share"), percent("jaw.share"), "of the object's points lie on the scan");
    both_rows("covered, %", percent("face.covered"), percent("jaw.covered"), "of the scan's points lie on the object");
    both_rows("fit, " + unit_, plain("face.rms"), plain("jaw.rms"), "RMS distance of the pairs that take part");
    close_table();
  }

  void pose() {
    out_ += "<h2>From jaw to face</h2>\n<pre>";
    for (std::size_t i = 0; i < 4; ++i)
      out_ += fmt::format("{:>20.12g} {:>20.12g} {:>20.12g} {:>20.12g}\n", c_.face_jaw.m[4 * i],
                          c_.face_jaw.m[4 * i + 1], c_.face_jaw.m[4 * i + 2], c_.face_jaw.m[4 * i + 3]);
    out_ += "</pre>\n<p class=\"soft\">Row-major; takes coordinates of the jaw scan to those of the face scan.</p>\n";
  }

  const Combination& c_;
  std::string unit_;
  std::optional<FacePose> face_;
};

}  // namespace

std::string combine_json(const Combination& c, const std::vector<std::string>& outputs) {
  Json counts = Json::object();
  for (std::size_t k = 0; k < part_names.size(); ++k) counts[part_names[k]] = c.counts[k];
  const Json report = {
      {"schema", "isopach.combine/1"},
      {"tool", {{"name", tool_name}, {"version", version}}},
      {"inputs", Json::array({input_json(c.face_input), input_json(c.jaw_input), input_json(c.reference_input)})},
      {"parameters",
       {{"least_share", real(c.options.least_share)},
        {"start_face", maybe_matrix(c.options.start_face)},
        {"start_jaw", maybe_matrix(c.options.start_jaw)},
        {"unit", c.unit}}},
      {"pose", {{"convention", "face = matrix * jaw, row-major, input coordinates"}, {"matrix", matrix(c.face_jaw)}}},
      {"face", located_json(c.face)},
      {"jaw", located_json(c.jaw)},
      {"uncertainty",
       {{"covariance", covariance(c.covariance)},
        {"centre", point(c.centre)},
        {"sigma_angle_deg", real(degrees * c.sigma_angle)},
        {"jaw_middle", point(c.jaw_middle)},
        {"sigma_middle", real(c.sigma_middle)},
        {"sigma_farthest", real(c.sigma_farthest)}}},
      {"parts", counts},
      {"outputs", outputs},
      {"warnings", messages(c.warnings)},
      {"timing_s", timing(c.timing)}};
  return report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string combine_text(const Combination& c) {
  const std::string unit = unit_text(c.unit);
  std::string out = fmt::format("{} with {} by {}: the jaw's middle to within {} {} (one standard deviation)\n",
                                input_name(c.face_input), input_name(c.jaw_input), input_name(c.reference_input),
                                number(c.sigma_middle, ascii, 2), unit);
  line(out, "in the face", located_line(c.face, unit));
  line(out, "in the jaw", located_line(c.jaw, unit));
  line(out, "uncertainty",
       fmt::format("turn {} degrees; {} {} at the jaw's middle, {} {} at its farthest point",
                   number(degrees * c.sigma_angle, ascii, 2), number(c.sigma_middle, ascii, 2), unit,
                   number(c.sigma_farthest, ascii, 2), unit));
  for (std::size_t i = 0; i < 4; ++i)
    line(out, i == 0 ? "jaw to face" : "",
         fmt::format("{:>20.15g} {:>20.15g} {:>20.15g} {:>20.15g}", c.face_jaw.m[4 * i], c.face_jaw.m[4 * i + 1],
                     c.face_jaw.m[4 * i + 2], c.face_jaw.m[4 * i + 3]));
  line(out, "time", fmt::format("{:.2f} s", c.timing.total));
  for (const std::string& w : c.warnings) out += "warning: " + message_text(w) + "\n";
  return out;
}

std::string combine_html(const Combination& c, const std::string& json, const Context& context) {
  return CombinePage(c, json).write(context);
}

void write_combined(const std::string& path, const Combination& c, const Context& context) {
  Cloud out;
  out.points = c.points;
  out.unit = out.vertical_unit = c.unit;
  Attribute part{"part", Array<double>(c.part.size())};
  for (std::size_t i = 0; i < c.part.size(); ++i) part.values[i] = static_cast<double>(c.part[i]);
  out.attributes.push_back(std::move(part));
  write_cloud(path, out, context);
}

}  // namespace isopach
