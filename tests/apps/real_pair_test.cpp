// A real pair with truth: two expressions of one face whose vertices correspond one by one, so that the motion of every
// vertex is known. The truth along the view: the triangles of the first scan, moved with their vertices, make a second
// surface that knows nothing of the method; its height over a vertex of the first, less that of the vertex, is the
// displacement there. It is single-valued where one moved triangle alone lies over the vertex, and neither that
// triangle nor those around the vertex join different parts of the face (edges of many times the usual length in
// space).
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <limits>
#include <map>

#include "isopach/apps/accuracy.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/io/read.hpp"
#include "tests/support/shared_data.hpp"

namespace isopach {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

double length(const Point3& p, const Point3& q) { return std::hypot(p.x - q.x, p.y - q.y, p.z - q.z); }

using Corners = std::array<Index, 3>;

/// Triangles of vertices by their number in the cloud: Delaunay in the plane of the view.
std::vector<Corners> triangles_of(const Cloud& cloud) {
  const Frame frame = choose_frame(cloud, cloud, {}, {}, {});
  const HeightField f = project(cloud, {}, frame, {}, {});
  std::vector<Index> point_of(f.xy.size());
  for (std::size_t i = 0; i < cloud.points.size(); ++i) point_of[f.node_of_point[i]] = static_cast<Index>(i);
  const Triangulation t = triangulate(f.xy, frame.curve, {});
  std::vector<Corners> all;
  for (std::size_t i = 0; i < t.real; ++i) {
    const auto& v = t.triangles[i].v;
    all.push_back({point_of[v[0]], point_of[v[1]], point_of[v[2]]});
  }
  return all;
}

double cross(const Point3& a, const Point3& b, double x, double y) {
  return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

/// By vertex of `before`: the displacement along z; NaN where it is not single-valued.
std::vector<double> true_displacement(const Cloud& before, const Cloud& after) {
  const std::vector<Corners> triangles = triangles_of(before);
  std::vector<double> longest(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      for (const Cloud* c : {&before, &after})
        longest[i] = std::max(longest[i], length(c->points[triangles[i][k]], c->points[triangles[i][(k + 1) % 3]]));
  std::vector<double> sorted = longest;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
  const double limit = 3 * sorted[sorted.size() / 2], side = limit;

  std::map<std::pair<long, long>, std::vector<std::size_t>> squares;  // moved triangles by the squares they touch
  const auto square = [&](double v) { return std::lround(std::floor(v / side)); };
  std::vector<bool> whole(before.points.size(), true);
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const auto& [a, b, c] = triangles[i];
    const Point3 &p = after.points[a], &q = after.points[b], &r = after.points[c];
    if (longest[i] > limit)
      for (const Index v : triangles[i]) whole[v] = false;
    for (long x = square(std::min({p.x, q.x, r.x})); x <= square(std::max({p.x, q.x, r.x})); ++x)
      for (long y = square(std::min({p.y, q.y, r.y})); y <= square(std::max({p.y, q.y, r.y})); ++y)
        squares[{x, y}].push_back(i);
  }

  std::vector<double> truth(before.points.size(), nan);
  for (std::size_t v = 0; v < truth.size(); ++v) {
    const Point3& at = before.points[v];
    const auto found = squares.find({square(at.x), square(at.y)});
    if (!whole[v] || found == squares.end()) continue;
    int over = 0;
    double height = nan;
    for (const std::size_t i : found->second) {
      const auto& [a, b, c] = triangles[i];
      const Point3 &p = after.points[a], &q = after.points[b], &r = after.points[c];
      const double wr = cross(p, q, at.x, at.y), wp = cross(q, r, at.x, at.y), wq = cross(r, p, at.x, at.y);
      const bool inside = (wp >= 0 && wq >= 0 && wr >= 0) || (wp <= 0 && wq <= 0 && wr <= 0);
      if (!inside) continue;
      ++over;
      const double area = wp + wq + wr;
      height = longest[i] <= limit && area > 0 ? (wp * p.z + wq * q.z + wr * r.z) / area : nan;
    }
    if (over == 1) truth[v] = height - at.z;
  }
  return truth;
}

/// Only where it is single-valued at all neighbours, too.
std::vector<double> around(const std::vector<double>& truth, const Cloud& before) {
  std::vector<double> rest = truth;
  for (const Corners& c : triangles_of(before))
    if (!std::isfinite(truth[c[0]]) || !std::isfinite(truth[c[1]]) || !std::isfinite(truth[c[2]]))
      for (const Index v : c) rest[v] = nan;
  return rest;
}

/// Every second vertex, from `first` on.
Cloud half(const Cloud& cloud, std::size_t first) {
  Cloud part;
  part.path = cloud.path, part.format = cloud.format, part.unit = cloud.unit, part.vertical_unit = cloud.vertical_unit;
  for (std::size_t i = first; i < cloud.points.size(); i += 2) part.points.push_back(cloud.points[i]);
  return part;
}

struct Agreement {
  std::size_t vertices = 0;
  double rms = 0, displacement = 0;
  double p95 = 0;
};

/// `step`: vertices of the reference between those that it holds.
Agreement agreement(const Array<double>& found, const std::vector<double>& truth, std::size_t step) {
  Sum off, all;
  std::vector<double> errors;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double t = truth[i * step];
    if (!std::isfinite(t) || !std::isfinite(found[i])) continue;
    errors.push_back(std::fabs(found[i] - t));
    off.add((found[i] - t) * (found[i] - t)), all.add(t * t);
  }
  std::sort(errors.begin(), errors.end());
  const auto n = static_cast<double>(errors.size());
  return {errors.size(), std::sqrt(off.value() / n), std::sqrt(all.value() / n), errors[errors.size() * 95 / 100]};
}

Array<double> displacement_at_reference(const Cloud& reconstruction, const Cloud& reference) {
  AccuracyOptions options;
  options.align = Align::none;
  return accuracy(reconstruction, reference, options, {}).comparison.fields_a.dz_signed;
}

TEST(RealPair, DisplacementAlongTheViewIsThatOfTheVertices) {
  ISOPACH_SHARED_OR_SKIP(before_path, "probreg/face-x.txt");
  ISOPACH_SHARED_OR_SKIP(after_path, "probreg/face-y.txt");
  const Cloud before = read_cloud(before_path.string(), {}, {}), after = read_cloud(after_path.string(), {}, {});
  ASSERT_EQ(before.points.size(), after.points.size());
  const std::vector<double> truth = true_displacement(before, after);
  const std::vector<double> inner = around(truth, before);
  const Array<double> all = displacement_at_reference(after, before);
  // No vertex is in both: the even ones of the first scan, the odd ones of the second.
  const Array<double> apart = displacement_at_reference(half(after, 1), half(before, 0));
  const auto told = [&](const char* what, const Agreement& a) {
    std::cout << what << ": " << a.vertices << " of " << before.points.size() << " vertices, displacement RMS "
              << a.displacement << ", off by RMS " << a.rms << ", 95 % within " << a.p95 << "\n";
    return a;
  };
  const Agreement at = told("all vertices, single-valued there", agreement(all, truth, 1));
  EXPECT_GT(at.vertices, before.points.size() * 7 / 10);
  EXPECT_LT(at.rms, 0.2);
  EXPECT_LT(at.p95, 0.05);
  const Agreement near = told("all vertices, single-valued around them", agreement(all, inner, 1));
  EXPECT_GT(near.vertices, before.points.size() * 6 / 10);
  EXPECT_LT(near.rms, 0.1);
  EXPECT_LT(told("no vertex in both, single-valued there", agreement(apart, truth, 2)).rms, 0.6);
  EXPECT_LT(told("no vertex in both, single-valued around them", agreement(apart, inner, 2)).rms, 0.3);
}

}  // namespace
}  // namespace isopach
