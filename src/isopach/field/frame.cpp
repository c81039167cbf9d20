// The frame of a pair: direction, origin, curve box. Everything here is a function of the two sets of points: minima,
// maxima and integer sums do not depend on the order of the points, of the clouds or of the threads.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <fmt/format.h>

#include "isopach/base/error.hpp"
#include "isopach/base/linear.hpp"
#include "isopach/field/extent.hpp"
#include "isopach/field/filter.hpp"
#include "isopach/field/height_field.hpp"

namespace isopach {
namespace {

__extension__ using Int128 = __int128;

// Largest side of the joint box. The in-circle determinant is of degree 4 in it and must stay a finite double.
constexpr double min_extent = 1e-60;

// Smallest k with 2^k >= x > 0.
int ceil_log2(double x) {
  int exponent = 0;
  return std::frexp(x, &exponent) == 0.5 ? exponent - 1 : exponent;
}

// An origin o for [lo, hi] such that x − o is exact for every double x in it.
// Proof. Let e = hi − lo, c the centre. If |c| < 4e then o = 0. Otherwise take c > 0; o = k·s is the multiple of
// s = 2^ceil(log2 e) nearest to c, and s < 2e gives |o − c| <= s/2 < e. From x in [c − e/2, c + e/2] and c >= 4e:
//   2x >= 2c − e >= c + 3e > o    and    2o > 2c − 2e >= c + 2e > x,
// so o/2 <= x <= 2o and x − o is exact [Sterbenz1974]. The rounding of c (one unit in its last place, far below e or
// equal to it) is covered by the slack of e. o is a double: x and e are multiples of the unit u in the last place of lo
// or more, so s >= u and k = c/s stays within 53 bits. e is exact, since hi/2 <= lo. For c < 0 mirror.
// Then (x − o) + o = x exactly, too: the sum is a double, namely x.
double exact_origin(double lo, double hi) {
  const double extent = hi - lo;
  if (extent == 0) return lo + 0.0;
  const double centre = lo + extent / 2;
  if (std::fabs(centre) < 4 * extent) return 0;
  const double step = std::ldexp(1.0, ceil_log2(extent));
  return std::nearbyint(centre / step) * step;
}

Box3 kept_box(const Filter& filter) {
  return reduce_kept<Box3>(
      filter, [](Box3& box, const Point3& p) { box.add(p); }, [](Box3& total, const Box3& part) { total.add(part); });
}

Box3 field_box(const Filter& filter, const Frame& frame) {
  return reduce_kept<Box3>(
      filter, [&](Box3& box, const Point3& p) { box.add(frame.to_field(p)); },
      [](Box3& total, const Box3& part) { total.add(part); });
}

double largest_side(const Box3& box) {
  return std::max({box.max.x - box.min.x, box.max.y - box.min.y, box.max.z - box.min.z});
}

// Sums over points on a grid of 2^40 steps along the box: the integers are exact, so their order does not matter. A
// product has 80 bits, so 2^46 points fit.
struct Moments {
  std::int64_t count = 0;
  std::array<Int128, 3> sum{};
  std::array<Int128, 6> product{};  // xx xy xz yy yz zz

  void add(const std::array<std::int64_t, 3>& q) {
    ++count;
    for (std::size_t i = 0, k = 0; i < 3; ++i) {
      sum[i] += q[i];
      for (std::size_t j = i; j < 3; ++j) product[k++] += Int128{q[i]} * q[j];
    }
  }
  void add(const Moments& other) {
    count += other.count;
    for (std::size_t i = 0; i < 3; ++i) sum[i] += other.sum[i];
    for (std::size_t k = 0; k < 6; ++k) product[k] += other.product[k];
  }
};

Moments moments(const Filter& filter, const Box3& box) {
  const int shift = 40 - ceil_log2(largest_side(box));
  const auto on_grid = [&](double x, double lo) { return std::llrint(std::ldexp(x - lo, shift)); };
  return reduce_kept<Moments>(
      filter,
      [&](Moments& m, const Point3& p) {
        m.add(std::array<std::int64_t, 3>{on_grid(p.x, box.min.x), on_grid(p.y, box.min.y), on_grid(p.z, box.min.z)});
      },
      [](Moments& total, const Moments& part) { total.add(part); });
}

// Scatter about the mean, scaled to trace 1. Shifting by the mean rounded to an integer is exact; what is left of the
// mean (half a step of 2^-40) is nothing beside any scatter that passes the check in fitted_normal.
Eigen::Matrix3d scatter(const Moments& m) {
  std::array<Int128, 3> mean{};
  for (std::size_t i = 0; i < 3; ++i) mean[i] = m.sum[i] / m.count;
  Eigen::Matrix3d result;
  for (std::size_t i = 0, k = 0; i < 3; ++i)
    for (std::size_t j = i; j < 3; ++j, ++k) {
      const Int128 centred =
          m.product[k] - mean[i] * m.sum[j] - mean[j] * m.sum[i] + Int128{m.count} * mean[i] * mean[j];
      result(static_cast<int>(i), static_cast<int>(j)) = result(static_cast<int>(j), static_cast<int>(i)) =
          static_cast<double>(centred);
    }
  return result / result.trace();
}

// Normal of the plane of total least squares: the eigenvector of the least eigenvalue. Points up; if the plane is
// vertical, the largest component is positive.
Point3 fitted_normal(const Filter& a, const Filter& b, const Box3& box) {
  const std::string names = cloud_name(a.cloud()) + " and " + cloud_name(b.cloud());
  const auto no_plane = [&] {
    return InputError(names +
                      ": the points lie on a line, so no plane can be fitted; give a direction (x, y, z or X,Y,Z)");
  };
  if (largest_side(box) == 0) throw no_plane();
  Moments m = moments(a, box);
  m.add(moments(b, box));
  const Spectrum<3> axes = spectrum(scatter(m));
  constexpr double line = 1e-14;  // the solver's rounding error, relative to the largest eigenvalue, with slack
  if (!(axes.values(1) > line * axes.values(2))) throw no_plane();
  std::array<double, 3> n{};
  for (std::size_t i = 0; i < 3; ++i) n[i] = axes.vectors(static_cast<int>(i), 0);
  constexpr double vertical = 1e-9;
  std::size_t lead = 2;
  if (std::fabs(n[2]) < vertical) lead = std::fabs(n[0]) >= std::fabs(n[1]) ? 0 : 1;
  const double sign = n[lead] < 0 ? -1 : 1;
  return {sign * n[0], sign * n[1], sign * n[2]};
}

Point3 unit_vector(const Point3& v) {
  const double largest = std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
  if (!is_finite(v) || largest == 0)
    throw UsageError(fmt::format("direction {},{},{} is not a vector; give x, y, z, fit or three numbers, not all 0",
                                 v.x, v.y, v.z));
  const double x = v.x / largest, y = v.y / largest, z = v.z / largest;
  const double length = std::sqrt(x * x + y * y + z * z);
  return {x / length, y / length, z / length};
}

// Rows u, v, w of the right-handed frame that looks along w (a unit vector): the axis nearest to w is turned into w by
// the smallest rotation, the other two axes, in cyclic order, go with it [Duff2017]. w = x, y, z gives the cyclic
// permutations (y z x), (z x y), (x y z); w = −z gives (x, −y, −z) and so on: entries are then exactly 0 and ±1.
std::array<double, 9> frame_along(const Point3& w) {
  const std::array<double, 3> n{w.x, w.y, w.z};
  std::size_t axis = 2;
  for (std::size_t i : {1, 0})
    if (std::fabs(n[i]) > std::fabs(n[axis])) axis = i;
  const std::size_t first = (axis + 1) % 3, second = (axis + 2) % 3;
  const double x = n[first], y = n[second], z = n[axis];
  const double sign = std::copysign(1.0, z), a = -1 / (sign + z), b = x * y * a;
  std::array<double, 9> rows{};
  const auto set_row = [&](std::size_t row, double cx, double cy, double cz) {
    rows[3 * row + first] = cx + 0.0;
    rows[3 * row + second] = cy + 0.0;
    rows[3 * row + axis] = cz + 0.0;
  };
  set_row(0, 1 + sign * x * x * a, sign * b, -sign * x);
  set_row(1, b, sign + y * y * a, -y);
  set_row(2, x, y, z);
  return rows;
}

Point3 direction_of(const Filter& a, const Filter& b, const Box3& box, const Direction& direction) {
  switch (direction.kind) {
    case Direction::Kind::axis_x:
      return {1, 0, 0};
    case Direction::Kind::axis_y:
      return {0, 1, 0};
    case Direction::Kind::axis_z:
      return {0, 0, 1};
    case Direction::Kind::vector:
      return unit_vector(direction.vector);
    case Direction::Kind::fit:
      return fitted_normal(a, b, box);
  }
  throw UsageError("unknown kind of direction");
}

}  // namespace

// Where the rotation only permutes axes every product and sum below is exact. "+ 0.0" turns −0 into +0, so that equal
// coordinates have equal bits.
Point3 Frame::to_field(const Point3& p) const {
  const double x = p.x - origin.x, y = p.y - origin.y, z = p.z - origin.z;
  const auto& r = rotation;
  return {r[0] * x + r[1] * y + r[2] * z + 0.0, r[3] * x + r[4] * y + r[5] * z + 0.0,
          r[6] * x + r[7] * y + r[8] * z + 0.0};
}

Point3 Frame::to_input(const Point3& p) const {
  const auto& r = rotation;
  return {(r[0] * p.x + r[3] * p.y + r[6] * p.z) + origin.x, (r[1] * p.x + r[4] * p.y + r[7] * p.z) + origin.y,
          (r[2] * p.x + r[5] * p.y + r[8] * p.z) + origin.z};
}

namespace {

/// Refuses coordinates that spread too far, or too little.
void check_spread(const Box3& box, const std::string& name_a, const std::string& name_b) {
  if (!(largest_side(box) <= max_extent))
    throw InputError(fmt::format("{} and {}: the coordinates spread over {}, the most is {}; drop the outliers (crop)",
                                 name_a, name_b, largest_side(box), max_extent));
  if (largest_side(box) > 0 && largest_side(box) < min_extent)
    throw InputError(fmt::format(
        "{} and {}: the coordinates spread over {} alone, the least is {}, below which areas and volumes are "
        "lost to rounding; write them in a smaller unit",
        name_a, name_b, largest_side(box), min_extent));
}

/// All but the box and the curve.
Frame frame_of(const Box3& box, const Point3& w) {
  Frame frame;
  frame.origin = {exact_origin(box.min.x, box.max.x), exact_origin(box.min.y, box.max.y),
                  exact_origin(box.min.z, box.max.z)};
  frame.rotation = frame_along(w);
  frame.axis_aligned = (w.x != 0) + (w.y != 0) + (w.z != 0) == 1;
  if (frame.axis_aligned)  // each coordinate is one of the input, moved exactly: those of the box are enough
    for (const Point3& corner : {frame.to_field(box.min), frame.to_field(box.max)}) frame.box.add(corner);
  return frame;
}

void set_curve(Frame& frame) {
  frame.curve = curve_box({{frame.box.min.x, frame.box.min.y}, {frame.box.max.x, frame.box.max.y}});
}

}  // namespace

Frame choose_frame(const CloudView& a, const CloudView& b, const Pose& pose_b, const ProjectOptions& options,
                   const Context& context) {
  context.check();
  const Pose identity;
  const Filter filter_a(a, identity, options), filter_b(b, pose_b, options);
  Box3 box;
  for (const Filter* filter : {&filter_a, &filter_b}) {
    const Box3 own = kept_box(*filter);
    if (own.empty()) require_points(filter->cloud(), count_dropped(*filter));
    box.add(own);
  }
  check_spread(box, cloud_name(a), cloud_name(b));
  context.check();
  Frame frame = frame_of(box, direction_of(filter_a, filter_b, box, options.direction));
  if (!frame.axis_aligned) {
    frame.box = field_box(filter_a, frame);
    frame.box.add(field_box(filter_b, frame));
  }
  set_curve(frame);
  return frame;
}

void ScanExtent::add(const ScanExtent& other) {
  cleaning.points += other.cleaning.points;
  cleaning.dropped_nonfinite += other.cleaning.dropped_nonfinite;
  cleaning.dropped_class += other.cleaning.dropped_class;
  cleaning.dropped_crop += other.cleaning.dropped_crop;
  kept.add(other.kept), finite.add(other.finite);
}

ScanExtent extent_of(const CloudView& cloud, const Pose& pose, const ProjectOptions& options) {
  const Filter filter(cloud, pose, options);
  return {count_dropped(filter), kept_box(filter),
          reduce_blocks<Box3>(
              filter.size(), default_block,
              [&](std::size_t begin, std::size_t end) {
                Box3 box;
                for (std::size_t i = begin; i < end; ++i)
                  if (is_finite(cloud.points[i])) box.add(filter.posed(i));
                return box;
              },
              [](Box3& total, const Box3& part) { total.add(part); })};
}

Frame choose_frame(const std::array<ScanExtent, 2>& extents, const std::array<std::string, 2>& names,
                   const Direction& direction) {
  Box3 box;
  for (std::size_t k = 0; k < 2; ++k) {
    if (extents[k].kept.empty()) {
      Cloud nothing;
      nothing.path = names[k];
      require_points(nothing, extents[k].cleaning);
    }
    box.add(extents[k].kept);
  }
  check_spread(box, names[0], names[1]);
  const auto refuse = [] {
    return UsageError("@direction: scans that are looked at block by block are seen along an axis: take x, y or z");
  };
  Point3 w{0, 0, 1};
  switch (direction.kind) {
    case Direction::Kind::axis_x:
      w = {1, 0, 0};
      break;
    case Direction::Kind::axis_y:
      w = {0, 1, 0};
      break;
    case Direction::Kind::axis_z:
      break;
    case Direction::Kind::vector:
      w = unit_vector(direction.vector);
      break;
    case Direction::Kind::fit:
      throw refuse();
  }
  Frame frame = frame_of(box, w);
  if (!frame.axis_aligned) throw refuse();
  set_curve(frame);
  return frame;
}

Array<Point3> points_in_frame(const CloudView& cloud, const Pose& pose, const Frame& frame,
                              const ProjectOptions& options) {
  const Filter filter(cloud, pose, options);
  return gather_blocks<Array<Point3>>(filter.size(), default_block, [&](std::size_t begin, std::size_t end) {
    Array<Point3> part;
    for (std::size_t i = begin; i < end; ++i) {
      const Point3 p = filter.posed(i);
      if (filter.fate(i, p) == Filter::Fate::kept) part.push_back(frame.to_field(p));
    }
    return part;
  });
}

}  // namespace isopach
