// THE PAGE of the combine application.
#include "isopach/apps/combine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "isopach/apps/motions.hpp"
#include "isopach/apps/part_fit.hpp"
#include "isopach/apps/quadric_fit.hpp"
#include "isopach/apps/self_turns.hpp"
#include "isopach/base/median.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/compare/stages.hpp"
#include "isopach/distance/vectors.hpp"
#include "isopach/match/coarse/coarse.hpp"

namespace isopach {
namespace {

constexpr std::size_t least_points = 100;
constexpr double worst_scale = 2.5;  // times the noise of both scans: what fits worse is something else
constexpr double on_reference = 4;   // standard deviations within which a point lies on the object
constexpr std::size_t query_block = 256;
constexpr double least_slip = 0.5;          // noises; below it a slip of 1 % of the extent is not seen
constexpr std::size_t rival_points = 1000;  // of the object, that another place of it is tried by
constexpr double rival_share = 0.85;        // of what fits at the pose: so much fits at a rival
constexpr double fits = 3;                  // standard deviations that a distance at the pose stays within
constexpr double other_turn = 3 * std::numbers::pi / 180, other_shift = 0.03;  // farther away it is another place

using Matrix6 = std::array<double, 36>;

/// Of a turn and shift about `from`, told about `to` instead: the shift there is shift + turn × (to − from).
Matrix6 carried(const Matrix6& c, const Point3& from, const Point3& to) {
  const Point3 d = to - from;
  // Row i of [turn; shift'] in terms of [turn; shift].
  const std::array<double, 36> a{1, 0,   0,    0, 0, 0, 0,    1, 0,   0, 0, 0, 0,   0,    1, 0, 0, 0,
                                 0, d.z, -d.y, 1, 0, 0, -d.z, 0, d.x, 0, 1, 0, d.y, -d.x, 0, 0, 0, 1};
  Matrix6 half{}, result{};
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j)
      for (std::size_t k = 0; k < 6; ++k) half[6 * i + j] += a[6 * i + k] * c[6 * k + j];
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j)
      for (std::size_t k = 0; k < 6; ++k) result[6 * i + j] += half[6 * i + k] * a[6 * j + k];
  return result;
}

/// Both blocks turned to other axes: r · block · rᵀ.
Matrix6 turned_axes(const Matrix6& c, const Pose& pose) {
  const auto r = [&](std::size_t i, std::size_t j) { return pose.m[4 * i + j]; };
  Matrix6 result{};
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j)
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t l = 0; l < 3; ++l)
          result[6 * i + j] += r(i % 3, k) * r(j % 3, l) * c[6 * (i / 3 * 3 + k) + j / 3 * 3 + l];
  return result;
}

double deviation(const Matrix6& c, std::size_t first) {
  return std::sqrt(std::max(0.0, c[7 * first] + c[7 * (first + 1)] + c[7 * (first + 2)]));
}

std::string name_of(const CloudView& cloud, const char* role) { return cloud.path.empty() ? role : cloud.path; }

void check_unit(const CloudView& cloud, const char* role, std::string& unit) {
  if (cloud.unit == "unknown") return;
  if (unit != "unknown" && unit != cloud.unit)
    throw InputError(fmt::format("{}: is in {}, another scan in {}: convert one, or say @unit", name_of(cloud, role),
                                 cloud.unit, unit));
  unit = cloud.unit;
}

/// Finds the object in one scan.
class Finder {
 public:
  Finder(const CloudView& scan, const char* role, const CloudView& reference, const CombineOptions& options,
         const Context& context)
      : scan_(scan), role_(role), reference_(reference), options_(options), context_(context) {}

  LocatedReference run(const std::optional<Pose>& start) {
    const Pose first = start ? *start : coarse();
    frame_ = choose_frame(scan_, reference_, first, project_, context_);
    both([&] { fixed_ = oriented(scan_, Pose{}); }, [&] { object_ = oriented(reference_, first); });
    const double noise = std::hypot(fixed_.roughness, object_.roughness);
    flatten(fixed_);
    flatten(object_);
    const std::optional<PartFit> near = fit_part(object_, fixed_, std::array{Motion{}}, context_);
    if (!near) not_found("no part of the object has a surface near it there");
    const std::optional<QuadricFit> fit = fit_quadrics(object_, fixed_, near->motion, near->scale, context_);
    if (!fit) not_found("no pose was found at which enough of it lies on the object");
    LocatedReference found;
    found.pose = pose_of(fit->motion, frame_, first);
    found.rms = fit->rms;
    found.pairs = fit->pairs;
    found.correlation = fit->correlation;
    found.centre = frame_.to_input(fit->information.centre);
    found.covariance = turned_axes(fit->covariance, to_input_axes());
    found.slip = fit->slip;
    measure_cover(*near, *fit, noise, found);
    if (found.share < options_.least_share)
      not_found(
          fmt::format("only {:.0f} % of the object's points lie on a surface there, @least-share requires {:.0f} %",
                      100 * found.share, 100 * options_.least_share));
    if (fit->scale > worst_scale * noise)
      not_found(
          fmt::format("what is there fits to {:.3g}, but the scans are rough by {:.3g} only: it is something else",
                      fit->scale, noise));
    if (fit->slip < least_slip)
      throw Error(
          ExitCode::not_converged,
          fmt::format("{}: the reference object's place is not determined: its shape leaves {} free (a slip of 1 "
                      "% of it raises distances by {:.2g} of their noise, {} are needed); use an object with "
                      "more relief, or scan more of it",
                      name_of(scan_, role_), fit->least_held, fit->slip, least_slip));
    if (!start) refuse_rivals(*fit);
    return found;
  }

 private:
  [[nodiscard]] Pose coarse() const {
    try {
      MatchOptions options;
      options.objective = Objective::icp_plane;
      return coarse_start(reference_, scan_, options, context_);
    } catch (const OverlapError&) {
      not_found("nothing of its shape is there");
    }
  }

  [[noreturn]] void not_found(const std::string& why) const {
    throw OverlapError(
        fmt::format("{}: the reference object was not found: {}; is it in this scan? @start-{} gives its "
                    "place",
                    name_of(scan_, role_), why, role_));
  }

  /// Whether the object fits as well after a turn that its shape may repeat under.
  void refuse_rivals(const QuadricFit& fit) const {
    const OrientedCloud few = thinned(object_, rival_points);
    const double reach = 3 * std::sqrt(misfit(few, fixed_, fit.motion));
    Array<double> all = distances(few, fit.motion, reach), sizes;
    for (const double d : all)
      if (d < reach) sizes.push_back(d);
    const double within = fits * mad_to_sigma * median(sizes);
    const auto on = [&](const Motion& motion) {
      const Array<double> far = distances(few, motion, reach);
      return std::count_if(far.begin(), far.end(), [&](double d) { return d <= within; });
    };
    const auto here = static_cast<double>(on(fit.motion));
    Box3 box;
    for (const Point3& p : few.points) box.add(p);
    const Point3 middle = 0.5 * (box.min + box.max);
    for (const Motion& turn : self_turns(object_, context_)) {
      context_.check();
      const std::optional<PartFit> there = fit_part(few, fixed_, std::array{composed(fit.motion, turn)}, context_);
      if (!there) continue;
      const Motion off = composed(there->motion, inverted(fit.motion));
      const double trace = off.rotation[0] + off.rotation[4] + off.rotation[8];
      const double angle = std::acos(std::clamp((trace - 1) / 2, -1.0, 1.0));
      const double shift = length(there->motion.apply(middle) - fit.motion.apply(middle));
      if (angle < other_turn && shift < other_shift * length(box.max - box.min)) continue;
      const auto elsewhere = static_cast<double>(on(there->motion));
      if (elsewhere < rival_share * here) continue;
      throw Error(
          ExitCode::not_converged,
          fmt::format("{}: the reference object fits as well elsewhere: {:.0f} % of its points lie on the scan, "
                      "and {:.0f} % where it is turned by {:.0f} degrees: its shape repeats; @start-{} says "
                      "which place is meant, or use an object that no turn takes onto itself",
                      name_of(scan_, role_), 100 * here / static_cast<double>(few.points.size()),
                      100 * elsewhere / static_cast<double>(few.points.size()), angle * 180 / std::numbers::pi, role_));
    }
  }

  [[nodiscard]] Array<double> distances(const OrientedCloud& object, const Motion& motion, double reach) const {
    Array<double> far(object.points.size());
    for_blocks(far.size(), query_block, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        far[i] = surface_distance(fixed_, motion.apply(object.points[i]), reach);
    });
    return far;
  }

  [[nodiscard]] OrientedCloud oriented(const CloudView& cloud, const Pose& pose) const {
    OrientedCloud result = order_points(cloud, pose, frame_, project_, 0, context_);
    if (result.points.size() < least_points)
      throw InputError(fmt::format("{}: {} points are too few: at least {}", name_of(cloud, "scan"),
                                   result.points.size(), least_points));
    orient(result, context_);
    return result;
  }

  /// Frame axes to input axes: columns are the frame's rows.
  [[nodiscard]] Pose to_input_axes() const {
    Pose pose;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) pose.m[4 * i + j] = frame_.rotation[3 * j + i];
    return pose;
  }

  /// Which points of the object lie on the scan, and which of the scan on the object.
  void measure_cover(const PartFit& near, const QuadricFit& fit, double noise, LocatedReference& found) const {
    const FrameScale scale = frame_scale(object_, fixed_, near);
    const double within = on_reference * std::max(scale.sigma, noise);
    const double on = reduce_blocks<double>(
        object_.points.size(), query_block,
        [&](std::size_t begin, std::size_t end) {
          double sum = 0;
          for (std::size_t i = begin; i < end; ++i)
            sum += lies_on(fixed_, fit.motion.apply(object_.points[i]), scale.reach, within) ? 1 : 0;
          return sum;
        },
        [](double& sum, double part) { sum += part; });
    found.share = on / static_cast<double>(object_.points.size());
    Array<unsigned char> covered(fixed_.points.size());
    for_blocks(covered.size(), query_block, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        covered[i] = lies_on(object_, fit.motion.undo(fixed_.points[i]), scale.reach, within);
    });
    found.on_reference.assign(scan_.points.size(), 0);
    double sum = 0;
    for (std::size_t i = 0; i < covered.size(); ++i) found.on_reference[fixed_.ids[i]] = covered[i], sum += covered[i];
    found.covered = sum / static_cast<double>(covered.size());
  }
  [[nodiscard]] static bool lies_on(const OrientedCloud& surface, const Point3& p, double reach, double within) {
    return surface.tree->nearest_distance2(p) <= reach * reach && surface_distance(surface, p, reach) <= within;
  }

  CloudView scan_;
  const char* role_;
  CloudView reference_;
  const CombineOptions& options_;
  const Context& context_;
  ProjectOptions project_;
  Frame frame_;
  OrientedCloud fixed_, object_;
};

/// What both fits do not know of the jaw's place, about the middle of the object in the face.
void chain(Combination& c) {
  c.face_jaw = composed(c.face.pose, inverted(c.jaw.pose));
  c.centre = c.face.centre;
  const Matrix6 of_jaw = carried(turned_axes(c.jaw.covariance, c.face_jaw), c.face_jaw.apply(c.jaw.centre), c.centre);
  for (std::size_t i = 0; i < 36; ++i) c.covariance[i] = c.face.covariance[i] + of_jaw[i];
  c.sigma_angle = deviation(c.covariance, 0);
}

void assemble(const CloudView& face, const CloudView& jaw, Combination& c) {
  const auto add = [&](const Point3& p, CombinedPart part) {
    if (!is_finite(p)) return;
    c.points.push_back(p);
    c.part.push_back(part);
    ++c.counts[static_cast<std::size_t>(part)];
  };
  for (std::size_t i = 0; i < face.points.size(); ++i)
    add(face.points[i], c.face.on_reference[i] != 0 ? CombinedPart::reference_in_face : CombinedPart::face);
  double farthest = 0;
  Point3 far = c.centre;
  Box3 box;
  for (std::size_t i = 0; i < jaw.points.size(); ++i) {
    const Point3 p = c.face_jaw.apply(jaw.points[i]);
    add(p, c.jaw.on_reference[i] != 0 ? CombinedPart::reference_in_jaw : CombinedPart::jaw);
    if (!is_finite(p) || c.jaw.on_reference[i] != 0) continue;
    box.add(p);
    if (length(p - c.centre) > farthest) farthest = length(p - c.centre), far = p;
  }
  c.jaw_middle = box.empty() ? c.centre : 0.5 * (box.min + box.max);
  c.sigma_middle = deviation(carried(c.covariance, c.centre, c.jaw_middle), 3);
  c.sigma_farthest = deviation(carried(c.covariance, c.centre, far), 3);
}

void warn(Combination& c) {
  if (c.unit == "unknown")
    c.warnings.emplace_back("the files do not say their unit: lengths are in units of the files (@unit)");
}

Combination run(const CloudView& face, const CloudView& jaw, const CloudView& reference, const CombineOptions& options,
                const Context& context) {
  if (!(options.least_share > 0 && options.least_share <= 1))
    throw UsageError(fmt::format("@least-share: {} is not a share above 0 and up to 1", options.least_share));
  Combination c;
  c.options = options;
  c.face_input = stages::summarise_file(face, "face");
  c.jaw_input = stages::summarise_file(jaw, "jaw");
  c.reference_input = stages::summarise_file(reference, "reference");
  c.unit = options.unit.empty() ? "unknown" : options.unit;
  if (options.unit.empty())
    check_unit(face, "face", c.unit), check_unit(jaw, "jaw", c.unit), check_unit(reference, "reference", c.unit);
  stages::Clock clock(c.timing, context);
  clock.start("face");
  c.face = Finder(face, "face", reference, options, context).run(options.start_face);
  clock.start("jaw");
  c.jaw = Finder(jaw, "jaw", reference, options, context).run(options.start_jaw);
  clock.start("chain");
  chain(c);
  assemble(face, jaw, c);
  clock.stop();
  warn(c);
  return c;
}

}  // namespace

Combination combine(const CloudView& face, const CloudView& jaw, const CloudView& reference,
                    const CombineOptions& options, const Context& context) {
  Combination result;
  run_with_threads(context, [&] { result = run(face, jaw, reference, options, context); });
  return result;
}

}  // namespace isopach
