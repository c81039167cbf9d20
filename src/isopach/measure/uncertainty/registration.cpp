#include "isopach/measure/uncertainty/registration.hpp"

#include <algorithm>
#include <cmath>

#include "isopach/base/linear.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/measure/uncertainty/detection.hpp"

namespace isopach {

namespace {

constexpr std::size_t block = 1 << 13;

// A triangle of B with what d is at its corners.
struct Facet {
  std::array<Point3, 3> p;
  std::array<double, 3> d;
};

Point2 slope_of(const std::array<Point3, 3>& p, double area) {
  const double x1 = p[1].x - p[0].x, y1 = p[1].y - p[0].y, z1 = p[1].z - p[0].z;
  const double x2 = p[2].x - p[0].x, y2 = p[2].y - p[0].y, z2 = p[2].z - p[0].z;
  return {(z1 * y2 - z2 * y1) / (2 * area), (x1 * z2 - x2 * z1) / (2 * area)};
}

struct MotionSums {
  std::array<std::array<Sum, 6>, 3> of;  // net, above, below

  void add(const Facet& f, const Point3& centre) {
    const double area = triangle_area({f.p[0].x, f.p[0].y}, {f.p[1].x, f.p[1].y}, {f.p[2].x, f.p[2].y});
    if (!(area > 0)) return;
    const Point2 slope = slope_of(f.p, area);
    const auto above = positive_shares(f.d), below = positive_shares({-f.d[0], -f.d[1], -f.d[2]});
    for (std::size_t k = 0; k < 3; ++k) {
      const MotionGradient g = motion_gradient(f.p[k], slope, centre);
      for (std::size_t i = 0; i < 6; ++i) {
        of[0][i].add(area / 3 * g[i]);
        of[1][i].add(area * above[k] * g[i]);
        of[2][i].add(area * below[k] * g[i]);
      }
    }
  }
  void add(const MotionSums& other) {
    for (std::size_t part = 0; part < 3; ++part)
      for (std::size_t i = 0; i < 6; ++i) of[part][i].add(other.of[part][i]);
  }
  [[nodiscard]] VolumeMotions value() const {
    VolumeMotions v;
    for (std::size_t i = 0; i < 6; ++i)
      v.net[i] = of[0][i].value(), v.above[i] = of[1][i].value(), v.below[i] = of[2][i].value();
    return v;
  }
};

void add_cell(const OverlayCell& c, const Point3& centre, MotionSums& part) {
  const Point3 at_origin{centre.x - c.origin.x, centre.y - c.origin.y, centre.z};
  for (unsigned k = 2; k < c.corners; ++k) {
    const std::array<unsigned, 3> fan{0, k - 1, k};
    Facet f;
    for (std::size_t i = 0; i < 3; ++i) {
      f.p[i] = {c.x[fan[i]], c.y[fan[i]], c.z2[fan[i]]};
      f.d[i] = c.d(fan[i]);
    }
    part.add(f, at_origin);
  }
}

template <class Add>
VolumeMotions sum_over(std::size_t items, const Context& context, const Add& add) {
  context.check();
  return reduce_blocks<MotionSums>(
             items, block,
             [&](std::size_t begin, std::size_t end) {
               MotionSums part;
               add(begin, end, part);
               return part;
             },
             [](MotionSums& total, const MotionSums& part) { total.add(part); })
      .value();
}

}  // namespace

std::string fault_of(const PoseCovariance& covariance) {
  const auto& c = covariance.matrix;
  const Point3& o = covariance.centre;
  if (!std::all_of(c.begin(), c.end(), [](double v) { return std::isfinite(v); }) || !is_finite(o))
    return "it holds numbers that are not finite";
  // Turns and shifts have units of their own: each is judged in its own deviations.
  Eigen::Matrix<double, 6, 6> m;
  constexpr double rounding = 1e-9;
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j) {
      if (c[7 * i] < 0) return "a variance on its diagonal is negative";
      const double scale = std::sqrt(c[7 * i]) * std::sqrt(c[7 * j]);
      if (std::fabs(c[6 * i + j] - c[6 * j + i]) > rounding * scale) return "it is not symmetric";
      m(static_cast<int>(i), static_cast<int>(j)) = scale > 0 ? c[6 * i + j] / scale : 0;
      if (scale == 0 && c[6 * i + j] != 0) return "a number whose variance is 0 varies with another one";
    }
  return eigenvalues(m)(0) < -rounding ? "it has a negative variance along some motion" : "";
}

PoseCovariance in_frame(const PoseCovariance& covariance, const Frame& frame) {
  const auto& r = frame.rotation;
  const auto turned = [&](std::size_t i, std::size_t j) {  // R C Rᵀ in each 3×3 block
    const std::size_t row = i / 3 * 3, column = j / 3 * 3;
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t l = 0; l < 3; ++l)
        sum += r[3 * (i % 3) + k] * r[3 * (j % 3) + l] * covariance.matrix[6 * (row + k) + column + l];
    return sum;
  };
  PoseCovariance result;
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j) result.matrix[6 * i + j] = turned(i, j);
  result.centre = frame.to_field(covariance.centre);
  return result;
}

MotionGradient motion_gradient(const Point3& p, const Point2& slope, const Point3& centre) {
  const Point3 r{p.x - centre.x, p.y - centre.y, p.z - centre.z};
  const Point3 n{-slope.x, -slope.y, 1};
  return {r.y * n.z - r.z * n.y, r.z * n.x - r.x * n.z, r.x * n.y - r.y * n.x, n.x, n.y, n.z};
}

double variance(const MotionGradient& g, const PoseCovariance& covariance) {
  double sum = 0;
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j) sum += g[i] * covariance.matrix[6 * i + j] * g[j];
  return std::max(0.0, sum);
}

VolumeMotions volume_motions(const CellView& cells, const Point3& centre, const Context& context) {
  const std::vector<std::size_t> order = items_in_order(cells);
  return sum_over(order.size(), context, [&](std::size_t begin, std::size_t end, MotionSums& part) {
    for (std::size_t i = begin; i < end; ++i) {
      const CommonCell c = of_item(cells, order[i]);
      Facet f;
      for (std::size_t k = 0; k < 3; ++k) {
        const Corner corner = c.corner(k);
        f.p[k] = {corner.x, corner.y, corner.z2};
        f.d[k] = corner.d();
      }
      part.add(f, centre);
    }
  });
}

VolumeMotions volume_motions(const OverlayCells& cells, const Point3& centre, const Context& context) {
  return sum_over(items_of(cells), context, [&](std::size_t begin, std::size_t end, MotionSums& part) {
    for_overlay(cells, begin, end, [&](const OverlayCell& c, std::size_t) { add_cell(c, centre, part); });
  });
}

Array<double> height_deviations(const OverlayMesh& b, const PoseCovariance& covariance, const Context& context) {
  context.check();
  struct Rise {
    double area = 0, x = 0, y = 0;
  };
  std::vector<Rise> round(b.xy.size());
  for (std::size_t t = 0; t < b.t.real; ++t) {
    if (!b.kept.empty() && b.kept[t] == 0) continue;
    const std::array<Index, 3> v = from_first_corner(b.t.triangles[t].v);
    std::array<Point3, 3> p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = {b.xy[v[k]].x, b.xy[v[k]].y, b.z[v[k]]};
    const double area = triangle_area(b.xy[v[0]], b.xy[v[1]], b.xy[v[2]]);
    if (!(area > 0)) continue;
    const Point2 slope = slope_of(p, area);
    for (const Index node : v) {
      round[node].area += area;
      round[node].x += area * slope.x;
      round[node].y += area * slope.y;
    }
  }
  Array<double> result(b.xy.size());
  for_each_index(result.size(), [&](std::size_t i) {
    const Rise& r = round[i];
    const Point2 slope = r.area > 0 ? Point2{r.x / r.area, r.y / r.area} : Point2{0, 0};
    result[i] =
        std::sqrt(variance(motion_gradient({b.xy[i].x, b.xy[i].y, b.z[i]}, slope, covariance.centre), covariance));
  });
  return result;
}

}  // namespace isopach
