#include "isopach/apps/symmetry_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "isopach/apps/asymmetry.hpp"
#include "isopach/apps/symmetry_start.hpp"
#include "isopach/base/error.hpp"
#include "isopach/match/match.hpp"
#include "isopach/match/verdict/verdict.hpp"

namespace isopach {
namespace {

constexpr int bands = 3, parts = 2 * bands, least_parts = 4;
constexpr std::size_t sigma_points = 8000, part_points = 30;

/// Half as far as the scan reaches on both sides: where near ends and far begins.
double middle_distance(const Array<Point3>& face) {
  double least = 0, most = 0;
  for (const Point3& p : face) least = std::min(least, p.x), most = std::max(most, p.x);
  return std::min(-least, most) / 2;
}

/// Which part a point belongs to: by |x|, then by height. What lies on one side alone goes with the far parts.
struct FaceZones {
  double middle = 0;
  std::array<double, bands - 1> heights{};

  explicit FaceZones(const Array<Point3>& face) : middle(middle_distance(face)) {
    std::vector<double> y;
    for (const Point3& p : face)
      if (std::fabs(p.x) < 2 * middle) y.push_back(p.y);
    std::sort(y.begin(), y.end());
    for (std::size_t k = 0; k < heights.size() && !y.empty(); ++k) heights[k] = y[(k + 1) * y.size() / bands];
  }
  [[nodiscard]] int of(const Point3& p) const {
    const auto band = std::upper_bound(heights.begin(), heights.end(), p.y) - heights.begin();
    return static_cast<int>(band) + (std::fabs(p.x) < middle ? 0 : bands);
  }
};

/// Means of neighbouring points, in whatever order these come.
Array<Point3> thinned_to(const Array<Point3>& points, std::size_t most, const Context& context) {
  CurveBox curve;
  const HeightField field = field_of(points, DuplicatePolicy::mean, curve, context);
  return means_of_neighbours(field, (field.xy.size() + most - 1) / most, context);
}

double jackknife(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  double mean = 0, variance = 0;
  for (const double v : values) mean += v / n;
  for (const double v : values) variance += (n - 1) / n * (v - mean) * (v - mean);
  return variance;
}

}  // namespace

PoseEvidence symmetry_evidence(const CloudView& upright, const Context& context) {
  const JudgedScan face = judged_scan(upright, {}, context), mirror = judged_scan(mirrored(upright), {}, context);
  return judge(mirror, face, Pose{}).evidence;
}

bool is_symmetric(const PoseEvidence& e) {
  if (e.points_in_view == 0) return e.noise[0] == 0 && e.noise[1] == 0;
  return e.agree >= least_symmetric && (!e.has_detail() || e.agree + e.shape >= alike_needed);
}

std::string sides_sentence(const PoseEvidence& e) {
  std::string text = fmt::format("of what both sides show, {:.0f} % agrees within noise (needs {:.0f} %)",
                                 100 * std::clamp(e.agree, 0.0, 1.0), 100 * least_symmetric);
  if (e.has_detail())
    text += fmt::format(", and their shapes agree by {:.2f} (needs {:.2f})", std::max(0.0, e.shape),
                        std::max(0.0, alike_needed - e.agree));
  return text;
}

std::optional<Upright> other_plane(const Array<Point3>& points, const Upright& place, const Point3& towards,
                                   const AsymmetryOptions& o, const Context& context) {
  MatchOptions options = mirror_match_options(o, false);
  options.check_pose = true;
  const Cloud face = placed(points, place);
  const Matching m = match(mirrored(face), face, options, context);
  if (!m.verdict || m.verdict->grade == Grade::doubted) return std::nullopt;
  const Reflection found = reflection_of(m.pose);
  if (std::fabs(found.normal.x) < least_across) return std::nullopt;
  return place.after(found, towards);
}

PlaneSigma plane_sigma(const Array<Point3>& points, const Upright& place, const AsymmetryOptions& o,
                       const Context& context) {
  const Cloud face = placed(thinned_to(points, sigma_points, context), place);
  const FaceZones zones(face.points);
  const MatchOptions options = mirror_match_options(o, false);
  std::vector<double> y, z, offset;
  for (int left_out = 0; left_out < parts; ++left_out) {
    Cloud rest;
    for (const Point3& p : face.points)
      if (zones.of(p) != left_out) rest.points.push_back(p);
    if (face.points.size() - rest.points.size() < part_points) continue;
    try {
      const Reflection found = reflection_of(match(mirrored(rest), face, options, context).pose);
      const double side = std::copysign(1.0, found.normal.x);
      y.push_back(side * found.normal.y), z.push_back(side * found.normal.z), offset.push_back(side * found.offset);
    } catch (const OverlapError&) {
      continue;  // of what is left nothing lies over the other side: says nothing of the plane
    }
  }
  if (y.size() < least_parts) return {};
  return {degrees_per_radian * std::sqrt(jackknife(y) + jackknife(z)), std::sqrt(jackknife(offset))};
}

}  // namespace isopach
