#include "isopach/apps/symmetry_planes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "isopach/base/linear.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/random.hpp"
#include "isopach/distance/vectors.hpp"

namespace isopach {
namespace {

constexpr std::size_t directions = 110;
constexpr std::size_t few_points = 350;
constexpr std::size_t kept_starts = 120;  // after four steps
constexpr std::size_t most_planes = 8;
constexpr double least_score = 0.4;                 // of the best
constexpr double same_cosine = 0.9925461516413220;  // of 7 degrees
constexpr double same_offset = 0.07;
constexpr double near_plane = 0.25;  // points nearer than this match themselves and prove little

/// How a step believes its pairs: width of the weights, largest distance, least cosine of the normals.
struct Belief {
  double width, reach, cosine;
};
constexpr Belief coarse_steps[] = {{.10, .6, .6},  {.08, .5, .6}, {.06, .4, .6}, {.05, .3, .6},
                                   {.04, .25, .6}, {.03, .2, .6}, {.025, .2, .6}};
constexpr std::size_t sorting_step = 3;
constexpr Belief last_look{.02, .15, .8};
constexpr Belief fine_steps[] = {{.03, .2, .8}, {.02, .15, .8}, {.015, .1, .8}, {.012, .08, .8}, {.012, .08, .8}};

/// What one step sums: the normal equations of two turns and a shift, and the weights.
struct Sums {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  double weight = 0, far_weight = 0;
};

template <class Nearest>
Sums sums_at(const MirrorPlane& plane, const ThinPoints& thin, std::span<const Index> queries, const Belief& belief,
             Nearest&& nearest) {
  Sums sums;
  Point3 u, v;
  plane_axes(plane.normal, u, v);
  for (const Index i : queries) {
    const Point3& p = thin.points[i];
    const Point3 image = plane.mirrored(p);
    const Index j = nearest(image);
    const Point3 &m = thin.normals[j], d = image - thin.points[j];
    if (!(squared_length(d) < belief.reach * belief.reach)) continue;
    if (!(std::fabs(dot(plane.turned(thin.normals[i]), m)) > belief.cosine)) continue;
    const double r = dot(m, d), q = 1 + (r / belief.width) * (r / belief.width), w = 1 / (q * q);
    const double away = plane.distance(p), mn = dot(m, plane.normal);
    const Eigen::Vector3d j3(-2 * (away * dot(m, u) + dot(u, p) * mn), -2 * (away * dot(m, v) + dot(v, p) * mn),
                             2 * mn);
    sums.a += w * j3 * j3.transpose();
    sums.g += w * r * j3;
    sums.weight += w;
    sums.far_weight += w * std::min(std::fabs(away) / near_plane, 1.0);
  }
  return sums;
}

MirrorPlane stepped(const MirrorPlane& plane, const Sums& sums) {
  constexpr double damping = 1e-4, nothing = 1e-12, most_turn = 0.15;
  const Eigen::Matrix3d a = sums.a + (damping * sums.a.trace() + nothing) * Eigen::Matrix3d::Identity();
  const Eigen::Vector3d s = Ldlt(a).solve(-sums.g);
  Point3 u, v;
  plane_axes(plane.normal, u, v);
  const double turn = std::clamp(s[0], -most_turn, most_turn), roll = std::clamp(s[1], -most_turn, most_turn);
  const Point3 n = plane.normal + turn * u + roll * v;
  const double size = length(n);
  return {1 / size * n, (plane.offset + s[2]) / size};
}

struct Start {
  MirrorPlane plane;
  double score = 0;
  std::size_t number = 0;
};

std::vector<Start> starts() {
  std::vector<Start> all;
  for (std::size_t k = 0; k < directions; ++k) {
    const double z = 1 - (static_cast<double>(k) + 0.5) / directions, r = std::sqrt(1 - z * z);
    const double turn = std::numbers::pi * (1 + std::sqrt(5.0)) * (static_cast<double>(k) + 0.5);
    for (const double offset : {-0.25, 0.0, 0.25})
      all.push_back({{{r * std::cos(turn), r * std::sin(turn), z}, offset}, 0, all.size()});
  }
  return all;
}

void best_first(std::vector<Start>& all) {
  std::sort(all.begin(), all.end(), [](const Start& a, const Start& b) {
    return a.score != b.score ? a.score > b.score : a.number < b.number;
  });
}

bool same(const MirrorPlane& a, const MirrorPlane& b) {
  const double cosine = dot(a.normal, b.normal), offset = cosine > 0 ? a.offset : -a.offset;
  return std::fabs(cosine) > same_cosine && std::fabs(offset - b.offset) < same_offset;
}

/// A fixed choice of points: which ones is a matter of their order alone.
Array<Index> chosen(std::size_t n) {
  Array<Index> order(n);
  std::iota(order.begin(), order.end(), Index{0});
  const RandomStream random(1, 1);
  std::sort(order.begin(), order.end(), [&](Index a, Index b) { return random.bits(a) < random.bits(b); });
  order.resize(std::min(n, few_points));
  return order;
}

std::vector<Start> candidates(const ThinPoints& thin, const NearestGrid& grid) {
  const Array<Index> queries = chosen(thin.points.size());
  const auto nearest = [&](const Point3& p) { return grid.near(p); };
  std::vector<Start> all = starts();
  for (std::size_t k = 0; k < std::size(coarse_steps); ++k) {
    for_blocks(all.size(), 4, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const Sums sums = sums_at(all[i].plane, thin, queries, coarse_steps[k], nearest);
        all[i].plane = stepped(all[i].plane, sums);
        all[i].score = sums.weight;
      }
    });
    if (k == sorting_step) best_first(all), all.resize(std::min(all.size(), kept_starts));
  }
  for_blocks(all.size(), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Sums sums = sums_at(all[i].plane, thin, queries, last_look, nearest);
      all[i].score = sums.far_weight / static_cast<double>(queries.size());
      all[i].plane = stepped(all[i].plane, sums);
    }
  });
  best_first(all);
  std::vector<Start> kept;
  for (const Start& s : all) {
    if (kept.size() == most_planes || s.score < least_score * all.front().score) break;
    const auto known = [&](const Start& other) { return same(s.plane, other.plane); };
    if (std::none_of(kept.begin(), kept.end(), known)) kept.push_back(s);
  }
  return kept;
}

/// Of the points away from the plane, those that have a partner on the other side.
double share_of(const MirrorPlane& plane, const ThinPoints& thin) {
  constexpr double away = 0.15, least_cosine = 0.85;
  const double most = std::max(0.02, thin.spacing / 2), beside = 2.2 * thin.spacing;
  double far = 0, agree = 0;
  for (std::size_t i = 0; i < thin.points.size(); ++i) {
    if (!(std::fabs(plane.distance(thin.points[i])) > away)) continue;
    far += 1;
    const Point3 image = plane.mirrored(thin.points[i]);
    const PointTree::Two two = thin.tree->nearest_two(image);
    const Point3& m = thin.normals[two.first];
    if (two.first2 < beside * beside && std::fabs(dot(m, image - thin.points[two.first])) < most &&
        std::fabs(dot(plane.turned(thin.normals[i]), m)) > least_cosine)
      agree += 1;
  }
  return far > 0 ? agree / far : 0;
}

}  // namespace

void plane_axes(const Point3& normal, Point3& u, Point3& v) {
  const Point3 a = std::fabs(normal.x) < 0.6 ? Point3{1, 0, 0} : Point3{0, 1, 0};
  u = a - dot(a, normal) * normal;
  u = 1 / length(u) * u;
  v = cross(normal, u);
}

std::vector<SymmetryPlane3> symmetry_planes(const ThinPoints& points, const NearestGrid& grid) {
  const std::vector<Start> starts = candidates(points, grid);
  std::vector<SymmetryPlane3> planes(starts.size());
  Array<Index> all(points.points.size());
  std::iota(all.begin(), all.end(), Index{0});
  for_blocks(planes.size(), 1, [&](std::size_t k, std::size_t) {
    planes[k].plane = starts[k].plane;
    planes[k].score = starts[k].score;
    for (const Belief& belief : fine_steps)
      planes[k].plane = stepped(planes[k].plane, sums_at(planes[k].plane, points, all, belief, [&](const Point3& p) {
                                  return points.tree->nearest_two(p).first;
                                }));
    planes[k].share = share_of(planes[k].plane, points);
  });
  return planes;
}

}  // namespace isopach
