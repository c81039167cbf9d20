#include "isopach/match/verdict/pose_evidence.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "isopach/base/linear.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/distance/vectors.hpp"
#include "isopach/match/verdict/shape_detail.hpp"

namespace isopach {
namespace {

constexpr std::size_t in_depth = 4;      // nearest in the projection; the nearest of them in depth is the partner
constexpr double beside = 1.5;           // spacings: farther off there is nothing of the other scan
constexpr double facing = 0.2;           // cosine of 78 degrees
constexpr double steep = 0.15;           // a facet seen at a flatter angle has no depth of its own
constexpr double depth_to_normal = 0.3;  // then: of the difference in depth
constexpr double near_depths = 3;        // spacings, within which depth and distance may differ in sign
constexpr double widths = 3;             // of the noise
constexpr std::size_t fewest = 30;
constexpr double slip_share = 0.01;  // of the extent
constexpr double most_slip_needed = 0.5;
// A plane through 12 points of noise s is tilted by s / (2.35 spacings), and `noise` is 1.66 s: a surface that holds
// nothing shows a slip of slip_share extent / (3.9 spacings), and spheres, cylinders and planes do, to a fifth. Two
// fifths more are asked for.
constexpr double noise_of_normals = 2.8;

/// A rigid motion with a scale, of the coordinates about the origins of two scans.
struct Placing {
  std::array<double, 9> turn{};
  double scale = 1;
  Point3 shift{0, 0, 0};

  Placing(const Pose& pose, const Point3& from, const Point3& to) {
    const auto& m = pose.m;
    const double det =
        m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) + m[2] * (m[4] * m[9] - m[5] * m[8]);
    scale = std::cbrt(std::fabs(det));
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) turn[3 * i + j] = m[4 * i + j] / scale;
    shift = pose.apply(from) - to;
  }
  [[nodiscard]] Point3 direction(const Point3& v) const {
    return {turn[0] * v.x + turn[1] * v.y + turn[2] * v.z, turn[3] * v.x + turn[4] * v.y + turn[5] * v.z,
            turn[6] * v.x + turn[7] * v.y + turn[8] * v.z};
  }
  [[nodiscard]] Point3 direction_back(const Point3& v) const {
    return {turn[0] * v.x + turn[3] * v.y + turn[6] * v.z, turn[1] * v.x + turn[4] * v.y + turn[7] * v.z,
            turn[2] * v.x + turn[5] * v.y + turn[8] * v.z};
  }
  [[nodiscard]] Point3 apply(const Point3& p) const { return scale * direction(p) + shift; }
  [[nodiscard]] Point3 undo(const Point3& p) const { return (1 / scale) * direction_back(p - shift); }
};

/// A point of another scan in the view of `scan`.
struct Seen {
  bool in_view = false;
  double distance = 0;  ///< from the surface of `scan`, positive towards its eye
  Index partner = no_index;
  Point3 to_eye{0, 0, 1};
};

Seen seen(const Point3& p, const JudgedScan& scan, std::vector<Index>& found) {
  Seen s;
  const Point3 place = scan.viewing.place(p);
  scan.places_tree->nearest(place, in_depth, found);
  if (found.empty()) return s;
  s.in_view = length(scan.places[found.front()] - place) < beside * scan.place_spacing;
  s.to_eye = scan.viewing.line_of_sight(p);
  const double depth = scan.viewing.nearness(p);
  const bool plane = scan.viewing.kind == Viewing::Kind::direction;
  const double near_depth = near_depths * (plane ? scan.place_spacing : scan.spacing);
  double least = 0;
  for (const Index k : found) {
    const double along = dot(scan.normals[k], p - scan.points[k]),
                 before = depth - scan.viewing.nearness(scan.points[k]);
    const bool has_depth = dot(scan.normals[k], s.to_eye) > steep;
    const bool is_clear = std::fabs(before) >= near_depth && (along > 0) != (before > 0);
    const double d = has_depth && !is_clear ? along : depth_to_normal * before;
    if (s.partner == no_index || std::fabs(d) < least) least = std::fabs(d), s.distance = d, s.partner = k;
  }
  return s;
}

/// One way, for one sign of the normals of the scan that is asked.
struct Count {
  std::size_t facing = 0, agree = 0, in_front = 0, behind = 0;
  ShapeDetail shape;
};

struct OneWay {
  std::size_t asked = 0, in_view = 0;
  std::array<Count, 2> sign;  ///< normals as they are; turned

  [[nodiscard]] bool is_seen(std::size_t k) const { return sign[k].facing >= fewest; }
  [[nodiscard]] double agree(std::size_t k) const {
    return !is_seen(k) ? 0 : static_cast<double>(sign[k].agree) / static_cast<double>(sign[k].facing);
  }
  [[nodiscard]] double shape(std::size_t k) const { return is_seen(k) ? sign[k].shape.correlation() : 0; }
};

/// The queries of `asked`, brought into the coordinates of `seer` by `place` (points) and `turn` (directions).
template <class Place, class Turn>
OneWay look(const JudgedScan& asked, const JudgedScan& seer, double noise, const Place& place, const Turn& turn) {
  const std::size_t n = asked.queries.size();
  Array<Seen> all(n);
  for_blocks(n, 128, [&](std::size_t begin, std::size_t end) {
    std::vector<Index> found;
    for (std::size_t i = begin; i < end; ++i) all[i] = seen(place(asked.points[asked.queries[i]]), seer, found);
  });
  OneWay way;
  way.asked = n;
  const double limit = widths * noise;
  for (std::size_t i = 0; i < n; ++i) {
    const Seen& s = all[i];
    if (!s.in_view) continue;
    ++way.in_view;
    const Index k = asked.queries[i];
    const double towards = dot(turn(asked.normals[k]), s.to_eye);
    for (std::size_t turned = 0; turned < 2; ++turned) {
      const double sign = turned == 0 ? 1 : -1;
      if (!(sign * towards > facing)) continue;
      Count& c = way.sign[turned];
      ++c.facing;
      c.agree += std::fabs(s.distance) <= limit ? 1u : 0u;
      c.in_front += s.distance > limit ? 1u : 0u;
      c.behind += s.distance < -limit ? 1u : 0u;
      c.shape.add(place(asked.points[k]), sign * turn(asked.mean_normals[k]), seer.mean_normals[s.partner]);
    }
  }
  return way;
}

/// Point-to-plane rows of the points in contact, for the free motions alone.
class Contact {
 public:
  Contact(const JudgedScan& moving, const JudgedScan& fixed, const Placing& placing, double noise) {
    for (const Index q : moving.queries) {
      const Point3 p = placing.apply(moving.points[q]);
      const PointTree::Two two = fixed.tree->nearest_two(p);
      const Point3 d = p - fixed.points[two.first];
      const double along = dot(fixed.normals[two.first], d);
      const double aside2 = squared_length(d) - along * along;
      const double reach = beside * fixed.spacing;
      if (aside2 < reach * reach && std::fabs(along) < widths * noise) {
        points_.push_back(p), normals_.push_back(fixed.normals[two.first]);
        middle_ = middle_ + p;
      }
    }
    if (points_.empty()) return;
    middle_ = (1 / static_cast<double>(points_.size())) * middle_;
    double sum = 0;
    for (const Point3& p : points_) sum += squared_length(p - middle_);
    radius_ = std::sqrt(sum / static_cast<double>(points_.size()));
  }
  [[nodiscard]] bool holds() const { return points_.size() > fewest && radius_ > 0; }

  /// Root of the least eigenvalue per point, and its motion.
  double least(const Freedom& f, const std::array<double, 9>& axes, Eigen::VectorXd& motion,
               std::vector<std::size_t>& free) const {
    const std::array<bool, 6> is_free{f.turn_x, f.turn_y, f.turn_z, f.shift_x, f.shift_y, f.shift_z};
    for (std::size_t k = 0; k < 6; ++k)
      if (is_free[k]) free.push_back(k);
    if (free.empty()) return 0;  // scale alone
    const auto size = static_cast<Eigen::Index>(free.size());
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd row(size);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Point3 lever = (1 / radius_) * cross(points_[i] - middle_, normals_[i]);
      for (Eigen::Index k = 0; k < size; ++k) {
        const std::size_t motion_k = free[static_cast<std::size_t>(k)], a = 3 * (motion_k % 3);
        row(k) = dot({axes[a], axes[a + 1], axes[a + 2]}, motion_k < 3 ? lever : normals_[i]);
      }
      matrix += row * row.transpose();
    }
    const Spectrum<Eigen::Dynamic> held = spectrum<Eigen::Dynamic>(matrix / static_cast<double>(points_.size()));
    motion = held.vectors.col(0);
    return std::sqrt(std::max(0.0, held.values(0)));
  }

 private:
  Array<Point3> points_, normals_;
  Point3 middle_{0, 0, 0};
  double radius_ = 0;
};

/// "a turn about (0, 0, 1)", "a shift along (1, 0, 0)", or both, in input axes.
std::string in_words(const Eigen::VectorXd& motion, const std::vector<std::size_t>& free,
                     const std::array<double, 9>& axes) {
  std::array<Point3, 2> parts{Point3{0, 0, 0}, Point3{0, 0, 0}};
  for (std::size_t k = 0; k < free.size(); ++k) {
    const std::size_t a = 3 * (free[k] % 3);
    Point3& part = parts[free[k] / 3];
    part = part + motion(static_cast<Eigen::Index>(k)) * Point3{axes[a], axes[a + 1], axes[a + 2]};
  }
  const double turn = length(parts[0]), shift = length(parts[1]);
  const auto named = [](const char* words, Point3 v, double size) {
    v = (1 / size) * v;
    const double most = std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
    for (const double c : {v.x, v.y, v.z})  // of v and -v, which say the same, the one whose largest part is positive
      if (std::fabs(c) == most) {
        if (c < 0) v = -1.0 * v;
        break;
      }
    return fmt::format("{} ({:.2f}, {:.2f}, {:.2f})", words, v.x + 0.0, v.y + 0.0, v.z + 0.0);
  };
  constexpr double hardly = 0.3;
  std::string text;
  if (turn > hardly) text = named("a turn about", parts[0], turn);
  if (shift > hardly) text += (text.empty() ? "" : " with ") + named("a shift along", parts[1], shift);
  return text;
}

double share(std::size_t part, std::size_t all) {
  return all > 0 ? static_cast<double>(part) / static_cast<double>(all) : 0;
}

}  // namespace

PoseEvidence evidence_at(const JudgedScan& moving, const JudgedScan& fixed, const Pose& pose, const Freedom& freedom,
                         const std::array<double, 9>& axes) {
  PoseEvidence e;
  if (!moving.usable() || !fixed.usable()) return e;
  const Placing placing(pose, moving.origin, fixed.origin);
  const double noise = std::hypot(placing.scale * moving.noise, fixed.noise);
  e.noise = {placing.scale * moving.noise, fixed.noise};
  e.detail = {moving.detail, fixed.detail};
  std::array<OneWay, 2> ways;
  both(
      [&] {
        ways[0] = look(
            moving, fixed, noise, [&](const Point3& p) { return placing.apply(p); },
            [&](const Point3& v) { return placing.direction(v); });
      },
      [&] {
        ways[1] = look(
            fixed, moving, noise / placing.scale, [&](const Point3& p) { return placing.undo(p); },
            [&](const Point3& v) { return placing.direction_back(v); });
      });
  const double f = std::min(moving.within_noise, fixed.within_noise), q = std::min(moving.detail, fixed.detail);
  std::size_t side = 0;
  for (std::size_t k = 0; k < 2; ++k) {
    const double agree = f > 0 ? std::min(ways[0].agree(k), ways[1].agree(k)) / f : 0;
    const double correlation = std::min(ways[0].shape(k), ways[1].shape(k));
    const double shape = q > 0 ? correlation / q : correlation;
    const bool is_seen = ways[0].is_seen(k) && ways[1].is_seen(k), first_is = ways[0].is_seen(0) && ways[1].is_seen(0);
    if (k == 0 || (is_seen && (!first_is || std::min(agree, shape) > e.least())))
      e.agree = agree, e.shape = shape, side = k;
  }
  e.side_known = side == 0;
  e.in_view = {share(ways[0].in_view, ways[0].asked), share(ways[1].in_view, ways[1].asked)};
  const Count &a = ways[0].sign[side], &b = ways[1].sign[side];
  e.points_in_view = a.facing + b.facing;
  e.in_front = share(a.in_front + b.in_front, e.points_in_view);
  e.behind = share(a.behind + b.behind, e.points_in_view);
  const double extent = std::min(placing.scale * moving.extent, fixed.extent);
  e.slip_needed = std::min(most_slip_needed, slip_share * extent / (noise_of_normals * fixed.spacing));
  const Contact contact(moving, fixed, placing, noise);
  if (!contact.holds()) return e;
  Eigen::VectorXd motion;
  std::vector<std::size_t> free;
  e.slip = contact.least(freedom, axes, motion, free) * slip_share * extent / noise;
  e.loosest = free.empty() ? "" : in_words(motion, free, axes);
  return e;
}

Array<PointVerdict> agreement_of(const CloudView& moving, const JudgedScan& fixed, const Pose& pose, double noise,
                                 const Context& context) {
  context.check();
  Array<PointVerdict> result(moving.points.size());
  std::fill(result.begin(), result.end(), PointVerdict::not_in_view);
  if (!fixed.usable()) return result;
  const Placing placing(pose, {0, 0, 0}, fixed.origin);
  for_blocks(result.size(), default_block, [&](std::size_t begin, std::size_t end) {
    std::vector<Index> found;
    for (std::size_t i = begin; i < end; ++i) {
      if (!is_finite(moving.points[i])) continue;
      const Seen s = seen(placing.apply(moving.points[i]), fixed, found);
      if (!s.in_view || std::fabs(dot(fixed.normals[s.partner], s.to_eye)) <= facing) continue;
      const double limit = widths * noise;
      result[i] = s.distance > limit    ? PointVerdict::in_front
                  : s.distance < -limit ? PointVerdict::behind
                                        : PointVerdict::agrees;
    }
  });
  return result;
}

}  // namespace isopach
