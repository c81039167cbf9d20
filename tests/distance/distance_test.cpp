// The page of `isopach distance`: laws that tie the distances together, closed forms, options, errors.
#include "isopach/distance/distance.hpp"

#include <gtest/gtest.h>

#include "isopach/compare/compare.hpp"
#include "tests/support/clouds.hpp"

namespace isopach {
namespace {

DistanceMeasures all_measures() { return {true, true, true, true, true, true, false}; }

DistanceOptions everything() {
  DistanceOptions o;
  o.measures = all_measures();
  return o;
}

Distances run(const Cloud& a, const Cloud& b, const DistanceOptions& o = everything(), int threads = 0) {
  Context context;
  context.threads = threads;
  return distance(a, b, std::nullopt, o, context);
}

const Array<double>& field(const std::vector<Attribute>& fields, const std::string& name) {
  for (const Attribute& f : fields)
    if (f.name == name) return f.values;
  throw std::runtime_error("no field " + name);
}

Cloud waves(std::size_t n, std::uint64_t seed, double lift) {
  return test::cloud_over(test::framed_square(n, seed),
                          [&](const Point2& p) { return 0.1 * std::sin(9 * p.x) * std::cos(7 * p.y) + lift; });
}

template <class F>
std::string message_of(F&& f) {
  try {
    f();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(Distance, PlanesApartByAKnownDistance) {
  // Two tilted planes, z = 0.75 x and 0.5 above it: 0.5 along z, 0.4 along the normal, off the rim of the other.
  const auto plane = [](double lift) { return [lift](const Point2& p) { return 0.75 * p.x + lift; }; };
  const Cloud a = test::cloud_over(test::framed_square(500, 1), plane(0));
  const Cloud b = test::cloud_over(test::framed_square(400, 2), plane(0.5));
  const Distances d = run(a, b);
  for (const auto* f : {&d.fields_a, &d.fields_b})
    for (std::size_t i = 0; i < field(*f, "c2s").size(); ++i) {
      EXPECT_NEAR(field(*f, "vertical")[i], 0.5, 1e-12);
      const double along = field(*f, "normal")[i];
      if (!std::isnan(along)) {
        EXPECT_NEAR(along, 0.4, 1e-12);
        EXPECT_NEAR(field(*f, "c2s")[i], 0.4, 1e-12);
      } else {
        EXPECT_GT(field(*f, "c2s")[i], 0.4 - 1e-12);  // the foot of the normal is off the surface
      }
    }
  EXPECT_EQ(d.vertical->a_to_b.count, a.points.size());
  EXPECT_NEAR(d.vertical->a_to_b.signed_mean, 0.5, 1e-12);
  EXPECT_NEAR(d.vertical->b_to_a.signed_std, 0, 1e-12);
  EXPECT_GT(d.normal->a_to_b.missing, 0u);
  EXPECT_GT(d.normal->a_to_b.count, a.points.size() / 2);
  // Farthest: the upper rim's corner from the end of the other, a slope's length of 0.3 beyond it.
  EXPECT_NEAR(d.hausdorff->b_to_a.upper, 0.5, d.options.tolerance);
  EXPECT_NEAR(d.surface->a_to_b.area, 1.25, 1e-12);
}

TEST(Distance, SurfaceFiguresOfAWedge) {
  // From z = x to z = 0 over a far larger square: the distance is x, over an area of sqrt(2).
  const Cloud a = test::cloud_over(test::framed_square(300, 1), [](const Point2& p) { return p.x; });
  Cloud b;
  b.points = {{-5, -5, 0}, {5, -5, 0}, {5, 5, 0}, {-5, 5, 0}};
  DistanceOptions o = everything();
  o.samples = 60;
  const Distances d = run(a, b, o);
  EXPECT_NEAR(d.surface->a_to_b.area, std::sqrt(2), 1e-12);
  EXPECT_NEAR(d.surface->a_to_b.mean, 0.5, 1e-9);  // the centroid rule is exact for what is linear
  EXPECT_NEAR(d.surface->a_to_b.rms, std::sqrt(1.0 / 3), 1e-4);
  EXPECT_NEAR(d.surface->a_to_b.max, 1, 0.05);
  EXPECT_LE(d.surface->a_to_b.max, d.hausdorff->a_to_b.upper);
  EXPECT_NEAR(d.hausdorff->a_to_b.lower, 1, d.options.tolerance);
  o.samples = 1;
  EXPECT_LT(run(a, b, o).surface->a_to_b.samples, d.surface->a_to_b.samples / 10);
}

TEST(Distance, LawsBetweenTheDistances) {
  const Cloud a = waves(700, 1, 0), b = waves(500, 2, 0.05);
  const Distances d = run(a, b);
  for (const auto* f : {&d.fields_a, &d.fields_b})
    for (std::size_t i = 0; i < field(*f, "c2s").size(); ++i) {
      const double c2s = field(*f, "c2s")[i];
      EXPECT_LE(c2s, field(*f, "c2c")[i] + 1e-14);  // the surface holds the points
      for (const char* name : {"vertical", "normal"})
        if (const double other = field(*f, name)[i]; !std::isnan(other)) {
          EXPECT_LE(c2s, std::fabs(other) + 1e-12);  // and nothing on it is closer than the closest
        }
    }
  EXPECT_LE(d.c2s->a_to_b.max, d.hausdorff->a_to_b.upper);
  EXPECT_LE(d.surface->a_to_b.max, d.hausdorff->a_to_b.upper);
  EXPECT_LE(d.c2s->a_to_b.mean, d.c2s->a_to_b.rms);
  EXPECT_LE(d.c2s->a_to_b.median, d.c2s->a_to_b.p95);
  EXPECT_LE(d.c2s->a_to_b.p95, d.c2s->a_to_b.max);
}

TEST(Distance, VerticalIsThatOfCompare) {
  const Cloud a = waves(700, 1, 0), b = waves(500, 2, 0.05);
  const Distances d = run(a, b);
  CompareOptions o;
  const Comparison c = compare(a, b, o, {});
  for (std::size_t i = 0; i < a.points.size(); ++i)
    EXPECT_NEAR(field(d.fields_a, "vertical")[i], c.fields_a.dz_signed[i], 1e-12);
  for (std::size_t i = 0; i < b.points.size(); ++i)
    EXPECT_NEAR(field(d.fields_b, "vertical")[i], c.fields_b.dz_signed[i], 1e-12);
}

/// A square without its middle, 20 by 20 nodes; z = 1.
Cloud ring(double z) {
  Cloud c;
  for (int x = 0; x < 20; ++x)
    for (int y = 0; y < 20; ++y)
      if (x < 5 || x > 14 || y < 5 || y > 14) c.points.push_back({x + 0.01 * (y % 3), y + 0.01 * (x % 2), z});
  return c;
}

TEST(Distance, NoSurfaceSpansAHole) {
  const Cloud a = ring(0);
  Cloud b;  // a point high over the middle of the hole, and three over the scan
  b.points = {{9.5, 9.5, 1}, {2, 2, 1}, {2, 16, 1}, {16, 2, 1}};
  DistanceOptions o = everything();
  o.measures.hausdorff = o.measures.surface = false;
  const Distances trim = run(a, b, o);
  EXPECT_TRUE(std::isnan(field(trim.fields_b, "vertical")[0]));
  EXPECT_TRUE(std::isnan(field(trim.fields_b, "normal")[0]));
  EXPECT_NEAR(field(trim.fields_b, "vertical")[1], 1, 1e-12);
  EXPECT_NEAR(field(trim.fields_b, "c2s")[0], std::hypot(1, 5.5), 0.05);  // to the rim of the hole
  EXPECT_NEAR(trim.trimmed_a, 11.0 * 11 / (19 * 19), 0.03);               // less its corners
  EXPECT_EQ(trim.trimmed_b, 0);
  o.border = BorderRule::hull;
  const Distances hull = run(a, b, o);
  EXPECT_NEAR(field(hull.fields_b, "c2s")[0], 1, 1e-12);
  EXPECT_NEAR(field(hull.fields_b, "vertical")[0], 1, 1e-12);
  EXPECT_EQ(hull.trimmed_a, 0);
  EXPECT_GT(hull.faces_a, trim.faces_a);
  o.max_edge = 3;  // the hole again, and all of b
  EXPECT_THROW((void)run(a, b, o), InputError);
  o.max_edge = 20;
  EXPECT_EQ(run(a, b, o).faces_a, hull.faces_a);
  // Of A the same cells as in a comparison: by area and by height.
  const Cloud above = ring(2);
  DistanceOptions all = everything();
  const Distances d = run(a, above, all);
  EXPECT_NEAR(d.surface->a_to_b.area, compare(a, above, {}, {}).domain_area, 1e-9);
}

TEST(Distance, SwapMirrors) {
  const Cloud a = waves(300, 1, 0), b = waves(200, 2, 0.05);
  const Distances ab = run(a, b), ba = run(b, a);
  EXPECT_EQ(ab.c2c->a_to_b.mean, ba.c2c->b_to_a.mean);
  EXPECT_EQ(ab.c2s->a_to_b.rms, ba.c2s->b_to_a.rms);
  EXPECT_EQ(ab.normal->a_to_b.signed_mean, -ba.normal->b_to_a.signed_mean);
  EXPECT_EQ(ab.vertical->b_to_a.signed_mean, -ba.vertical->a_to_b.signed_mean);
  EXPECT_EQ(ab.hausdorff->a_to_b.upper, ba.hausdorff->b_to_a.upper);
}

TEST(Distance, SameBitsForAnyThreadsAndOrder) {
  const Cloud a = waves(3000, 1, 0), b = waves(2000, 2, 0.05);
  const Distances first = run(a, b, everything(), 1);
  for (const Distances& d : {run(a, b, everything(), 3), run(test::shuffled(a, 5), test::shuffled(b, 6))}) {
    EXPECT_EQ(d.c2c->a_to_b.mean, first.c2c->a_to_b.mean);
    EXPECT_EQ(d.c2s->b_to_a.rms, first.c2s->b_to_a.rms);
    EXPECT_EQ(d.normal->a_to_b.signed_std, first.normal->a_to_b.signed_std);
    EXPECT_EQ(d.vertical->a_to_b.signed_mean, first.vertical->a_to_b.signed_mean);
    EXPECT_EQ(d.surface->a_to_b.rms, first.surface->a_to_b.rms);
    EXPECT_EQ(d.hausdorff->a_to_b.upper, first.hausdorff->a_to_b.upper);
    EXPECT_EQ(d.hausdorff->a_to_b.at, first.hausdorff->a_to_b.at);
  }
}

TEST(Distance, FarFromTheOriginAndTurned) {
  const Cloud a = waves(400, 1, 0), b = waves(300, 2, 0.05);
  const Distances here = run(a, b);
  const Distances there = run(test::shifted(a, {524288, 5242880, 1024}), test::shifted(b, {524288, 5242880, 1024}));
  EXPECT_NEAR(there.c2s->a_to_b.mean, here.c2s->a_to_b.mean, 1e-9);
  EXPECT_NEAR(there.hausdorff->a_to_b.lower, here.hausdorff->a_to_b.lower, 1e-5);
  const auto turned = [](Cloud cloud) {
    for (Point3& p : cloud.points) p = {p.z, p.x, p.y};
    return cloud;
  };
  DistanceOptions o = everything();
  o.project.direction = {Direction::Kind::axis_x, {1, 0, 0}};
  const Distances x = run(turned(a), turned(b), o);
  EXPECT_NEAR(x.vertical->a_to_b.signed_mean, here.vertical->a_to_b.signed_mean, 1e-12);
  EXPECT_NEAR(x.c2s->b_to_a.mean, here.c2s->b_to_a.mean, 1e-12);
}

Cloud cube(double half) {
  Cloud c;
  for (int i = 0; i < 8; ++i)
    c.points.push_back({(i & 1) != 0 ? half : -half, (i & 2) != 0 ? half : -half, (i & 4) != 0 ? half : -half});
  c.faces = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
             {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return c;
}

TEST(Distance, OwnFacesAreTheSurface) {
  const Distances d = run(cube(1), cube(1.25));
  EXPECT_TRUE(d.own_faces_a);
  EXPECT_EQ(d.faces_a, 12u);
  EXPECT_DOUBLE_EQ(d.surface->a_to_b.area, 24);
  EXPECT_NEAR(d.surface->a_to_b.mean, 0.25, 1e-12);
  EXPECT_NEAR(d.surface->a_to_b.max, 0.25, 1e-12);
  EXPECT_NEAR(d.c2s->a_to_b.mean, 0.25, 1e-12);
  EXPECT_NEAR(d.c2c->a_to_b.mean, 0.25 * std::sqrt(3), 1e-12);
  EXPECT_NEAR(d.hausdorff->a_to_b.upper, 0.25, d.options.tolerance);
  EXPECT_NEAR(d.hausdorff->b_to_a.lower, 0.25 * std::sqrt(3), d.options.tolerance);  // from corner to corner
  DistanceOptions o = everything();
  o.mesh = MeshSource::delaunay;
  o.project.duplicates = DuplicatePolicy::max;
  const Distances flat = run(cube(1), cube(1.25), o);  // their lids
  EXPECT_FALSE(flat.own_faces_a);
  EXPECT_EQ(flat.faces_a, 2u);
  o.project.duplicates = DuplicatePolicy::min;
  EXPECT_NEAR(run(cube(1), cube(1.25), o).vertical->a_to_b.max, 2.25, 1e-12);  // bottom, seen from the lid
}

TEST(Distance, DroppedPointsHaveNoDistanceAndTakeTheirFacesAlong) {
  Cloud a = waves(300, 1, 0), b = waves(200, 2, 0.05);
  a.points[7].z = std::numeric_limits<double>::quiet_NaN();
  DistanceOptions o = everything();
  Box2 box;
  box.min = {0, 0}, box.max = {0.5, 1};
  o.project.crop = box;
  const Distances d = run(a, b, o);
  EXPECT_EQ(field(d.fields_a, "c2c").size(), a.points.size());
  EXPECT_TRUE(std::isnan(field(d.fields_a, "c2c")[7]));
  for (std::size_t i = 0; i < a.points.size(); ++i)
    if (i != 7) {
      EXPECT_EQ(std::isnan(field(d.fields_a, "c2s")[i]), a.points[i].x > 0.5);
    }
  EXPECT_EQ(d.c2c->a_to_b.count, d.points_a);
  EXPECT_EQ(d.c2c->a_to_b.missing, 0u);
  Cloud mesh = cube(1);
  box.min = {-2, -2}, box.max = {2, 0};
  o.project.crop = box;
  EXPECT_EQ(run(mesh, mesh, o).faces_a, 2u);
}

TEST(Distance, PoseMovesB) {
  const Cloud a = waves(300, 1, 0);
  DistanceOptions o = everything();
  o.pose.m = {1, 0, 0, -64, 0, 1, 0, 32, 0, 0, 1, -2, 0, 0, 0, 1};
  const Distances d = run(a, test::shifted(a, {64, -32, 2}), o);
  EXPECT_LT(d.c2c->a_to_b.max, 1e-12);
  EXPECT_LT(d.hausdorff->b_to_a.upper, d.options.tolerance);
}

TEST(Distance, M3c2AtThePointsOfAOrAtCores) {
  const Cloud a = waves(2000, 1, 0), b = waves(2000, 2, 0.05);
  DistanceOptions o;
  o.measures.m3c2 = true;
  o.m3c2 = {0.1, 0.1, 0.3, 0};
  const Distances d = run(a, b, o);
  EXPECT_EQ(d.m3c2->cores.size(), a.points.size());
  EXPECT_GT(d.m3c2->significant, d.m3c2->measured / 2);
  EXPECT_NEAR(d.m3c2->figures.signed_mean, 0.05 * 0.85, 0.01);
  EXPECT_FALSE(d.c2c.has_value());
  EXPECT_EQ(d.faces_a, 0u);  // no surface is made for it
  Cloud cores;
  cores.points = {{0.5, 0.5, 0.09}};  // on the surface
  const Distances one = distance(a, b, cores, o, {});
  EXPECT_EQ(one.m3c2->cores.size(), 1u);
  EXPECT_EQ(one.m3c2->measured, 1u);
  // Normals are of the input, whatever direction is up.
  const auto turned = [](Cloud cloud) {
    for (Point3& p : cloud.points) p = {p.z, p.x, p.y};
    return cloud;
  };
  o.project.direction = {Direction::Kind::axis_x, {1, 0, 0}};
  const Distances x = run(turned(a), turned(b), o);
  for (std::size_t i = 0; i < a.points.size(); i += 50) {
    EXPECT_NEAR(x.m3c2->field.normal[i].x, d.m3c2->field.normal[i].z, 1e-9);
    EXPECT_NEAR(x.m3c2->field.normal[i].y, d.m3c2->field.normal[i].x, 1e-9);
  }
}

TEST(Distance, ErrorsNameTheOption) {
  const Cloud a = waves(100, 1, 0), b = waves(100, 2, 0);
  const auto with = [&](auto change) {
    DistanceOptions o = everything();
    o.measures.m3c2 = true;
    o.m3c2 = {0.3, 0.3, 0.3, 0};
    change(o);
    return message_of([&] { static_cast<void>(run(a, b, o)); });
  };
  EXPECT_EQ(with([](DistanceOptions&) {}), "");
  EXPECT_EQ(with([](DistanceOptions& o) { o.m3c2.normal_scale = 0; }).find("@normal-scale"), 0u);
  EXPECT_EQ(with([](DistanceOptions& o) { o.m3c2.projection_scale = -1; }).find("@projection-scale"), 0u);
  EXPECT_EQ(with([](DistanceOptions& o) { o.m3c2.max_depth = NAN; }).find("@max-depth"), 0u);
  EXPECT_EQ(with([](DistanceOptions& o) { o.m3c2.registration_error = -1; }).find("@registration-error"), 0u);
  EXPECT_EQ(with([](DistanceOptions& o) { o.tolerance = -1; }).find("@tolerance"), 0u);
  EXPECT_EQ(with([](DistanceOptions& o) { o.tolerance = 1e-300; }).find("@tolerance"), 0u);
  EXPECT_EQ(with([](DistanceOptions& o) { o.samples = 0; }).find("@samples"), 0u);
  EXPECT_NE(with([](DistanceOptions& o) { o.mesh = MeshSource::faces; }).find("@mesh faces"), std::string::npos);
}

TEST(Distance, SurfacesNeedMoreThanALine) {
  Cloud line = test::cloud_over(test::diagonal(50, 1), [](const Point2& p) { return p.x; });
  const std::string message = message_of([&] { static_cast<void>(run(line, line)); });
  EXPECT_NE(message.find("@measure c2c"), std::string::npos);
  DistanceOptions o;
  o.measures.c2c = true;
  EXPECT_EQ(run(line, line, o).c2c->a_to_b.max, 0);
}

TEST(Distance, UnitsThatDoNotFitAreRefused) {
  Cloud a = waves(100, 1, 0), b = a;
  a.unit = b.unit = "m";
  a.vertical_unit = b.vertical_unit = "us-ft";
  DistanceOptions o = everything();
  EXPECT_NE(message_of([&] { static_cast<void>(run(a, b, o)); }).find("@allow-crs"), std::string::npos);
  o.allow_crs = true;
  const Distances d = run(a, b, o);
  EXPECT_EQ(d.unit, "unknown");
  EXPECT_EQ(d.warnings.size(), 2u);
  o.unit = "ft";
  EXPECT_EQ(run(a, b, o).unit, "ft");
  a.unit = b.unit = "deg";
  o = everything();
  EXPECT_NE(message_of([&] { static_cast<void>(run(a, b, o)); }), "");
}

}  // namespace
}  // namespace isopach
