// THE PAGE of the sequence application.
#include "isopach/apps/sequence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "isopach/apps/part_finder.hpp"
#include "isopach/apps/static_check.hpp"
#include "isopach/base/kept_memory.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/compare/stages.hpp"
#include "isopach/distance/vectors.hpp"
#include "isopach/field/extent.hpp"

namespace isopach {
namespace {

constexpr double least_angle = std::numbers::pi / 180;
constexpr double sure = 0.15;      // blends below it stay, above one less it move
constexpr double fit_sure = 0.04;  // the same for the points that a part is fitted by: none that moves a little less
constexpr std::size_t least_points = 100;
constexpr std::size_t blend_neighbours = 4;
constexpr double least_support_static = 0.5, least_support_moving = 0.25;

void check(const FrameSource& frames, const SequenceOptions& o) {
  if (frames.count < 2)
    throw UsageError(
        fmt::format("{} frame: a sequence has at least 2: name the files, or a folder of them", frames.count));
  if (o.reference >= frames.count)
    throw UsageError(
        fmt::format("@reference: there is no frame {}: the last one is {}", o.reference, frames.count - 1));
  if (o.model_points < 500)
    throw UsageError(fmt::format("@model-points: {} are too few: at least 500", o.model_points));
  if (!(o.least_part > 0 && o.least_part < 0.5))
    throw UsageError(fmt::format("@least-part: {} is not a share above 0 and below 0.5", o.least_part));
  if (!(o.smooth >= 0)) throw UsageError("@smooth: not a number of frames, 0 or more");
  if (!(o.rate >= 0)) throw UsageError("@rate: not a number of frames a second");
  for (const auto& [place, option] : {std::pair{&o.static_at, "@static-at"}, {&o.follow, "@follow"}}) {
    if (!*place) continue;
    const Point3& p = **place;
    if (!(std::fabs(p.x) <= max_extent && std::fabs(p.y) <= max_extent && std::fabs(p.z) <= max_extent))
      throw UsageError(
          fmt::format("{}: ({:.6g}, {:.6g}, {:.6g}) is farther away than any scan reaches", option, p.x, p.y, p.z));
  }
}

/// The page's state: the model, and what two readings of the frames make of it.
class Sequence {
 public:
  Sequence(const FrameSource& source, const SequenceOptions& options, const Context& context)
      : source_(source), options_(options), context_(context), clock_(result_.timing, context) {}

  SequenceResult run() {
    check(source_, options_);
    result_.options = options_;
    clock_.start("reference");
    read_reference();
    strange_.assign(source_.count, "");
    while (!read_twice()) ++rounds_;
    clock_.start("joint");
    describe_joint();
    describe_frames();
    clock_.stop();
    sum_up();
    return std::move(result_);
  }

 private:
  void read_reference() {
    const Cloud cloud = source_.read(options_.reference);
    result_.reference = stages::summarise_file(cloud, "reference");
    result_.unit = options_.unit.empty() ? cloud.unit : options_.unit;
    frame_ = choose_frame(cloud, cloud, Pose{}, project_, context_);
    all_ = order_points(cloud, Pose{}, frame_, project_, 0, context_);
    if (all_.points.size() < least_points)
      throw InputError(fmt::format("{}: {} points are too few for a reference: at least {}",
                                   source_.name(options_.reference), all_.points.size(), least_points));
    orient(all_, context_);
    flatten(all_);
    model_ = thinned(all_, options_.model_points);
    model_.tree = std::make_unique<PointTree>(model_.points);
  }

  /// Both readings. False where a frame turned out to show something else: it had a say in the parts, which are to be
  /// found again without it.
  [[nodiscard]] bool read_twice() {
    clock_.start("parts" + again());
    find_parts();
    clock_.start("motions" + again());
    result_.frames.clear();
    still_ = relative_ = Motion{}, before_.reset();
    StaticCheck check(part_that_stays(), source_.count, context_);
    const std::vector<std::string> strange_before = strange_;
    for (std::size_t k = 0; k < source_.count; ++k) {
      context_.step("motions" + again(), static_cast<double>(k) / static_cast<double>(source_.count));
      follow_frame(k, check);
    }
    if (strange_ != strange_before) return false;
    if (const std::string why = check.strangers(); !why.empty())
      throw Error(
          ExitCode::not_converged,
          fmt::format("{}: frame {} is of another object than the other frames, or the surface changed: {}; give "
                      "another @reference, or leave out the frames that do not belong to it",
                      source_.name(options_.reference), options_.reference, why));
    return true;
  }

  /// Of the stages: which round they are of.
  [[nodiscard]] std::string again() const { return rounds_ > 0 ? fmt::format(", round {}", rounds_ + 1) : ""; }

  /// Points of the reference, as they lie in its file but for their noise.
  [[nodiscard]] Cloud part_that_stays() const {
    Cloud part;
    for (std::size_t i = 0; i < result_.points.size(); ++i)
      if (result_.label[i] == PartLabel::still) part.points.push_back(result_.points[i]);
    return part;
  }

  /// Reads frame k and makes a tree and normals; nothing, with the reason, where that cannot be done.
  /// At most about `most` points: every k-th along the curve.
  [[nodiscard]] std::optional<OrientedCloud> read(std::size_t k, std::size_t most, std::string& reason,
                                                  std::size_t* points) const {
    try {
      const Cloud cloud = source_.read(k);
      if (points != nullptr) *points = cloud.points.size();
      OrientedCloud frame = order_points(cloud, Pose{}, frame_, project_, 0, context_);
      if (frame.points.size() < least_points) {
        reason = fmt::format("{} points are too few", frame.points.size());
        return std::nullopt;
      }
      if (frame.points.size() > most + most / 2) frame = thinned(frame, most);
      orient(frame, context_);
      flatten(frame);
      return frame;
    } catch (const Interrupted&) {
      throw;
    } catch (const Error& error) {
      reason = error.what();
      return std::nullopt;
    }
  }

  void find_parts() {
    PartFinder finder(model_, options_.least_part);
    skipped_ = strange_;
    for (std::size_t k = 0; k < source_.count; ++k) {
      context_.step("parts" + again(), static_cast<double>(k) / static_cast<double>(source_.count));
      if (k == options_.reference || !skipped_[k].empty()) continue;
      if (const std::optional<OrientedCloud> frame = read(k, options_.model_points, skipped_[k], nullptr))
        if (std::string reason; !finder.add(*frame, reason, context_)) skipped_[k] = reason;
    }
    const auto bad = std::count_if(skipped_.begin(), skipped_.end(), [](const std::string& s) { return !s.empty(); });
    if (static_cast<std::size_t>(bad) + 1 >= source_.count)
      throw Error(rounds_ > 0 ? ExitCode::not_converged : ExitCode::input,
                  fmt::format("no frame but the reference can be used{}; {}: {}",
                              rounds_ > 0 ? ", so that it may be the one that does not belong (@reference)" : "",
                              source_.name(first_bad()), skipped_[first_bad()]));
    if (!finder.found())
      throw InputError(fmt::format(
          "the frames move as one: no part of {} of the scan moves against the rest; is @reference a typical frame?",
          options_.least_part));
    set_blend(finder);
  }

  [[nodiscard]] std::size_t first_bad() const {
    std::size_t k = 0;
    while (skipped_[k].empty()) ++k;
    return k;
  }

  void set_blend(const PartFinder& finder) {
    Array<double> blend = finder.blend();
    bool swap = finder.travel(false) > finder.travel(true);
    if (options_.static_at) {
      const PointTree::Two two = model_.tree->nearest_two(frame_.to_field(*options_.static_at));
      swap = blend[two.first] > 0.5;
    }
    if (swap)
      for (double& b : blend) b = 1 - b;
    Array<unsigned char> still(blend.size()), moving(blend.size());
    for (std::size_t i = 0; i < blend.size(); ++i) still[i] = blend[i]<fit_sure, moving[i] = blend[i]> 1 - fit_sure;
    static_ = part_of(model_, still);
    moving_ = part_of(model_, moving);
    spread_blend(blend);
  }

  /// From the model to all points of the reference: mean of the nearest ones, the nearer the more.
  void spread_blend(const Array<double>& blend) {
    const std::size_t n = all_.points.size();
    result_.points.resize(n), result_.ids.resize(n), result_.blend.resize(n), result_.label.resize(n);
    for_blocks(n, 256, [&](std::size_t begin, std::size_t end) {
      std::vector<Index> found;
      for (std::size_t i = begin; i < end; ++i) {
        const Point3 p = all_.points[i];
        model_.tree->nearest(p, blend_neighbours, found);
        double sum = 0, weight = 0;
        const double slight = squared_length(model_.points[found.back()] - p) * 1e-6;
        for (const Index k : found) {
          const double w = 1 / (squared_length(model_.points[k] - p) + slight + 1e-300);
          sum += w * blend[k], weight += w;
        }
        const double b = sum / weight;
        result_.blend[i] = b;
        result_.label[i] = b < sure ? PartLabel::still : b > 1 - sure ? PartLabel::moving : PartLabel::between;
        result_.points[i] = frame_.to_input(p);
        result_.ids[i] = all_.ids[i];
      }
    });
    result_.points_static = result_.points_moving = result_.points_between = 0;
    for (const PartLabel l : result_.label)
      ++(l == PartLabel::still    ? result_.points_static
         : l == PartLabel::moving ? result_.points_moving
                                  : result_.points_between);
  }

  void follow_frame(std::size_t k, StaticCheck& check) {
    FrameMotion f;
    f.index = k;
    f.name = source_.name(k);
    f.time = options_.rate > 0 ? static_cast<double>(k) / options_.rate : static_cast<double>(k);
    f.skipped = skipped_[k];
    if (f.skipped.empty()) fit_frame(k, f, check);
    result_.frames.push_back(std::move(f));
  }

  void fit_frame(std::size_t k, FrameMotion& f, StaticCheck& check) {
    const std::optional<OrientedCloud> frame = read(k, max_nodes, f.skipped, &f.points);
    if (!frame) return;
    if (k == options_.reference) still_ = relative_ = Motion{}, before_.reset();
    const std::optional<PartFit> still = fit_part(static_, *frame, std::array{still_, Motion{}}, context_);
    if (!still || still->support < least_support_static) {
      f.skipped = not_on_frame(false);
      return;
    }
    std::vector<Motion> starts{composed(still->motion, relative_), still->motion};
    if (before_)
      starts.push_back(composed(still->motion, composed(relative_, composed(inverted(*before_), relative_))));
    const std::optional<PartFit> moving = fit_part(moving_, *frame, starts, context_);
    if (!moving || moving->support < least_support_moving) {
      f.skipped = not_on_frame(true);
      return;
    }
    f.head = pose_of(still->motion, frame_, Pose{});
    if (k != options_.reference && !check.shows(as_cloud(*frame), k, f.head, strange_[k])) {
      f.skipped = strange_[k];
      return;
    }
    still_ = still->motion;
    before_ = relative_;
    relative_ = composed(inverted(still_), moving->motion);
    f.motion = pose_of(relative_, frame_, Pose{});
    f.rms_static = still->rms, f.rms_moving = moving->rms;
    f.support_static = still->support, f.support_moving = moving->support;
    set_precision(*still, *moving, f);
  }

  [[nodiscard]] Cloud as_cloud(const OrientedCloud& frame) const {
    Cloud cloud;
    cloud.points.reserve(frame.points.size());
    for (const Point3& p : frame.points) cloud.points.push_back(frame_.to_input(p));
    return cloud;
  }

  /// Both fits err independently; what the first one turns wrongly moves the middle of the second.
  void set_precision(const PartFit& still, const PartFit& moving, FrameMotion& f) const {
    std::vector<std::string> weak;
    const auto a = covariance_of(still, information_floor(static_, static_), weak);
    const auto b = covariance_of(moving, information_floor(moving_, moving_), weak);
    const auto trace = [](const std::array<double, 36>& c, std::size_t first) {
      return c[7 * first] + c[7 * (first + 1)] + c[7 * (first + 2)];
    };
    const double arm2 = squared_length(still.information.centre - moving.information.centre);
    f.sigma_angle = std::sqrt(trace(a, 0) + trace(b, 0));
    f.sigma_shift = std::sqrt(trace(a, 3) + trace(b, 3) + arm2 * trace(a, 0));
  }

  void describe_joint() {
    std::vector<Pose> motions;
    for (const FrameMotion& f : result_.frames)
      if (f.skipped.empty()) motions.push_back(f.motion);
    result_.used = motions.size();
    if (result_.used < 2) throw InputError("fewer than 2 frames can be used: see which parts they show");
    const Point3 middle_moving = middle(PartLabel::moving), middle_all = middle_of_parts();
    result_.hinge = hinge_axis(motions, middle_moving, least_angle);
    HingeAxis axis{middle_moving, {1, 0, 0}, 0};
    if (result_.hinge)
      axis = *result_.hinge;
    else
      result_.warnings.emplace_back(
          "the moving part hardly turns: there is no hinge axis, and the local axes are those of the input");
    result_.static_frame = result_.hinge ? hinge_frame(axis, middle_all) : shifted_to(middle_moving);
    choose_chin(axis);
    result_.moving_frame = result_.static_frame;
    result_.moving_frame.m[3] = result_.chin.x;
    result_.moving_frame.m[7] = result_.chin.y;
    result_.moving_frame.m[11] = result_.chin.z;
  }

  [[nodiscard]] static Pose shifted_to(const Point3& p) {
    Pose pose;
    pose.m[3] = p.x, pose.m[7] = p.y, pose.m[11] = p.z;
    return pose;
  }

  [[nodiscard]] Point3 middle(PartLabel label) const {
    Point3 sum{0, 0, 0};
    double n = 0;
    for (std::size_t i = 0; i < result_.points.size(); ++i)
      if (result_.label[i] == label) sum = sum + frame_.to_field(result_.points[i]), n += 1;
    return frame_.to_input((1 / std::max(1.0, n)) * sum);
  }
  [[nodiscard]] Point3 middle_of_parts() const {
    const Point3 a = middle(PartLabel::still), b = middle(PartLabel::moving);
    return 0.5 * (a + b);
  }

  /// The point to follow: the one that is asked for, or the point well inside the moving part that is farthest from the
  /// axis.
  void choose_chin(const HingeAxis& axis) {
    if (options_.follow) {
      result_.chin = *options_.follow;
      return;
    }
    double farthest = -1;
    for (std::size_t i = 0; i < moving_.points.size(); ++i) {
      if (moving_.boundary[i] != 0) continue;
      const Point3 p = frame_.to_input(moving_.points[i]);
      const double far = length(cross(p - axis.point, axis.direction));
      if (far > farthest) farthest = far, result_.chin = p;
    }
  }

  void describe_frames() {
    const Pose to_static = inverted(result_.static_frame);
    const Point3 hinge = result_.hinge ? result_.hinge->point : middle(PartLabel::moving);
    std::vector<double> times;
    std::vector<Point3> chins, hinges, openings;
    for (FrameMotion& f : result_.frames) {
      if (!f.skipped.empty()) continue;
      f.local = composed(to_static, composed(f.motion, result_.moving_frame));
      f.angle = length(rotation_vector(f.motion));
      f.opening = result_.hinge ? turn_about(f.motion, result_.hinge->direction) : f.angle;
      if (f.angle >= least_angle) f.screw = screw_of(f.motion, hinge);
      f.chin = f.motion.apply(result_.chin);
      f.hinge = f.motion.apply(hinge);
      const Point3 way = f.chin - result_.chin;
      f.excursion = length(way);
      f.excursion_local = turned(to_static, way);
      result_.widest = std::max(result_.widest, f.opening);
      result_.farthest = std::max(result_.farthest, f.excursion);
      times.push_back(static_cast<double>(f.index));
      chins.push_back(f.chin - result_.chin), hinges.push_back(f.hinge - hinge), openings.push_back({f.opening, 0, 0});
    }
    chins = smooth_path(times, chins, options_.smooth);
    hinges = smooth_path(times, hinges, options_.smooth);
    openings = smooth_path(times, openings, options_.smooth);
    std::size_t k = 0;
    for (FrameMotion& f : result_.frames) {
      if (!f.skipped.empty()) continue;
      f.chin_smooth = result_.chin + chins[k];
      f.hinge_smooth = hinge + hinges[k];
      f.opening_smooth = openings[k++].x;
    }
  }

  void sum_up() {
    std::size_t bad = 0;
    for (const FrameMotion& f : result_.frames) {
      if (f.skipped.empty()) continue;
      ++bad;
      result_.warnings.push_back(fmt::format("frame {} ({}) was skipped: {}", f.index, f.name, f.skipped));
    }
    if (result_.unit == "unknown")
      result_.warnings.emplace_back("the files do not say their unit: lengths are in units of the files (@unit)");
  }

  const FrameSource& source_;
  const SequenceOptions& options_;
  const Context& context_;
  SequenceResult result_;
  stages::Clock clock_;
  ProjectOptions project_;
  Frame frame_;
  OrientedCloud all_, model_, static_, moving_;
  std::vector<std::string> skipped_;
  std::vector<std::string> strange_;  ///< by frame: why it does not show the part that stays, as earlier rounds saw
  std::size_t rounds_ = 0;
  Motion still_, relative_;
  std::optional<Motion> before_;
};

}  // namespace

SequenceResult sequence(const FrameSource& frames, const SequenceOptions& options, const Context& context) {
  const KeptMemory kept;  // of one frame for the next
  SequenceResult result;
  run_with_threads(context, [&] { result = Sequence(frames, options, context).run(); });
  return result;
}

}  // namespace isopach
