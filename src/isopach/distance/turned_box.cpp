#include "isopach/distance/turned_box.hpp"

#include <algorithm>
#include <optional>

#include "isopach/distance/vectors.hpp"

namespace isopach {
namespace {

using Triangles = TurnedBox::Triangles;

// What rounding of the axes and of products with them comes to, several times over.
constexpr double slack = 32 * std::numeric_limits<double>::epsilon();
// Pyramids are not wider: slopes of their sides.
constexpr double widest = 1;
// The tip is taken for the closest point only where the rest of the triangle is farther by more than rounding: squared
// ratio of the size of the triangles to the distance.
constexpr double least_reach = 1e-12;

/// The corner for which `size` of the way from `from` is largest; the first of those.
template <class Size>
Point3 farthest(Triangles triangles, const Point3& from, Size&& size) {
  Point3 best = from;
  double most = -1;
  for (const auto& corners : triangles)
    for (const Point3& p : corners)
      if (const double s = size(p - from); s > most) most = s, best = p;
  return best;
}

Point3 beside(const Point3& vector, const Point3& axis) { return vector - dot(vector, axis) * axis; }

/// The unit vector of `vector` less what of it is along `axis`; where nothing is left, any at a right angle.
Point3 across(const Point3& vector, const Point3& axis) {
  const Point3 once = beside(vector, axis);
  if (length(once) > 0) {  // of a vector along the axis it is rounding, which the second step shows
    const Point3 twice = beside((1 / length(once)) * once, axis);
    if (length(twice) > 0.5) return (1 / length(twice)) * twice;
  }
  const double x = std::fabs(axis.x), y = std::fabs(axis.y), z = std::fabs(axis.z);
  const Point3 any = x <= y && x <= z ? Point3{1, 0, 0} : y <= z ? Point3{0, 1, 0} : Point3{0, 0, 1};
  const Point3 instead = beside(any, axis);
  return (1 / length(instead)) * instead;
}

bool has(const std::array<Point3, 3>& corners, const Point3& p) {
  return corners[0] == p || corners[1] == p || corners[2] == p;
}

/// A corner of all triangles, if there are two at least.
std::optional<Point3> common_corner(Triangles triangles) {
  if (triangles.size() < 2) return {};
  for (const Point3& p : triangles[0])
    if (std::all_of(triangles.begin(), triangles.end(), [&](const auto& corners) { return has(corners, p); })) return p;
  return {};
}

double sum_of_sizes(const Point3& p) { return std::fabs(p.x) + std::fabs(p.y) + std::fabs(p.z); }

/// Squared length of the height over p's opposite side, or of the shorter side at p. p is a corner.
double reach2(const std::array<Point3, 3>& c, const Point3& p) {
  const std::size_t k = c[0] == p ? 0 : c[1] == p ? 1 : 2;
  const Point3 a = c[(k + 1) % 3] - p, b = c[(k + 2) % 3] - p, side = b - a;
  const double shorter = std::min(squared_length(a), squared_length(b));
  if (!(dot(a, side) < 0 && dot(b, side) > 0)) return shorter;
  return std::min(shorter, squared_length(cross(a, side)) / squared_length(side));
}

}  // namespace

TurnedBox::TurnedBox(Triangles triangles) {
  const std::optional<Point3> tip = common_corner(triangles);
  const Point3 first = triangles[0][0];
  origin_ = tip ? *tip : farthest(triangles, first, squared_length);
  turn(triangles, farthest(triangles, origin_, squared_length) - origin_);
  if (tip) find_pyramid(triangles);
}

void TurnedBox::turn(Triangles triangles, const Point3& way) {
  axes_[0] = length(way) > 0 ? (1 / length(way)) * way : Point3{1, 0, 0};
  const Point3 aside =
      farthest(triangles, origin_, [&](const Point3& v) { return squared_length(beside(v, axes_[0])); });
  axes_[1] = across(aside - origin_, axes_[0]);
  axes_[2] = cross(axes_[0], axes_[1]);
  double pad = 0;
  for (const auto& corners : triangles)
    for (const Point3& p : corners) {
      box_.add(inside(p - origin_));
      pad = std::max(pad, slack * sum_of_sizes(p));
    }
  box_.min = box_.min - Point3{pad, pad, pad};
  box_.max = box_.max + Point3{pad, pad, pad};
}

void TurnedBox::find_pyramid(Triangles triangles) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  low_ = {infinity, infinity}, high_ = {-infinity, -infinity}, reach2_ = infinity;
  for (const auto& corners : triangles) {
    reach2_ = std::min(reach2_, reach2(corners, origin_));
    for (const Point3& p : corners) {
      if (p == origin_) continue;
      const Point3 v = inside(p - origin_);
      if (!(std::max(std::fabs(v.y), std::fabs(v.z)) <= widest * v.x)) return;
      low_ = {std::min(low_[0], v.y / v.x - slack), std::min(low_[1], v.z / v.x - slack)};
      high_ = {std::max(high_[0], v.y / v.x + slack), std::max(high_[1], v.z / v.x + slack)};
    }
  }
  fan_ = low_[0] <= high_[0];
}

Point3 TurnedBox::inside(const Point3& v) const { return {dot(axes_[0], v), dot(axes_[1], v), dot(axes_[2], v)}; }

double TurnedBox::area() const { return area_of(box_); }

TurnedBox::Bound TurnedBox::bound(const Point3& p) const {
  const Point3 from = p - origin_, q = inside(from);
  const double pad = slack * sum_of_sizes(from);
  const double x = std::max({box_.min.x - q.x - pad, 0.0, q.x - box_.max.x - pad});
  const double y = std::max({box_.min.y - q.y - pad, 0.0, q.y - box_.max.y - pad});
  const double z = std::max({box_.min.z - q.z - pad, 0.0, q.z - box_.max.z - pad});
  const double to_box = (1 - slack) * (x * x + y * y + z * z);
  if (!fan_) return {to_box, false};
  const Bound to_tip = to_pyramid(q, pad, pad + slack * sum_of_sizes(p));
  return {std::max(to_box, to_tip.distance2), to_tip.at_tip};
}

/// Of the half-spaces that its sides bound. Those of two sides at an angle whose cosine is c in size leave
/// (1 − c)·(d1² + d2²) of the squared distance at least.
TurnedBox::Bound TurnedBox::to_pyramid(const Point3& q, double rounding, double pad) const {
  const double ahead = q.x + std::max(low_[0] * q.y, high_[0] * q.y) + std::max(low_[1] * q.z, high_[1] * q.z);
  const double distance2 = squared_length(q);
  if (ahead < -2 * rounding && reach2_ >= least_reach * distance2) return {(1 - slack) * distance2, true};
  const double beside[2] = {q.y, q.z};
  double sum = 0, angle = 1;
  for (std::size_t k = 0; k < 2; ++k) {
    const double under = (low_[k] * q.x - beside[k]) / std::sqrt(1 + low_[k] * low_[k]);
    const double over = (beside[k] - high_[k] * q.x) / std::sqrt(1 + high_[k] * high_[k]);
    const double d = std::max({under - 2 * pad, over - 2 * pad, 0.0});
    angle *= d == 0 ? 0 : std::fabs(under > over ? low_[k] : high_[k]);
    sum += d * d;
  }
  return {(1 - slack - std::min(angle, 0.5)) * sum, false};
}

TurnedBox::Line TurnedBox::turned(const Point3& p, const Point3& direction) const {
  const Point3 from = p - origin_;
  const double pad = slack * sum_of_sizes(from);
  Line line{inside(from), inside(direction), box_};
  line.box.min = line.box.min - Point3{pad, pad, pad};
  line.box.max = line.box.max + Point3{pad, pad, pad};
  return line;
}

double area_of(const Box3& box) {
  const Point3 d = box.max - box.min;
  return d.x * d.y + d.y * d.z + d.z * d.x;
}

}  // namespace isopach
