// report.html of `isopach sequence`: plots, and an animation that is drawn frame by frame: groups of dots that take
// turns by a style rule.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "isopach/apps/face_pose.hpp"
#include "isopach/apps/motions.hpp"
#include "isopach/report/draw/chart.hpp"
#include "isopach/report/page/page.hpp"
#include "isopach/report/page/words.hpp"
#include "isopach/report/sequence.hpp"
#include "isopach/report/view/space.hpp"
#include "isopach/report/view/view.hpp"

namespace isopach {
namespace {

constexpr Typography fine = Typography::fine;
constexpr double degrees = 180 / std::numbers::pi;
constexpr std::size_t dots_static = 1500, dots_moving = 700, most_frames = 90;
constexpr double view = 480;  // pixels, either way

class SequencePage : HtmlPage {
 public:
  SequencePage(const SequenceResult& r, const std::string& json)
      : HtmlPage(json), r_(r), unit_(unit_text(r.unit)), to_view_(inverted(r.static_frame)) {
    stand_up();
  }

  std::string write(const Context& context) {
    open_page("Motion of " + input_name(r_.reference));
    head();
    warnings();
    animation();
    plots();
    paths();
    parts();
    table();
    finish_page();
    add_view(surface(context), view_policy());
    return out_;
  }

 private:
  /// The reference frame as the view has it: its points, once, and the motion of each frame as a matrix.
  [[nodiscard]] std::string surface(const Context& context) const {
    SpaceScene s;
    s.title = "Motion of " + input_name(r_.reference);
    s.unit = unit_text(r_.unit);
    s.points = r_.points, s.blend = r_.blend;
    std::vector<unsigned char> parts;
    for (const PartLabel label : r_.label) parts.push_back(static_cast<unsigned char>(label));
    s.part_of = parts;
    s.parts = {{"stays", "#7fa6c9"}, {"moves", "#e0a070"}, {"between", "#cfc6b4"}};
    for (const FrameMotion* f : used())
      s.frames.push_back(
          {fmt::format("frame {} ({}): opening {}°, excursion {} {}", f->index, f->name,
                       fixed_number(degrees * f->opening, 1, fine), number(f->excursion, fine, 3), s.unit),
           f->motion});
    if (r_.options.rate > 0) s.second = std::clamp(1 / r_.options.rate, 0.02, 1.0);
    s.upright = to_view_;
    s.azimuth = 25, s.elevation = 5;
    return space_view(s, sample_space(s, default_space_points, context));
  }

  void head() {
    out_ += "<header>\n<h1>" + escaped(input_name(r_.reference)) + " <span>and " + whole("inputs.frames") +
            " frames</span></h1>\n<p class=\"lead\">The moving part opens by " +
            datum("widest_deg", number(value("widest_deg"), fine)) +
            "° at the widest; the point that is followed goes " + plain("farthest") + "\u00a0" + unit_ +
            " from where it is in the reference frame.</p>\n" +
            "<p class=\"soft\">Angles and ways are relative to frame " + whole("inputs.reference.index") +
            ". The part that stays is held where it is in that frame.</p>\n</header>\n<div class=\"cards\">\n";
    card(datum("widest_deg", number(value("widest_deg"), fine)), "°", "widest opening");
    card(plain("farthest"), unit_, "farthest excursion of the point");
    card(whole("inputs.used"), "of " + whole("inputs.frames"), "frames used");
    card(whole("parts.moving"), "of " + whole("parts.points"), "points of the reference move");
    if (r_.hinge) card(plain("hinge.rest"), unit_, "way of the hinge axis (RMS)");
    out_ += "</div>\n";
  }

  [[nodiscard]] std::vector<const FrameMotion*> used() const {
    std::vector<const FrameMotion*> all;
    for (const FrameMotion& f : r_.frames)
      if (f.skipped.empty()) all.push_back(&f);
    return all;
  }

  /// Where the reference shows a face, it is seen upright from its front and from its left; else along the hinge axis.
  void stand_up() {
    Cloud reference;
    reference.points = r_.points;
    if (reference.points.empty()) return;
    const FacePose face = find_face(reference, {}, {});
    if (!face.found()) return;
    to_view_ = upright(face);
    front_ = "from the front, R on the left", side_ = "from the side";
  }

  // --- the animation ------------------------------------------------------------------------------------------------

  /// Places in a view, in the axes of the static frame.
  struct View {
    const char* name;
    bool side;
    double left;
    Box2 box;
    double scale;
    [[nodiscard]] Point2 across(const Point3& p) const { return side ? Point2{p.z, p.y} : Point2{p.x, p.y}; }
    [[nodiscard]] std::string dot(const Point3& p) const {
      const Point2 q = across(p);
      return fmt::format("M{:.0f} {:.0f}h0", left + (q.x - box.min.x) * scale, 20 + (box.max.y - q.y) * scale);
    }
  };

  struct Dots {
    std::vector<Point3> still, moving;  // still: static axes; moving: reference coordinates
    std::vector<double> blend;
  };

  [[nodiscard]] Dots choose_dots(const Pose& to_static) const {
    Dots dots;
    const std::size_t step_static = std::max<std::size_t>(1, r_.points_static / dots_static);
    const std::size_t step_moving = std::max<std::size_t>(1, (r_.points_moving + r_.points_between) / dots_moving);
    std::size_t a = 0, b = 0;
    for (std::size_t i = 0; i < r_.points.size(); ++i) {
      if (r_.label[i] == PartLabel::still) {
        if (a++ % step_static == 0) dots.still.push_back(to_static.apply(r_.points[i]));
      } else if (b++ % step_moving == 0) {
        dots.moving.push_back(r_.points[i]);
        dots.blend.push_back(r_.label[i] == PartLabel::moving ? 1 : r_.blend[i]);
      }
    }
    return dots;
  }

  [[nodiscard]] static Point3 at_frame(const Pose& to_static, const FrameMotion& f, const Point3& p, double blend) {
    const Point3 q = f.motion.apply(p);
    return to_static.apply({p.x + blend * (q.x - p.x), p.y + blend * (q.y - p.y), p.z + blend * (q.z - p.z)});
  }

  void animation() {
    const std::vector<const FrameMotion*> all = used();
    const std::size_t every = (all.size() + most_frames - 1) / most_frames;
    std::vector<const FrameMotion*> shown;
    for (std::size_t k = 0; k < all.size(); k += every) shown.push_back(all[k]);
    const Pose& to_static = to_view_;
    const Dots dots = choose_dots(to_static);
    Box3 box;
    for (const Point3& p : dots.still) box.add(p);
    for (const FrameMotion* f : shown)
      for (std::size_t i = 0; i < dots.moving.size(); ++i)
        box.add(at_frame(to_static, *f, dots.moving[i], dots.blend[i]));
    if (box.empty()) return;
    const double extent = std::max({box.max.x - box.min.x, box.max.y - box.min.y, box.max.z - box.min.z});
    const double scale = view / (extent > 0 ? extent : 1);
    const std::array<View, 2> views{View{front_, false, 10, {{box.min.x, box.min.y}, {box.max.x, box.max.y}}, scale},
                                    View{side_, true, 510, {{box.min.z, box.min.y}, {box.max.z, box.max.y}}, scale}};
    const double second =
        r_.options.rate > 0 ? std::clamp(static_cast<double>(every) / r_.options.rate, 0.04, 0.5) : 0.1;
    const double cycle = second * static_cast<double>(shown.size());
    out_ += "<h2>The motion</h2>\n" + std::string(view_place) +
            "<figure><svg viewBox=\"0 0 1000 520\" role=\"img\" aria-label=\"Animation of the parts, "
            "seen from two sides\" font-size=\"13\">\n<style>";
    out_ += fmt::format(
        ".turn{{visibility:hidden;animation:turn {:.3g}s steps(1) infinite}}@keyframes "
        "turn{{0%{{visibility:visible}}{:.4g}%,100%{{visibility:hidden}}}}.turn.first{{visibility:visible}}"
        "@media(prefers-reduced-motion:reduce){{.turn{{animation:none}}}}@media "
        "print{{.turn{{animation:none}}}}</style>\n",
        cycle, 100.0 / static_cast<double>(shown.size()));
    for (const View& v : views) draw_still(v, dots);
    for (std::size_t k = 0; k < shown.size(); ++k) draw_frame(*shown[k], k, second, views, dots, to_static);
    out_ +=
        "</svg>\n<figcaption>Dots of the reference frame, carried along with the two parts: blue stays, orange moves "
        "or is in between.";
    if (every > 1) out_ += fmt::format(" Every {}. frame is shown.", every);
    out_ += "</figcaption></figure>\n";
  }

  void draw_still(const View& v, const Dots& dots) {
    out_ += fmt::format("<text x=\"{}\" y=\"14\" fill=\"currentColor\">{}</text>\n<path d=\"", v.left, v.name);
    for (const Point3& p : dots.still) out_ += v.dot(p);
    out_ += "\" stroke=\"#0072b2\" stroke-width=\"3\" stroke-linecap=\"round\" fill=\"none\"/>\n";
  }

  void draw_frame(const FrameMotion& f, std::size_t k, double second, const std::array<View, 2>& views,
                  const Dots& dots, const Pose& to_static) {
    out_ += fmt::format("<g class=\"turn{}\" style=\"animation-delay:{:.3g}s\"><path d=\"", k == 0 ? " first" : "",
                        second * static_cast<double>(k));
    for (const View& v : views)
      for (std::size_t i = 0; i < dots.moving.size(); ++i)
        out_ += v.dot(at_frame(to_static, f, dots.moving[i], dots.blend[i]));
    out_ += fmt::format(
        "\" stroke=\"#d55e00\" stroke-width=\"3\" stroke-linecap=\"round\" fill=\"none\"/><text x=\"990\" y=\"14\" "
        "text-anchor=\"end\" fill=\"currentColor\">frame {}: {}°</text></g>\n",
        f.index, fixed_number(degrees * f.opening, 1, fine));
  }

  // --- plots
  // ----------------------------------------------------------------------------------------------------------

  template <class Value>
  [[nodiscard]] ChartSeries series(const std::string& name, bool dots, Value&& value) const {
    ChartSeries s;
    s.name = name, s.dots = dots;
    for (const FrameMotion& f : r_.frames)
      s.points.push_back(f.skipped.empty() ? Point2{f.time, value(f)} : Point2{std::nan(""), std::nan("")});
    return s;
  }

  void plots() {
    const std::string time = r_.options.rate > 0 ? "time, s" : "frame";
    out_ += "<h2>Against time</h2>\n";
    out_ += chart_svg({"Opening: turn about the hinge axis",
                       time,
                       "opening, °",
                       {series("as measured", true, [](const FrameMotion& f) { return degrees * f.opening; }),
                        series("smooth", false, [](const FrameMotion& f) { return degrees * f.opening_smooth; })}});
    out_ +=
        chart_svg({"Excursion of the point: how far it is from its place in the reference frame, and along each axis",
                   time,
                   "excursion, " + r_.unit,
                   {series("distance", false, [](const FrameMotion& f) { return f.excursion; }),
                    series("aside", false, [](const FrameMotion& f) { return f.excursion_local.x; }),
                    series("up", false, [](const FrameMotion& f) { return f.excursion_local.y; }),
                    series("forward", false, [](const FrameMotion& f) { return f.excursion_local.z; })}});
  }

  void paths() {
    const Pose& to_static = to_view_;
    const Point3 chin = r_.chin, hinge = r_.hinge ? r_.hinge->point : Point3{0, 0, 0};
    const auto path = [&](const char* name, const Point3 FrameMotion::*place, const Point3& from, bool side) {
      ChartSeries s;
      s.name = name;
      s.dots = std::string_view(name) == "as measured";
      for (const FrameMotion& f : r_.frames) {
        if (!f.skipped.empty()) continue;
        const Point3& p = f.*place;
        const Point3 q = turned(to_static, {p.x - from.x, p.y - from.y, p.z - from.z});
        s.points.push_back(side ? Point2{q.z, q.y} : Point2{q.x, q.y});
      }
      return s;
    };
    out_ += "<h2>Paths</h2>\n";
    const std::string aside = "aside, " + r_.unit, up = "up, " + r_.unit, forward = "forward, " + r_.unit;
    out_ += chart_svg(
        {std::string("Path of the point, ") + front_,
         aside,
         up,
         {path("as measured", &FrameMotion::chin, chin, false), path("smooth", &FrameMotion::chin_smooth, chin, false)},
         true});
    out_ += chart_svg(
        {std::string("Path of the point, ") + side_,
         forward,
         up,
         {path("as measured", &FrameMotion::chin, chin, true), path("smooth", &FrameMotion::chin_smooth, chin, true)},
         true});
    if (!r_.hinge) return;
    out_ += chart_svg({std::string("Path of the hinge axis, ") + side_,
                       forward,
                       up,
                       {path("as measured", &FrameMotion::hinge, hinge, true),
                        path("smooth", &FrameMotion::hinge_smooth, hinge, true)},
                       true});
    out_ +=
        "<p class=\"soft\">The hinge axis is the line of the moving part that moves least over all frames: where this "
        "motion has its hinge, which need not be where the joint is.</p>\n";
  }

  void parts() {
    open_table("The parts", "<th>part</th><th class=\"n\">points</th><th></th><th>what it is</th>", " class=\"told\"");
    row("stays", whole("parts.static"), "", "moves with the larger frame of reference, the head");
    row("moves", whole("parts.moving"), "", "moves as a second rigid body, the jaw");
    row("between", whole("parts.between"), "", "follows both: skin that stretches");
    close_table();
  }

  void table() {
    open_table("Frame by frame",
               "<th>frame</th><th class=\"n\">opening, °</th><th class=\"n\">excursion, " + unit_ +
                   "</th><th class=\"n\">fit, stays</th><th class=\"n\">fit, moves</th><th class=\"n\">± °</th><th "
                   "class=\"n\">± " +
                   unit_ + "</th>");
    for (std::size_t k = 0; k < r_.frames.size(); ++k) {
      const std::string key = fmt::format("frames.{}.", k);
      out_ += "<tr><th scope=\"row\">" + escaped(r_.frames[k].name) + "</th>";
      if (!r_.frames[k].skipped.empty()) {
        out_ +=
            "<td class=\"wrap\" colspan=\"6\">skipped: " + escaped(message_text(r_.frames[k].skipped)) + "</td></tr>\n";
        continue;
      }
      for (const char* name :
           {"opening_deg", "excursion", "rms_static", "rms_moving", "sigma_angle_deg", "sigma_shift"})
        out_ += "<td class=\"n\">" + datum(key + name, number(value(key + name), fine, 3)) + "</td>";
      out_ += "</tr>\n";
    }
    close_table();
    out_ +=
        "<p class=\"soft\">Fit: RMS distance of the part's points from the frame's surface. ±: one standard deviation "
        "of the motion, from that distance.</p>\n";
  }

  const SequenceResult& r_;
  std::string unit_;
  Pose to_view_;  ///< x to the right of the picture, y up, z to the viewer
  const char *front_ = "across the hinge axis", *side_ = "along the hinge axis";
};

}  // namespace

std::string sequence_html(const SequenceResult& r, const std::string& json, const Context& context) {
  return SequencePage(r, json).write(context);
}

}  // namespace isopach
