#include "isopach/simulate/face_and_jaw.hpp"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "isopach/base/random.hpp"
#include "isopach/base/types.hpp"
#include "isopach/simulate/sampling.hpp"
#include "isopach/simulate/scene.hpp"

namespace isopach {
namespace {

constexpr std::uint64_t first_stream = 9000;
constexpr double half_x = 40, half_y = 22;  // of the plate

struct Hill {
  double x, y, width, height;
};
constexpr Hill hills[] = {{-24, 8, 7, 8}, {-6, -10, 5, 5}, {13, 7, 9, 10},
                          {28, -9, 4, 5}, {0, 12, 4, -3},  {-30, -12, 5, 3}};

double plate(double x, double y) {
  double z = 0;
  for (const Hill& h : hills) {
    const double u = (x - h.x) / h.width, v = (y - h.y) / h.width;
    z += h.height * std::exp(-0.5 * (u * u + v * v));
  }
  return z;
}

/// A cast: teeth along a parabola on a wavy base.
double cast(double x, double y) {
  const double along = y - 18 + x * x / 26, slope = 2 * x / 26;
  const double off = along / std::sqrt(1 + slope * slope);
  const double arc = std::asinh(slope) * 6.5 + 0.5 * x * std::sqrt(1 + slope * slope);
  const double inside = 0.5 + 0.5 * std::tanh((y + 24) / 4);
  const double ridge = 9 * std::exp(-off * off / 60) * inside;
  const double teeth =
      5 * std::exp(-off * off / 14) * (0.55 + 0.45 * std::cos(2 * std::numbers::pi * arc / 7.5)) * inside;
  return ridge + teeth + 1.5 * std::sin(x / 17) * std::cos(y / 13);
}

Pose from_angles(double x, double y, double z, const Point3& shift) {
  const double cx = std::cos(x), sx = std::sin(x), cy = std::cos(y), sy = std::sin(y), cz = std::cos(z),
               sz = std::sin(z);
  Pose p;
  p.m = {cz * cy,
         cz * sy * sx - sz * cx,
         cz * sy * cx + sz * sx,
         shift.x,
         sz * cy,
         sz * sy * sx + cz * cx,
         sz * sy * cx - cz * sx,
         shift.y,
         -sy,
         cy * sx,
         cy * cx,
         shift.z,
         0,
         0,
         0,
         1};
  return p;
}

Pose after(const Pose& b, const Pose& a) {
  Pose c;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 4; ++j) {
      c.m[4 * i + j] = j == 3 ? b.m[4 * i + 3] : 0;
      for (std::size_t k = 0; k < 3; ++k) c.m[4 * i + j] += b.m[4 * i + k] * a.m[4 * k + j];
    }
  return c;
}

Pose backwards(const Pose& a) {
  Pose c;
  for (std::size_t i = 0; i < 3; ++i) {
    c.m[4 * i + 3] = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      c.m[4 * i + j] = a.m[4 * j + i];
      c.m[4 * i + 3] -= a.m[4 * j + i] * a.m[4 * j + 3];
    }
  }
  return c;
}

/// Any turn, and a shift of some decimetres.
Pose any_pose(std::uint64_t seed, std::uint64_t which) {
  const RandomStream random(seed, first_stream + 100 + which);
  const auto angle = [&](std::uint64_t i) { return 2 * std::numbers::pi * random.uniform(i); };
  const auto shift = [&](std::uint64_t i) { return 400 * random.uniform(i) - 200; };
  return from_angles(angle(0), angle(1), angle(2), {shift(3), shift(4), shift(5)});
}

/// Points of a surface over its footprint where `seen` says so, noisy along z, in coordinates turned by `pose`.
struct Scanner {
  std::uint64_t seed, scan;
  double noise;
  Pose pose;

  std::size_t add(Cloud& cloud, const Outline& footprint, std::size_t count, std::uint64_t part,
                  const std::function<double(double, double)>& height, const Pose& place,
                  const std::function<bool(const Point3&)>& seen) const {
    const std::uint64_t stream = first_stream + 10 * scan + part;
    const RandomStream random(seed, stream);
    std::size_t added = 0;
    const Array<Point2> nodes = irregular_nodes(footprint, count, {seed, stream});
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      Point3 p = place.apply({nodes[i].x, nodes[i].y, height(nodes[i].x, nodes[i].y)});
      if (!seen(p)) continue;
      if (noise > 0) p.z += noise * random.normal(i);
      cloud.points.push_back(pose.apply(p));
      ++added;
    }
    return added;
  }
};

Cloud named(const char* path) {
  Cloud cloud;
  cloud.path = path;
  cloud.format = "simulated";
  cloud.unit = cloud.vertical_unit = "mm";
  return cloud;
}

/// The lower part of the face.
Outline face_outline() {
  constexpr int corners = 96;
  constexpr double from = 20;
  Outline outline;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.5) / corners;
    outline.push_back({88 * std::cos(angle), std::min(from, 118 * std::sin(angle) - 2)});
  }
  return outline;
}

}  // namespace

FaceAndJaw make_face_and_jaw(const FaceAndJawOptions& o, std::uint64_t seed) {
  if (o.points < 1000) throw UsageError(fmt::format("combine: {} points are too few: ask for at least 1000", o.points));
  if (o.points > max_nodes) throw UsageError(fmt::format("combine: {} points are too many", o.points));
  if (!(o.noise >= 0) || !std::isfinite(o.noise))
    throw UsageError(fmt::format("combine: noise {} makes no sense: give a standard deviation >= 0", o.noise));
  const Outline object = rectangle({-half_x, -half_y}, {half_x, half_y});
  const auto everything = [](const Point3&) { return true; };
  FaceAndJaw s{named("face.ply"), named("jaw.ply"), named("reference.ply"), {}, {}, {}, 0, 0};

  const auto scan = [&](Cloud& cloud, std::uint64_t which, const Outline& outline,
                        const std::function<double(double, double)>& height, const Pose& held, const Pose& pose) {
    const Scanner scanner{seed, which, o.noise, pose};
    const double area = polygon_area(outline), plate_area = o.held ? polygon_area(object) : 0;
    const auto count = static_cast<std::size_t>(static_cast<double>(o.points) * area / (area + plate_area));
    const Pose to_plate = backwards(held);
    const auto beside = [&](const Point3& p) {
      const Point3 q = to_plate.apply(p);
      return !o.held || std::fabs(q.x) > half_x || std::fabs(q.y) > half_y;
    };
    scanner.add(cloud, outline, count, 0, height, Pose{}, beside);
    if (!o.held) return 0.0;
    const std::size_t on = scanner.add(cloud, object, o.points - count, 1, plate, held, everything);
    return static_cast<double>(on) / static_cast<double>(cloud.points.size());
  };

  const Pose in_face = from_angles(0.12, -0.2, 0.3, {6, -52, 128}), in_jaw = from_angles(-0.1, 0.15, 1.4, {62, -8, 22});
  const Pose face_pose = any_pose(seed, 0), jaw_pose = any_pose(seed, 1), reference_pose = any_pose(seed, 2);
  s.face_share = scan(s.face, 0, face_outline(), scene_surface("face", "", 1), in_face, face_pose);
  s.jaw_share = scan(s.jaw, 1, rectangle({-70, -62}, {70, 62}), cast, in_jaw, jaw_pose);
  Scanner{seed, 2, o.noise, reference_pose}.add(s.reference, object, o.points / 4, 0, plate, Pose{}, everything);
  s.face_reference = after(after(face_pose, in_face), backwards(reference_pose));
  s.jaw_reference = after(after(jaw_pose, in_jaw), backwards(reference_pose));
  s.face_jaw = after(s.face_reference, backwards(s.jaw_reference));
  return s;
}

}  // namespace isopach
