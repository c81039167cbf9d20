// THE PAGE of the pose of a face.
#include "isopach/apps/face_pose.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "isopach/apps/face_fit.hpp"
#include "isopach/apps/face_symmetry.hpp"
#include "isopach/apps/symmetry_planes.hpp"
#include "isopach/base/median.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/distance/vectors.hpp"
#include "isopach/match/pairs/oriented.hpp"

namespace isopach {
namespace {

constexpr std::size_t most_points = 60000;  // that the pose of a face needs
constexpr std::size_t search_points = 2200, search_neighbours = 12;
constexpr std::size_t dense_points = 9000, dense_neighbours = 14;
constexpr std::size_t grid_cells = 44;
constexpr std::size_t least_points = 200;
constexpr int rounds = 3;                // seen from the front
constexpr double size_of_medians = 1.2;  // of the median distance from the median: what lengths are counted in

// The less of the scan is symmetric, the more must it look like a face: a rabbit seen from one side does by half.
constexpr double least_likeness = 0.56, symmetric_share = 0.60, dearer = 0.5, least_covered = 0.70;
constexpr double across_cosine = 0.9396926207859084, rival = 0.75;  // 20 degrees
constexpr double least_both = 0.40, least_agree = 0.70;
constexpr double most_sigma_deg = 2.5;

/// The points of the scan about their middle, in lengths of the object itself.
struct Scaled {
  Array<Point3> points;
  Point3 middle{0, 0, 0};
  double size = 0;

  [[nodiscard]] Point3 apply(const Point3& p) const { return 1 / size * (p - middle); }
  [[nodiscard]] Point3 back(const Point3& p) const { return middle + size * p; }
};

/// Every k-th of points in an order that is the set's own.
Array<Point3> some_of(const Array<Point3>& points) {
  const std::size_t stride = points.size() / most_points + 1;
  Array<Point3> some;
  for (std::size_t i = 0; i < points.size(); i += stride) some.push_back(points[i]);
  return some;
}

Scaled scaled(const Array<Point3>& points) {
  Scaled s;
  s.points = some_of(points);
  std::vector<double> values(s.points.size());
  const auto middle_of = [&](auto&& value) {
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = value(s.points[i]);
    return median(values);
  };
  s.middle = {middle_of([](const Point3& p) { return p.x; }), middle_of([](const Point3& p) { return p.y; }),
              middle_of([](const Point3& p) { return p.z; })};
  s.size = size_of_medians * middle_of([&](const Point3& p) { return length(p - s.middle); });
  if (s.size > 0)
    for (Point3& p : s.points) p = s.apply(p);
  return s;
}

/// Moves the origin to the mean of the thinned points: offsets of planes are counted from there.
void centre(Scaled& s, ThinPoints& thin) {
  Point3 sum{0, 0, 0};
  for (const Point3& p : thin.points) sum = sum + p;
  const Point3 mean = 1.0 / static_cast<double>(thin.points.size()) * sum;
  s.middle = s.back(mean);
  for (Point3& p : s.points) p = p - mean;
}

struct Candidate {
  SymmetryPlane3 plane;
  std::vector<FaceFit> fits;
};

std::vector<Candidate> candidates_of(const ThinPoints& thin, const Context& context) {
  const NearestGrid grid(thin, grid_cells);
  context.step("face", 0.2);
  const std::vector<SymmetryPlane3> planes = symmetry_planes(thin, grid);
  context.step("face", 0.5);
  std::vector<Candidate> all(planes.size());
  for_blocks(planes.size(), 1, [&](std::size_t k, std::size_t) {
    all[k].plane = planes[k];
    all[k].fits = fit_face(thin, grid, planes[k].plane);
  });
  return all;
}

const Candidate* best_of(const std::vector<Candidate>& all) {
  const Candidate* best = nullptr;
  for (const Candidate& c : all)
    if (!c.fits.empty() && (best == nullptr || c.fits.front().rank > best->fits.front().rank)) best = &c;
  return best;
}

/// The fit before the plane that was found on the face itself.
FaceFit before(FaceFit fit, const MirrorPlane& plane) {
  fit.plane = plane;
  const auto along = [&](const Point3& v) {
    const Point3 flat = v - dot(v, plane.normal) * plane.normal;
    return 1 / length(flat) * flat;
  };
  fit.up = along(fit.up);
  fit.front = cross(plane.normal, fit.up);  // left × up
  fit.tip = fit.tip - plane.distance(fit.tip) * plane.normal;
  return fit;
}

/// The plane in input coordinates; `frame` has the axes of the file.
MirrorPlane in_input(const MirrorPlane& plane, const Scaled& s, const Frame& frame) {
  return {plane.normal, dot(plane.normal, frame.to_input(s.back(plane.offset * plane.normal)))};
}

FaceFit settled_on_all(const FaceFit& fit, const Array<Point3>& points) {
  constexpr double beside = .7, around = 1.3;
  Array<Point3> near;
  for (const Point3& p : points)
    if (std::fabs(fit.plane.distance(p)) < beside * fit.width && length(p - fit.tip) < around * fit.width)
      near.push_back(p);
  if (near.size() < least_points / 4) return fit;
  const ThinPoints dense = thin_points(near, dense_points, dense_neighbours);
  return judged(settled(fit, dense), dense);
}

struct Settled {
  FaceFit fit;
  FaceSymmetry symmetry;
};

Point3 seen(const Point3& v, const FaceFit& from) { return {dot(v, from.left()), dot(v, from.up), dot(v, from.front)}; }
Point3 unseen(const Point3& v, const FaceFit& from) { return v.x * from.left() + v.y * from.up + v.z * from.front; }

/// What the points say once they are seen from the front: the means that the template and the plane are laid through
/// would else fall otherwise for every position of the scan, and the plane with them.
Settled settled_from_front(const FaceFit& before_it, const Array<Point3>& points) {
  FaceFit front = before_it;
  front.plane = {{1, 0, 0}, 0};
  front.tip = {0, 0, 0}, front.up = {0, 1, 0}, front.front = {0, 0, 1};
  Array<Point3> turned(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) turned[i] = seen(points[i] - before_it.tip, before_it);
  const FaceFit found = settled_on_all(front, turned);
  Settled s{found, face_symmetry(turned, found)};
  s.fit.tip = before_it.tip + unseen(found.tip, before_it);
  s.fit.up = unseen(found.up, before_it), s.fit.front = unseen(found.front, before_it);
  const auto plane_back = [&](const MirrorPlane& plane) {
    const Point3 normal = unseen(plane.normal, before_it);
    return MirrorPlane{normal, plane.offset + dot(normal, before_it.tip)};
  };
  s.fit.plane = plane_back(found.plane);
  s.symmetry.plane = plane_back(s.symmetry.plane);
  return s;
}

FacePose::Refusal reason(const FacePose& pose) {
  if (pose.rival_share > rival) return FacePose::Refusal::several_planes;
  const double likeness = least_likeness + dearer * std::max(0.0, symmetric_share - pose.share);
  if (pose.likeness < likeness || pose.covered < least_covered) return FacePose::Refusal::no_face;
  if (pose.both < least_both || pose.agree < least_agree) return FacePose::Refusal::sides_missing;
  if (!(pose.sigma_angle_deg <= most_sigma_deg)) return FacePose::Refusal::unsure;
  return FacePose::Refusal::none;
}

void describe(const FaceFit& fit, const FaceSymmetry& symmetry, const Scaled& s, const Frame& frame, FacePose& pose) {
  pose.front = fit.front, pose.up = fit.up, pose.left = fit.left();
  pose.tip = frame.to_input(s.back(fit.tip));
  pose.offset = dot(pose.left, pose.tip);
  pose.width = s.size * fit.width;
  pose.both = symmetry.both, pose.agree = symmetry.agree;
  pose.sigma_angle_deg = symmetry.sigma_angle;
  pose.sigma_offset = s.size * symmetry.sigma_offset;
  pose.spread = symmetry.spread;
}

void mark_region(const CloudView& cloud, const FaceFit& fit, const Scaled& s, const Frame& frame, FacePose& pose) {
  pose.region.resize(cloud.points.size());
  for_each_index(cloud.points.size(), [&](std::size_t i) {
    const Point3& p = cloud.points[i];
    pose.region[i] = is_finite(p) && in_face(fit.in_widths(s.apply(frame.to_field(p)))) ? 1 : 0;
  });
}

}  // namespace

Pose upright(const FacePose& face) {
  Pose pose;
  const std::array<Point3, 3> axes{face.left, face.up, face.front};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& [x, y, z] = axes[k];
    pose.m[4 * k] = x, pose.m[4 * k + 1] = y, pose.m[4 * k + 2] = z;
    pose.m[4 * k + 3] = -(x * face.tip.x + y * face.tip.y + z * face.tip.z);
  }
  return pose;
}

const char* to_text(FacePose::Refusal refusal) {
  using enum FacePose::Refusal;
  switch (refusal) {
    case none:
      return "none";
    case too_few_points:
      return "too few points";
    case several_planes:
      return "several planes of symmetry";
    case no_face:
      return "not a face";
    case sides_missing:
      return "a side is missing";
    case unsure:
      return "unsure";
  }
  return "not a face";
}

std::string refusal_sentence(const FacePose& pose) {
  using enum FacePose::Refusal;
  const char* give = "give the viewing direction (@direction), or crop the scan to the face";
  switch (pose.refusal) {
    case none:
      return {};
    case too_few_points:
      return "too few points to find a face by: give the viewing direction (@direction), or a denser scan";
    case several_planes:
      return fmt::format("it is its own mirror image in several ways, as no face is: {}", give);
    case sides_missing:
      return fmt::format(
          "the two sides of the face do not match ({:.0f} % of it has its other side in the scan, {:.0f} % of that "
          "agrees): {}, or scan both sides",
          100 * pose.both, 100 * pose.agree, give);
    case unsure:
      return fmt::format("the midline of the face is known to {:.1f} degrees only: {}, or scan more of both sides",
                         pose.sigma_angle_deg, give);
    case no_face:
      break;
  }
  return fmt::format("this scan does not look like a face (likeness {:.2f}, {:.0f} % of a face covered): {}",
                     pose.likeness, 100 * pose.covered, give);
}

FacePose find_face(const CloudView& cloud, const ProjectOptions& project, const Context& context) {
  FacePose pose;
  ProjectOptions in_space = project;
  in_space.direction = {};  // axes of the file
  const Frame frame = choose_frame(cloud, cloud, Pose{}, in_space, context);
  context.step("face", 0);
  const OrientedCloud ordered = order_points(cloud, Pose{}, frame, in_space, 0, context);
  pose.refusal = FacePose::Refusal::too_few_points;
  if (ordered.points.size() < least_points) return pose;
  Scaled s = scaled(ordered.points);
  if (!(s.size > 0)) return pose;
  ThinPoints thin = thin_points(s.points, search_points, search_neighbours);
  if (thin.points.size() < least_points || !(thin.spacing > 0)) return pose;
  centre(s, thin);
  thin = thin_points(s.points, search_points, search_neighbours);

  const std::vector<Candidate> candidates = candidates_of(thin, context);
  for (const Candidate& c : candidates) pose.planes.push_back(in_input(c.plane.plane, s, frame));
  context.step("face", 0.8);
  pose.refusal = FacePose::Refusal::no_face;
  const Candidate* best = best_of(candidates);
  if (best == nullptr) return pose;
  const FaceFit& first = best->fits.front();
  pose.share = best->plane.share;
  for (const Candidate& c : candidates)
    if (std::fabs(dot(c.plane.plane.normal, best->plane.plane.normal)) < across_cosine)
      pose.rival_share = std::max(pose.rival_share, c.plane.share);

  FaceFit upright = before(first, face_symmetry(s.points, first).plane);
  Settled settled;
  for (int round = 0; round < rounds; ++round) {
    settled = settled_from_front(upright, s.points);
    upright = before(settled.fit, settled.symmetry.plane);
  }
  pose.likeness = settled.fit.likeness(), pose.covered = settled.fit.covered;
  describe(upright, settled.symmetry, s, frame, pose);
  pose.refusal = reason(pose);
  if (pose.found()) mark_region(cloud, upright, s, frame, pose);
  return pose;
}

}  // namespace isopach
