#include "isopach/simulate/chewing.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "isopach/base/parallel.hpp"
#include "isopach/base/random.hpp"
#include "isopach/base/types.hpp"
#include "isopach/simulate/scene.hpp"

namespace isopach {
namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr std::uint64_t first_stream = 7000;  // of the frames' random numbers; the scenes use lower ones
constexpr double least_facing = 0.15;         // cosine between normal and view below which nothing is seen

using Matrix3 = std::array<double, 9>;

Matrix3 product(const Matrix3& a, const Matrix3& b) {
  Matrix3 c{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < 3; ++k) c[3 * i + j] += a[3 * i + k] * b[3 * k + j];
  return c;
}

/// About x, then y, then z; degrees.
Matrix3 turns(double x, double y, double z) {
  const double cx = std::cos(x * degree), sx = std::sin(x * degree), cy = std::cos(y * degree),
               sy = std::sin(y * degree), cz = std::cos(z * degree), sz = std::sin(z * degree);
  return product({cz, -sz, 0, sz, cz, 0, 0, 0, 1},
                 product({cy, 0, sy, 0, 1, 0, -sy, 0, cy}, {1, 0, 0, 0, cx, -sx, 0, sx, cx}));
}

Pose turned_about(const Matrix3& r, const Point3& centre, const Point3& shift) {
  Pose pose;
  const std::array<double, 3> c{centre.x, centre.y, centre.z}, s{shift.x, shift.y, shift.z};
  for (std::size_t i = 0; i < 3; ++i) {
    double moved = c[i] + s[i];
    for (std::size_t j = 0; j < 3; ++j) {
      pose.m[4 * i + j] = r[3 * i + j];
      moved -= r[3 * i + j] * c[j];
    }
    pose.m[4 * i + 3] = moved;
  }
  return pose;
}

double smooth_step(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

/// The oval of the scene `face` above the line of the jaw, where the neck begins: both are convex.
Outline face_above_neck() {
  constexpr int corners = 180;
  constexpr double jaw_line = -92, jaw_bend = 1.0 / 90;
  Outline outline;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.5) / corners;
    const Point2 oval{88 * std::cos(angle), 118 * std::sin(angle) - 2};
    // Below the jaw the ray from the middle of the face ends on the parabola y = line + bend x².
    const double s = oval.x * oval.x * jaw_bend;
    const double reach = s > 0 ? (oval.y + std::sqrt(std::max(0.0, oval.y * oval.y - 4 * s * jaw_line))) / (2 * s) : 1;
    const double t = oval.y < jaw_line + s ? std::min(1.0, reach) : 1;
    outline.push_back({t * oval.x, t * oval.y});
  }
  return outline;
}

void check(const ChewingOptions& o) {
  if (o.frames < 1) throw UsageError("chewing: no frames: ask for at least 1");
  if (o.points < 100) throw UsageError(fmt::format("chewing: {} points are too few: ask for at least 100", o.points));
  if (o.points > max_nodes) throw UsageError(fmt::format("chewing: {} points are too many", o.points));
  if (!(o.noise >= 0) || !std::isfinite(o.noise))
    throw UsageError(fmt::format("chewing: noise {} makes no sense: give a standard deviation >= 0", o.noise));
  if (!(o.opening > 0 && o.opening <= 40))
    throw UsageError(fmt::format("chewing: an opening of {} degrees: give more than 0 and at most 40", o.opening));
  if (o.frames_a_cycle < 2) throw UsageError("chewing: a cycle has at least 2 frames");
}

}  // namespace

Chewing::Chewing(const ChewingOptions& options, std::uint64_t seed)
    : options_(options), seed_(seed), height_(scene_surface("face", "", 1)), footprint_(face_above_neck()) {
  check(options);
}

double Chewing::blend(double x, double y) {
  constexpr double corner = 24, mouth = -43.5, rise = 0.9, lips = 1.5, cheek = 36;
  const double beside = std::max(0.0, std::fabs(x) - corner);
  const double line = mouth + rise * beside;
  const double width = lips + (cheek - lips) * smooth_step(beside / 26);
  return 1 - smooth_step((y - line) / width + 0.5);
}

double Chewing::phase(std::size_t k) const {
  return 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(options_.frames_a_cycle);
}

Pose Chewing::head(std::size_t k) const {
  const double t = phase(k) / 3.7;
  return turned_about(turns(2 * std::sin(t), 3 * std::sin(0.7 * t), std::sin(1.3 * t)), {0, -60, 0},
                      {4 * std::sin(0.9 * t), 2 * std::sin(1.1 * t), 5 * std::sin(0.8 * t)});
}

Pose Chewing::jaw(std::size_t k) const {
  const double open = (1 - std::cos(phase(k))) / 2, aside = std::sin(phase(k)) * open;
  return turned_about(turns(options_.opening * open, 2.5 * aside, aside), hinge, {1.5 * aside, -3 * open, 8 * open});
}

Cloud Chewing::frame(std::size_t k) const {
  const Pose h = head(k), j = jaw(k);
  const auto place = [&](double x, double y) {
    const Point3 p{x, y, height_(x, y)}, q = j.apply(p);
    const double b = blend(x, y);
    return h.apply({p.x + b * (q.x - p.x), p.y + b * (q.y - p.y), p.z + b * (q.z - p.z)});
  };
  const Array<Point2> nodes = irregular_nodes(footprint_, options_.points, {seed_, first_stream + k});
  const RandomStream random(seed_, first_stream + k);
  struct Seen {
    Array<Point3> points;
    Array<double> blends;
  };
  Seen seen = reduce_blocks<Seen>(
      nodes.size(), default_block,
      [&](std::size_t begin, std::size_t end) {
        Seen part;
        for (std::size_t i = begin; i < end; ++i) {
          constexpr double step = 1e-4;
          const auto [x, y] = nodes[i];
          Point3 p = place(x, y);
          const Point3 u = place(x + step, y), v = place(x, y + step);
          const Point3 a{u.x - p.x, u.y - p.y, u.z - p.z}, b{v.x - p.x, v.y - p.y, v.z - p.z};
          const Point3 n{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
          if (!(n.z > least_facing * std::hypot(n.x, n.y, n.z))) continue;
          if (options_.noise > 0) p.z += options_.noise * random.normal(i);
          part.points.push_back(p);
          part.blends.push_back(blend(x, y));
        }
        return part;
      },
      [](Seen& all, const Seen& part) {
        all.points.insert(all.points.end(), part.points.begin(), part.points.end());
        all.blends.insert(all.blends.end(), part.blends.begin(), part.blends.end());
      });
  Cloud cloud;
  cloud.points = std::move(seen.points);
  cloud.attributes.push_back({"blend", std::move(seen.blends)});
  cloud.path = fmt::format("frame_{:03d}.ply", k);
  cloud.format = "simulated";
  cloud.unit = cloud.vertical_unit = "mm";
  return cloud;
}

}  // namespace isopach
