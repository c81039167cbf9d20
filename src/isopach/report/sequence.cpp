#include "isopach/report/sequence.hpp"

#include <fmt/format.h>

#include <numbers>

#include "isopach/base/median.hpp"
#include "isopach/io/write.hpp"
#include "isopach/report/page/values.hpp"
#include "isopach/report/page/words.hpp"
#include "isopach/version.hpp"

namespace isopach {
namespace {

using namespace values;
constexpr Typography ascii = Typography::plain;
constexpr double degrees = 180 / std::numbers::pi;

Json maybe_point(const std::optional<Point3>& p) { return p ? point(*p) : Json(nullptr); }

Json frame_json(const FrameMotion& f) {
  const bool used = f.skipped.empty();
  const auto if_used = [&](Json value) { return used ? std::move(value) : Json(nullptr); };
  Json screw = nullptr;
  if (f.screw)
    screw = {{"point", point(f.screw->point)},
             {"direction", point(f.screw->direction)},
             {"angle_deg", real(degrees * f.screw->angle)},
             {"slide", real(f.screw->slide)}};
  return {{"index", f.index},
          {"name", f.name},
          {"skipped", used ? Json(nullptr) : message(f.skipped)},
          {"time", real(f.time)},
          {"points", f.points},
          {"head", if_used(matrix(f.head))},
          {"motion", if_used(matrix(f.motion))},
          {"local", if_used(matrix(f.local))},
          {"opening_deg", if_used(real(degrees * f.opening))},
          {"opening_smooth_deg", if_used(real(degrees * f.opening_smooth))},
          {"angle_deg", if_used(real(degrees * f.angle))},
          {"screw", screw},
          {"point", if_used(point(f.chin))},
          {"point_smooth", if_used(point(f.chin_smooth))},
          {"excursion", if_used(real(f.excursion))},
          {"excursion_local", if_used(point(f.excursion_local))},
          {"hinge_point", if_used(point(f.hinge))},
          {"hinge_point_smooth", if_used(point(f.hinge_smooth))},
          {"rms_static", if_used(real(f.rms_static))},
          {"rms_moving", if_used(real(f.rms_moving))},
          {"support_static", if_used(real(f.support_static))},
          {"support_moving", if_used(real(f.support_moving))},
          {"sigma_angle_deg", if_used(real(degrees * f.sigma_angle))},
          {"sigma_shift", if_used(real(f.sigma_shift))}};
}

Json parameters_json(const SequenceResult& r) {
  const SequenceOptions& o = r.options;
  return {{"reference", o.reference},
          {"model_points", o.model_points},
          {"least_part", real(o.least_part)},
          {"static_at", maybe_point(o.static_at)},
          {"follow", maybe_point(o.follow)},
          {"smooth", real(o.smooth)},
          {"rate", o.rate > 0 ? real(o.rate) : Json(nullptr)},
          {"unit", r.unit}};
}

double median_of(const SequenceResult& r, double FrameMotion::*value) {
  std::vector<double> all;
  for (const FrameMotion& f : r.frames)
    if (f.skipped.empty()) all.push_back(f.*value);
  return median(all);
}

std::string place(const Point3& p) {
  return fmt::format("({}, {}, {})", number(p.x, ascii), number(p.y, ascii), number(p.z, ascii));
}

}  // namespace

std::string sequence_json(const SequenceResult& r, const std::vector<std::string>& outputs) {
  Json hinge = nullptr;
  if (r.hinge)
    hinge = {{"point", point(r.hinge->point)}, {"direction", point(r.hinge->direction)}, {"rest", real(r.hinge->rest)}};
  Json frames = Json::array();
  for (const FrameMotion& f : r.frames) frames.push_back(frame_json(f));
  const Json report = {{"schema", "isopach.sequence/1"},
                       {"tool", {{"name", tool_name}, {"version", version}}},
                       {"inputs",
                        {{"frames", r.frames.size()},
                         {"used", r.used},
                         {"reference",
                          {{"index", r.options.reference},
                           {"path", r.reference.path},
                           {"points", r.reference.points},
                           {"unit", r.reference.unit},
                           {"format", r.reference.format}}}}},
                       {"parameters", parameters_json(r)},
                       {"parts",
                        {{"points", r.points.size()},
                         {"static", r.points_static},
                         {"moving", r.points_moving},
                         {"between", r.points_between}}},
                       {"hinge", hinge},
                       {"local_frames", {{"static", matrix(r.static_frame)}, {"moving", matrix(r.moving_frame)}}},
                       {"point", point(r.chin)},
                       {"widest_deg", real(degrees * r.widest)},
                       {"farthest", real(r.farthest)},
                       {"frames", frames},
                       {"outputs", outputs},
                       {"warnings", messages(r.warnings)},
                       {"timing_s", timing(r.timing)}};
  return report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string sequence_text(const SequenceResult& r) {
  const std::string unit = unit_text(r.unit);
  std::string out = fmt::format("{} of {} frames: the moving part opens by {} degrees, the point goes {} {}\n", r.used,
                                r.frames.size(), number(degrees * r.widest, ascii), number(r.farthest, ascii), unit);
  line(out, "reference",
       fmt::format("frame {}, {}: {} points", r.options.reference, input_name(r.reference),
                   count(r.reference.points, ascii)));
  const auto share = [&](std::size_t n) {
    return fmt::format("{} ({} %)", count(n, ascii),
                       fixed_number(100.0 * static_cast<double>(n) / static_cast<double>(r.points.size()), 1, ascii));
  };
  line(out, "stay", share(r.points_static));
  line(out, "move", share(r.points_moving));
  line(out, "between", share(r.points_between));
  if (r.hinge)
    line(out, "hinge axis",
         fmt::format("through {} along {}; that point goes {} {} (RMS)", place(r.hinge->point),
                     place(r.hinge->direction), number(r.hinge->rest, ascii), unit));
  line(out, "point", fmt::format("{}, followed through all frames", place(r.chin)));
  line(out, "fit",
       fmt::format("{} {} from the surface where it stays, {} {} where it moves (RMS, the middle frame)",
                   number(median_of(r, &FrameMotion::rms_static), ascii), unit,
                   number(median_of(r, &FrameMotion::rms_moving), ascii), unit));
  line(out, "precision",
       fmt::format("{} degrees, {} {} (one standard deviation, the middle frame)",
                   number(degrees * median_of(r, &FrameMotion::sigma_angle), ascii, 2),
                   number(median_of(r, &FrameMotion::sigma_shift), ascii, 2), unit));
  line(
      out, "time",
      fmt::format("{:.2f} s, {:.3f} s a frame", r.timing.total, r.timing.total / static_cast<double>(r.frames.size())));
  for (const std::string& w : r.warnings) out += "warning: " + message_text(w) + "\n";
  return out;
}

std::string sequence_csv(const SequenceResult& r) {
  std::string out =
      "frame,time,opening_deg,opening_smooth_deg,angle_deg,excursion,aside,up,forward,x,y,z,x_smooth,y_smooth,z_smooth,"
      "hinge_x,hinge_y,hinge_z,hinge_x_smooth,hinge_y_smooth,hinge_z_smooth,rms_static,rms_moving,sigma_angle_deg,"
      "sigma_shift";
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) out += fmt::format(",m{}{}", i, j);
  out += "\n";
  for (const FrameMotion& f : r.frames) {
    if (!f.skipped.empty()) continue;
    out += fmt::format("{},{},{},{},{},{}", f.index, f.time, degrees * f.opening, degrees * f.opening_smooth,
                       degrees * f.angle, f.excursion);
    for (const Point3& p : {f.excursion_local, f.chin, f.chin_smooth, f.hinge, f.hinge_smooth})
      out += fmt::format(",{},{},{}", p.x, p.y, p.z);
    out += fmt::format(",{},{},{},{}", f.rms_static, f.rms_moving, degrees * f.sigma_angle, f.sigma_shift);
    for (const double v : f.motion.m) out += fmt::format(",{}", v);
    out += "\n";
  }
  return out;
}

void write_parts(const std::string& path, const SequenceResult& r, const Context& context) {
  Cloud out;
  out.points = r.points;
  out.unit = out.vertical_unit = r.unit;
  Attribute part{"part", Array<double>(r.label.size())};
  for (std::size_t i = 0; i < r.label.size(); ++i) part.values[i] = static_cast<double>(r.label[i]);
  out.attributes.push_back(std::move(part));
  out.attributes.push_back({"blend", r.blend});
  write_cloud(path, out, context);
}

}  // namespace isopach
