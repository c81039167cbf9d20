#include "isopach/apps/face_symmetry.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "isopach/apps/face_template.hpp"
#include "isopach/base/linear.hpp"
#include "isopach/base/median.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/distance/vectors.hpp"

namespace isopach {
namespace {

constexpr double half_width = 0.55, beyond = 0.06, deepest = 0.62, before_tip = 0.12;
constexpr std::size_t dense_points = 16000, neighbours = 14, least_points = 60;
constexpr int most_steps = 14, easy_steps = 5;
constexpr double tukey = 3;
constexpr double still = 1e-6;
constexpr double partner_cosine = 0.8, partner_reach = 0.05;
constexpr double sides_agree = 0.025, middle = 0.08;  // in widths

/// A point of the face, its mirror image's residual and what that says of two turns and a shift.
struct Row {
  Eigen::Vector3d j = Eigen::Vector3d::Zero();
  double r = 0, w = 0;
  double away = 0;       ///< from the plane
  double reach = 0;      ///< distance of the mirror image from its nearest point
  bool partner = false;  ///< near, and as steep
};
using Rows = std::vector<Row>;

/// What a step is solved from, whatever part of the rows takes part.
struct Normal {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  void add(const Row& row, double w) {
    a += w * row.j * row.j.transpose();
    g += w * row.r * row.j;
  }
  [[nodiscard]] Eigen::Vector3d solved() const {
    const Eigen::Matrix3d damped = a + (1e-12 * a.trace() + 1e-300) * Eigen::Matrix3d::Identity();
    return Ldlt(damped).solve(-g);
  }
};

double weight(double r, double reach) {
  const double q = r / reach;
  return q * q < 1 ? (1 - q * q) * (1 - q * q) : 0;
}

/// The face as it takes part: dense points, those of them whose other side is looked for.
struct Core {
  ThinPoints thin;
  std::vector<Index> queries;
  Point3 centre{0, 0, 0};
  double width = 1;
};

Core core_of(std::span<const Point3> points, const FaceFit& fit) {
  constexpr double core_half = 0.50, least_facing = 0.25, margin = 0.07;
  Array<Point3> face;
  for (const Point3& p : points)
    if (in_face(fit.in_widths(p), margin)) face.push_back(p);
  Core core;
  core.width = fit.width;
  core.thin = thin_points(face, dense_points, neighbours);
  Point3 sum{0, 0, 0};
  for (std::size_t i = 0; i < core.thin.points.size(); ++i) {
    const Point3& p = core.thin.points[i];
    if (!(std::fabs(fit.plane.distance(p)) < core_half * fit.width)) continue;
    if (!(std::fabs(dot(core.thin.normals[i], fit.front)) > least_facing)) continue;
    core.queries.push_back(static_cast<Index>(i));
    sum = sum + (p - fit.tip);
  }
  if (!core.queries.empty()) core.centre = fit.tip + 1.0 / static_cast<double>(core.queries.size()) * sum;
  return core;
}

Rows rows_at(const Core& core, const MirrorPlane& plane) {
  Rows rows(core.queries.size());
  Point3 u, v;
  plane_axes(plane.normal, u, v);
  const double reach = std::max(partner_reach * core.width, 3 * core.thin.spacing);
  for_blocks(rows.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Index q = core.queries[i];
      const Point3 &p = core.thin.points[q], image = plane.mirrored(p);
      const PointTree::Two two = core.thin.tree->nearest_two(image);
      const Point3& m = core.thin.normals[two.first];
      const Point3 arm = p - core.centre;
      const double mn = dot(m, plane.normal);
      Row& row = rows[i];
      row.r = dot(m, image - core.thin.points[two.first]);
      row.away = plane.distance(p);
      row.reach = std::sqrt(two.first2);
      row.partner = row.reach < reach && std::fabs(dot(plane.turned(core.thin.normals[q]), m)) > partner_cosine;
      row.j = {-2 * (row.away * dot(m, u) + dot(u, arm) * mn), -2 * (row.away * dot(m, v) + dot(v, arm) * mn), 2 * mn};
    }
  });
  return rows;
}

double spread_of(const Rows& rows) {
  std::vector<double> sizes;
  for (const Row& row : rows)
    if (row.partner) sizes.push_back(std::fabs(row.r));
  return mad_to_sigma * median(sizes);
}

/// The plane moved by a step about the centre.
MirrorPlane moved(const MirrorPlane& plane, const Point3& centre, const Eigen::Vector3d& step) {
  Point3 u, v;
  plane_axes(plane.normal, u, v);
  const Point3 n = plane.normal + step[0] * u + step[1] * v;
  const double size = length(n), offset = (plane.offset - dot(plane.normal, centre) + step[2]) / size;
  return {1 / size * n, offset + dot(1 / size * n, centre)};
}

/// Rows by patch: `across` × `up` of them, by distance from the plane and by height.
template <class PatchOf>
Eigen::Vector3d jackknife(const Rows& rows, int patches, PatchOf&& patch, bool anew, double width) {
  constexpr std::size_t enough = 30;
  std::vector<Eigen::Vector3d> found;
  for (int left_out = 0; left_out < patches; ++left_out) {
    Rows rest;
    std::size_t out = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (!(anew ? rows[i].partner : rows[i].w > 0)) continue;
      if (patch(i) == left_out)
        ++out;
      else
        rest.push_back(rows[i]);
    }
    if (out < (anew ? 10u : 5u) || rest.size() < enough) continue;
    Eigen::Vector3d x = Eigen::Vector3d::Zero();
    for (int round = 0; round < (anew ? 6 : 1); ++round) {
      std::vector<double> sizes;
      for (const Row& row : rest) sizes.push_back(std::fabs(row.r + row.j.dot(x)));
      const double reach = tukey * std::max(mad_to_sigma * median(sizes), 1e-9 * width);
      Normal normal;
      for (const Row& row : rest) normal.add(row, anew ? weight(row.r + row.j.dot(x), reach) : row.w);
      x = normal.solved();
    }
    found.push_back(x);
  }
  if (found.size() < 3) return Eigen::Vector3d::Constant(1e3);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero(), variance = Eigen::Vector3d::Zero();
  const auto n = static_cast<double>(found.size());
  for (const Eigen::Vector3d& x : found) mean += x / n;
  for (const Eigen::Vector3d& x : found) variance += (n - 1) / n * (x - mean).cwiseAbs2();
  return variance;
}

void describe_sigma(const Rows& rows, const std::vector<double>& heights, double width, FaceSymmetry& found) {
  constexpr double inner = 0.22;
  const auto range = std::minmax_element(heights.begin(), heights.end());
  const double low = *range.first, extent = *range.second - low + 1e-9;
  const auto row_of = [&](std::size_t i, int count) {
    return std::clamp(static_cast<int>((heights[i] - low) / extent * count), 0, count - 1);
  };
  const Eigen::Vector3d small = jackknife(
      rows, 24,
      [&](std::size_t i) {
        return std::min(static_cast<int>(std::fabs(rows[i].away) / (.125 * width)), 3) * 6 + row_of(i, 6);
      },
      false, width);
  const Eigen::Vector3d large = jackknife(
      rows, 6, [&](std::size_t i) { return (std::fabs(rows[i].away) > inner * width ? 3 : 0) + row_of(i, 3); }, true,
      width);
  const double variance = std::max(small[0] + small[1], large[0] + large[1]);
  found.sigma_angle = std::min(90.0, std::sqrt(variance) * 180 / std::numbers::pi);
  found.sigma_offset = std::sqrt(std::max(small[2], large[2]));
}

void describe_sides(const Rows& rows, double width, FaceSymmetry& found) {
  double far = 0, both = 0, agree = 0;
  for (const Row& row : rows) {
    if (!(std::fabs(row.away) > middle * width)) continue;
    far += 1;
    if (!(row.reach < partner_reach * width || row.partner)) continue;
    both += 1;
    agree += row.partner && std::fabs(row.r) < sides_agree * width ? 1 : 0;
  }
  found.both = far > 0 ? both / far : 0;
  found.agree = both > 0 ? agree / both : 0;
}

}  // namespace

bool in_face(const Point3& p, double margin) {
  const FaceTemplate& face = face_template();
  return std::fabs(p.x) <= half_width + margin && p.y > face.chin - beyond && p.y < face.hairline + beyond &&
         p.z > -deepest && p.z < before_tip;
}

FaceSymmetry face_symmetry(std::span<const Point3> points, const FaceFit& fit) {
  FaceSymmetry found;
  found.plane = fit.plane;
  const Core core = core_of(points, fit);
  found.points = core.queries.size();
  if (core.queries.size() < least_points) return found;
  double scale = 0.02 * fit.width;
  Rows rows;
  for (int step = 0; step < most_steps; ++step) {
    rows = rows_at(core, found.plane);
    const double s = std::max(spread_of(rows), 1e-9 * fit.width);
    found.spread = s / fit.width;
    scale = step < easy_steps ? std::max(s, scale / 2) : s;
    Normal normal;
    for (Row& row : rows) {
      row.w = row.partner ? weight(row.r, tukey * scale) : 0;
      normal.add(row, row.w);
    }
    const Eigen::Vector3d x = normal.solved();
    const MirrorPlane next = moved(found.plane, core.centre, x);
    const bool stands = std::hypot(x[0], x[1]) < still && std::fabs(x[2]) < still * fit.width;
    found.plane = next;
    if (stands) break;
  }
  std::vector<double> heights(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) heights[i] = dot(core.thin.points[core.queries[i]] - fit.tip, fit.up);
  describe_sigma(rows, heights, fit.width, found);
  describe_sides(rows, fit.width, found);
  return found;
}

}  // namespace isopach
