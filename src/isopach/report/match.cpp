#include "isopach/report/match.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "isopach/io/write.hpp"
#include "isopach/report/page/alignment_values.hpp"
#include "isopach/report/page/moved.hpp"
#include "isopach/report/page/verdict_values.hpp"
#include "isopach/report/page/words.hpp"
#include "isopach/version.hpp"

namespace isopach {
namespace {

using namespace values;
constexpr Typography plain = Typography::plain;

const char* to_text(Objective objective) {
  switch (objective) {
    case Objective::measure:
      return "measure";
    case Objective::icp_point:
      return "icp-point";
    case Objective::icp_plane:
      return "icp-plane";
    case Objective::icp_gicp:
      return "icp-gicp";
    case Objective::currents:
      return "currents";
  }
  return "measure";
}

/// How the pose moves the centre.
Point3 shift_at(const Pose& pose, const Point3& centre) {
  const Point3 p = pose.apply(centre);
  return {p.x - centre.x, p.y - centre.y, p.z - centre.z};
}

/// The angle of the pose's rotation, degrees.
double angle_of(const Matching& m) {
  const auto& r = m.pose.m;
  const double s = m.scale;
  const double sine = std::hypot(r[9] - r[6], r[2] - r[8], r[4] - r[1]) / (2 * s);
  const double cosine = ((r[0] + r[5] + r[10]) / s - 1) / 2;
  return std::atan2(sine, cosine) * 180 / std::numbers::pi;
}

Json pose_json(const Matching& m) {
  Pose local = m.pose;
  const Point3 shift = shift_at(m.pose, m.centre);
  local.m[3] = shift.x, local.m[7] = shift.y, local.m[11] = shift.z;
  return {{"convention", "fixed = matrix * moving, row-major, input coordinates"},
          {"matrix", matrix(m.pose)},
          {"scale", real(m.scale)},
          {"angle_deg", real(angle_of(m))},
          {"local", {{"origin", point(m.centre)}, {"matrix", matrix(local)}}}};
}

Json pairs_json(const Matching& m) {
  if (!of_pairs(m.options.objective)) return nullptr;
  const IcpOptions& o = m.options.icp;
  const Json distance =
      o.reject_distance_absolute ? real(o.reject_distance) : Json(fmt::format("{}x", o.reject_distance));
  return {{"reject_distance", o.reject_distance > 0 ? distance : Json(nullptr)},
          {"reject_normal_deg", o.reject_normal > 0 ? real(o.reject_normal) : Json(nullptr)},
          {"reject_boundary", o.reject_boundary},
          {"weights", o.weights == IcpOptions::Weights::tukey ? "tukey" : "uniform"},
          {"one_to_one", o.one_to_one},
          {"symmetric", o.symmetric}};
}

Json parameters_json(const Matching& m) {
  const MatchOptions& o = m.options;
  const CompareOptions& c = o.compare;
  return {{"start", matrix(o.start)},
          {"coarse", o.coarse},
          {"freedom", freedom(o.freedom)},
          {"overlap", o.overlap > 0 ? real(o.overlap) : Json("auto")},
          {"max_iterations", o.max_iterations},
          {"tolerance", real(o.tolerance > 0 ? o.tolerance : default_match_tolerance)},
          {"pairs", pairs_json(m)},
          {"pose_only", !o.judge},
          {"accept_doubt", o.accept_doubt},
          {"weight", text_or_null(to_text(c.weight))},
          {"sigma", o.sigma > 0 ? real(o.sigma) : Json(nullptr)},
          {"border", to_text(c.border)},
          {"folds", to_text(c.folds)},
          {"max_edge", c.max_edge > 0 ? real(c.max_edge) : Json(nullptr)},
          {"duplicates", to_text(c.project.duplicates)},
          {"direction_rule", to_text(c.project.direction.kind)},
          {"class", c.project.classes.empty() ? Json(nullptr) : Json(c.project.classes)},
          {"crop", crop_box(c.project.crop)},
          {"unit", m.unit},
          {"allow_crs", c.allow_crs}};
}

Json fit_json(const Fit& f) { return {{"rho", real(f.rho)}, {"rms", real(f.rms)}, {"coverage", real(f.coverage)}}; }

std::size_t stable_points(const Matching& m) {
  return static_cast<std::size_t>(std::count(m.stable.begin(), m.stable.end(), 1));
}

std::string fit_line(const Fit& f, const std::string& unit) {
  return fmt::format("rho {} {}, rms {} {}, coverage {} %", number(f.rho, plain), unit, number(f.rms, plain), unit,
                     fixed_number(100 * f.coverage, 1, plain));
}

/// ", rms 0.03 mm of their distances": of what takes part at the end of the search.
std::string fitted_rms(const Matching& m, const std::string& unit) {
  if (m.history.empty() || !std::isfinite(m.history.back().rms)) return "";
  return fmt::format(", rms {} {} of their distances", number(m.history.back().rms, plain), unit);
}

/// Standard deviations of the three turns, or of the three shifts; NaN where the scans do not determine them.
std::array<double, 3> deviations(const Matching& m, std::size_t first) {
  std::array<double, 3> d{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double variance = m.covariance[7 * (first + i)];
    d[i] = variance < 0 ? 0 : std::sqrt(variance);
  }
  return d;
}

std::string precision(double deviation) { return std::isnan(deviation) ? "undetermined" : number(deviation, plain, 2); }

Json undetermined_json(const Matching& m) {
  Json motions = Json::array();
  for (const auto& motion : m.undetermined) {
    Json numbers = Json::array();
    for (const double v : motion) numbers.push_back(real(v));
    motions.push_back(numbers);
  }
  return motions;
}

}  // namespace

Point3 shift_of_centre(const Matching& m) { return shift_at(m.pose, m.centre); }

std::string match_json(const Matching& m, const std::vector<std::string>& outputs) {
  Json history = Json::array();
  for (const MatchStep& s : m.history)
    history.push_back({{"rho", real(s.rho)}, {"rms", real(s.rms)}, {"share", real(s.share)}});
  const Json report = {
      {"schema", "isopach.match/1"},
      {"tool", {{"name", tool_name}, {"version", version}}},
      {"inputs", Json::array({aligned_input(m.moving, m.moving.role), aligned_input(m.fixed, m.fixed.role)})},
      {"verdict", verdict_json(m.verdict, m.unit)},
      {"objective", to_text(m.options.objective)},
      {"parameters", parameters_json(m)},
      {"pose", pose_json(m)},
      {"iterations", m.iterations},
      {"converged", m.converged},
      {"reason", message(m.reason)},
      {"history", history},
      {"before", fit_json(m.before)},
      {"after", fit_json(m.after)},
      {"overlap", real(m.overlap)},
      {"nominal", {{"moving", m.nominal_moving}, {"fixed", m.nominal_fixed}}},
      {"stable_points", stable_points(m)},
      {"fitted_rms", m.history.empty() ? Json(nullptr) : real(m.history.back().rms)},
      {"covariance", precision_is_told(m) ? covariance(m.covariance) : Json(nullptr)},
      {"undetermined", undetermined_json(m)},
      {"centre", point(m.centre)},
      {"weak_directions", messages(m.weak_directions)},
      {"outputs", outputs},
      {"warnings", messages(m.warnings)},
      {"timing_s", timing(m.timing)}};
  return report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string match_text(const Matching& m) {
  const std::string unit = unit_text(m.unit);
  std::string out = fmt::format("{} on {}", input_name(m.moving), input_name(m.fixed));
  if (m.options.judge)
    out += fmt::format(": mean |d| (rho) {} {}, before {} {}", number(m.after.rho, plain), unit,
                       number(m.before.rho, plain), unit);
  out += "\n";
  if (m.verdict) line(out, "verdict", message_text(sentence(*m.verdict, unit)));
  for (const InputSummary* in : {&m.moving, &m.fixed})
    line(out, in->role.c_str(), fmt::format("{}: {} points", input_name(*in), count(in->points, plain)));
  if (m.options.judge) {
    line(out, "before", fit_line(m.before, unit));
    line(out, "after", fit_line(m.after, unit));
  }
  const Point3 shift = shift_at(m.pose, m.centre);
  line(out, "rotation", fmt::format("{} degrees", number(angle_of(m), plain, 6)));
  line(out, "shift",
       fmt::format("{}, {}, {} {} at the middle of the moving scan", signed_number(shift.x, plain, 6),
                   signed_number(shift.y, plain, 6), signed_number(shift.z, plain, 6), unit));
  if (m.options.freedom.scale) line(out, "scale", number(m.scale, plain, 9));
  const auto turns = deviations(m, 0), shifts = deviations(m, 3);
  const double degrees = 180 / std::numbers::pi;
  if (precision_is_told(m))
    line(out, "precision",
         fmt::format("{}, {}, {} degrees about x, y, z; {}, {}, {} {} along them (one standard deviation)",
                     precision(degrees * turns[0]), precision(degrees * turns[1]), precision(degrees * turns[2]),
                     precision(shifts[0]), precision(shifts[1]), precision(shifts[2]), unit));
  line(out, "fitted",
       fmt::format("{} % of the common area, {} points{}; the rest differs more than noise",
                   fixed_number(100 * m.overlap, 1, plain), count(stable_points(m), plain), fitted_rms(m, unit)));
  if (m.nominal_moving || m.nominal_fixed)
    line(out, "nominal mesh",
         fmt::format(
             "{}: the points of the other lie on its facets, so these are the surface, and its corners no points",
             input_name(m.nominal_moving ? m.moving : m.fixed)));
  line(out, "search",
       fmt::format("{} steps, {}: {}", m.iterations, m.converged ? "converged" : "NOT converged",
                   message_text(m.reason)));
  for (std::size_t i = 0; i < 4; ++i)
    line(out, i == 0 ? "pose" : "",
         fmt::format("{:>20.15g} {:>20.15g} {:>20.15g} {:>20.15g}", m.pose.m[4 * i], m.pose.m[4 * i + 1],
                     m.pose.m[4 * i + 2], m.pose.m[4 * i + 3]));
  if (m.unit == "unknown" || m.unit.empty()) line(out, "units", unit_sentence(m.unit));
  line(out, "time", fmt::format("{:.2f} s", m.timing.total));
  for (const std::string& w : m.warnings) out += "warning: " + message_text(w) + "\n";
  return out;
}

std::string pose_text(const Pose& pose) {
  std::string text;
  for (std::size_t i = 0; i < 16; i += 4)
    text += fmt::format("{} {} {} {}\n", pose.m[i], pose.m[i + 1], pose.m[i + 2], pose.m[i + 3]);
  return text;
}

void write_moved(const std::string& path, const CloudView& moving, const Matching& m, const Context& context) {
  Cloud out;
  out.points = moving.points.copy();
  for (Point3& p : out.points) p = m.pose.apply(p);
  out.unit = moving.unit;
  out.vertical_unit = moving.vertical_unit;
  out.crs = moving.crs;
  Attribute stable{"stable", Array<double>(m.stable.size())};
  std::copy(m.stable.begin(), m.stable.end(), stable.values.begin());
  out.attributes.push_back(std::move(stable));
  if (m.agreement.size() == out.points.size()) {
    Attribute agreement{"agreement", Array<double>(m.agreement.size())};
    std::transform(m.agreement.begin(), m.agreement.end(), agreement.values.begin(),
                   [](PointVerdict a) { return static_cast<double>(a); });
    out.attributes.push_back(std::move(agreement));
  }
  write_cloud(path, out, context);
}

}  // namespace isopach
