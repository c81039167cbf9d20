// choose_frame: directions, handedness, exact origin, symmetry in the two clouds, independence of order and threads.
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/field/height_field.hpp"
#include "tests/field/clouds.hpp"

namespace isopach::test {
namespace {

Frame frame_of(const Cloud& a, const Cloud& b, const ProjectOptions& options = {}) {
  return choose_frame(a, b, Pose{}, options, Context{});
}

ProjectOptions looking(Direction::Kind kind, Point3 vector = {0, 0, 1}) {
  ProjectOptions options;
  options.direction = {kind, vector};
  return options;
}

double determinant(const std::array<double, 9>& r) {
  return r[0] * (r[4] * r[8] - r[5] * r[7]) - r[1] * (r[3] * r[8] - r[5] * r[6]) + r[2] * (r[3] * r[7] - r[4] * r[6]);
}

void expect_rotation(const std::array<double, 9>& r) {
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      EXPECT_NEAR(r[3 * i] * r[3 * j] + r[3 * i + 1] * r[3 * j + 1] + r[3 * i + 2] * r[3 * j + 2], i == j, 1e-15);
  EXPECT_NEAR(determinant(r), 1, 2e-15);
}

// a − b has no rounding error (Knuth's two-sum).
bool exact_difference(double a, double b) {
  const double d = a - b, b_part = a - d, a_part = d + b_part;
  return (b_part - b) + (a - a_part) == 0;
}

// Two points at each of the places of the tilted plane n · p = c, on both sides of it, so that n is exactly its normal.
Cloud tilted_plane(const Point3& n, const Point3& e, const Point3& f, std::uint64_t seed) {
  FieldRandom random(seed);
  Cloud cloud = make_cloud({});
  for (int i = 0; i < 3000; ++i) {
    const double s = random.uniform(-5, 5), t = random.uniform(-3, 3), h = 0.01 * random.normal();
    cloud.points.push_back(
        {100 + s * e.x + t * f.x + h * n.x, 200 + s * e.y + t * f.y + h * n.y, 50 + s * e.z + t * f.z + h * n.z});
  }
  return cloud;
}

TEST(Frame, axes_are_right_handed_cyclic_permutations) {
  const Cloud a = smooth_cloud(100, 1);
  const std::array<double, 9> x{0, 1, 0, 0, 0, 1, 1, 0, 0}, y{0, 0, 1, 1, 0, 0, 0, 1, 0}, z{1, 0, 0, 0, 1, 0, 0, 0, 1};
  EXPECT_EQ(frame_of(a, a, looking(Direction::Kind::axis_x)).rotation, x);
  EXPECT_EQ(frame_of(a, a, looking(Direction::Kind::axis_y)).rotation, y);
  EXPECT_EQ(frame_of(a, a, looking(Direction::Kind::axis_z)).rotation, z);
  EXPECT_EQ(frame_of(a, a, looking(Direction::Kind::vector, {7, 0, 0})).rotation, x);
  EXPECT_EQ(frame_of(a, a, looking(Direction::Kind::vector, {0, 1e-300, 0})).rotation, y);
  EXPECT_EQ(frame_of(a, a, looking(Direction::Kind::vector, {0, -0.0, 1e300})).rotation, z);
}

TEST(Frame, negative_axes_are_signed_permutations) {
  const Cloud a = smooth_cloud(100, 1);
  for (const Point3& v : {Point3{-1, 0, 0}, Point3{0, -1, 0}, Point3{0, 0, -1}}) {
    const Frame frame = frame_of(a, a, looking(Direction::Kind::vector, v));
    EXPECT_TRUE(frame.axis_aligned);
    EXPECT_EQ((Point3{frame.rotation[6], frame.rotation[7], frame.rotation[8]}), v);
    EXPECT_EQ(determinant(frame.rotation), 1);
    for (const double c : frame.rotation) EXPECT_TRUE(c == 0 || std::fabs(c) == 1);
  }
}

TEST(Frame, any_vector_gives_a_rotation_with_it_as_last_row) {
  const Cloud a = smooth_cloud(10, 1);
  FieldRandom random(5);
  for (int i = 0; i < 300; ++i) {
    const Point3 v{random.normal(), random.normal(), random.normal()};
    const Frame frame = frame_of(a, a, looking(Direction::Kind::vector, v));
    expect_rotation(frame.rotation);
    EXPECT_FALSE(frame.axis_aligned);
    const double length = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
    EXPECT_NEAR(frame.rotation[6], v.x / length, 1e-15);
    EXPECT_NEAR(frame.rotation[7], v.y / length, 1e-15);
    EXPECT_NEAR(frame.rotation[8], v.z / length, 1e-15);
  }
}

TEST(Frame, zero_or_infinite_vector_is_refused) {
  const Cloud a = smooth_cloud(10, 1);
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_THROW((void)frame_of(a, a, looking(Direction::Kind::vector, {0, 0, 0})), UsageError);
  EXPECT_THROW((void)frame_of(a, a, looking(Direction::Kind::vector, {0, inf, 0})), UsageError);
  EXPECT_THROW((void)frame_of(a, a, looking(Direction::Kind::vector, {NAN, 0, 1})), UsageError);
}

TEST(Frame, fit_finds_the_normal_of_known_planes) {
  const double c = std::cos(0.5), s = std::sin(0.5);
  struct Case {
    Point3 n, e, f;
  };
  for (const Case& known : {Case{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}}, Case{{s, 0, c}, {c, 0, -s}, {0, 1, 0}},
                            Case{{0, s, c}, {1, 0, 0}, {0, c, -s}}, Case{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                            Case{{0, -c, s}, {1, 0, 0}, {0, s, c}}}) {
    const Cloud a = tilted_plane(known.n, known.e, known.f, 3), b = tilted_plane(known.n, known.e, known.f, 4);
    const Frame frame = frame_of(a, b, looking(Direction::Kind::fit));
    expect_rotation(frame.rotation);
    EXPECT_NEAR(frame.rotation[6], known.n.x, 2e-4);
    EXPECT_NEAR(frame.rotation[7], known.n.y, 2e-4);
    EXPECT_NEAR(frame.rotation[8], known.n.z, 2e-4);
  }
}

TEST(Frame, fit_of_an_exact_plane_is_exact_to_rounding) {
  Cloud a = make_cloud({});
  for (int i = 0; i < 20; ++i)
    for (int j = 0; j < 30; ++j) a.points.push_back({500000.0 + i, 4.0e6 + j, 100 + 0.5 * i - 0.25 * j});
  const Frame frame = frame_of(a, a, looking(Direction::Kind::fit));
  const double length = std::sqrt(1 + 0.25 + 0.0625);
  EXPECT_NEAR(frame.rotation[6], -0.5 / length, 1e-11);
  EXPECT_NEAR(frame.rotation[7], 0.25 / length, 1e-11);
  EXPECT_NEAR(frame.rotation[8], 1 / length, 1e-11);
}

TEST(Frame, fit_of_a_plane_across_an_axis_is_the_axis) {
  FieldRandom random(3);
  Cloud x = make_cloud({}), y = make_cloud({}), z = make_cloud({});
  for (int i = 0; i < 300; ++i) {
    const double s = random.uniform(-7, 3), t = random.uniform(5, 30), level = 12.7;
    x.points.push_back({level, s, t});
    y.points.push_back({t, level, s});
    z.points.push_back({s, t, level});
  }
  EXPECT_EQ(frame_of(x, x, looking(Direction::Kind::fit)).rotation,
            frame_of(x, x, looking(Direction::Kind::axis_x)).rotation);
  EXPECT_EQ(frame_of(y, y, looking(Direction::Kind::fit)).rotation,
            frame_of(y, y, looking(Direction::Kind::axis_y)).rotation);
  EXPECT_EQ(frame_of(z, z, looking(Direction::Kind::fit)).rotation, Frame{}.rotation);
  EXPECT_TRUE(frame_of(x, x, looking(Direction::Kind::fit)).axis_aligned);
}

TEST(Frame, fit_refuses_points_on_a_line) {
  Cloud line = make_cloud({});
  for (int i = 0; i < 50; ++i) line.points.push_back({i / 3.0, i / 7.0, -i / 11.0});
  EXPECT_THROW((void)frame_of(line, line, looking(Direction::Kind::fit)), InputError);
  const Cloud point = make_cloud({{1, 2, 3}, {1, 2, 3}});
  EXPECT_THROW((void)frame_of(point, point, looking(Direction::Kind::fit)), InputError);
}

TEST(Frame, fit_uses_the_kept_points_only) {
  Cloud a = smooth_cloud(500, 1);
  for (Point3& p : a.points) p.z = 3;
  for (int i = 0; i < 500; ++i) a.points.push_back({100.0 + i, 0, 10.0 * i});
  ProjectOptions options = looking(Direction::Kind::fit);
  EXPECT_FALSE(frame_of(a, a, options).axis_aligned);
  options.crop = Box2{{0, 0}, {10, 10}};
  EXPECT_TRUE(frame_of(a, a, options).axis_aligned);
}

TEST(Frame, symmetric_and_independent_of_order_and_threads) {
  Cloud a = smooth_cloud(20000, 1, 10, {3e5, 4e6, 1000}), b = smooth_cloud(15000, 2, 12, {3e5, 4e6, 1001});
  for (const auto kind : {Direction::Kind::axis_z, Direction::Kind::fit}) {
    const Frame frame = frame_of(a, b, looking(kind));
    EXPECT_TRUE(same_frame(frame, frame_of(b, a, looking(kind))));
    FieldRandom(9).shuffle(a.points);
    for (const int threads : {1, 2, 7})
      run_with_threads(threads, [&] { EXPECT_TRUE(same_frame(frame, frame_of(a, b, looking(kind)))); });
  }
}

TEST(Frame, origin_subtracts_exactly_from_every_kept_coordinate) {
  FieldRandom random(11);
  for (int round = 0; round < 4000; ++round) {
    const double extent = std::ldexp(random.uniform(0.5, 1), static_cast<int>(random.below(120)) - 60);
    const double centre = extent * std::ldexp(random.uniform(-1, 1), static_cast<int>(random.below(56)));
    const auto draw = [&] { return random.uniform(centre - extent / 2, centre + extent / 2); };
    Cloud a = make_cloud({});
    for (int i = 0; i < 12; ++i) a.points.push_back({draw(), draw(), draw()});
    const Frame frame = frame_of(a, a);
    for (const Point3& p : a.points) {
      ASSERT_TRUE(exact_difference(p.x, frame.origin.x)) << p.x << " - " << frame.origin.x;
      ASSERT_TRUE(exact_difference(p.y, frame.origin.y)) << p.y << " - " << frame.origin.y;
      ASSERT_TRUE(exact_difference(p.z, frame.origin.z)) << p.z << " - " << frame.origin.z;
      ASSERT_EQ(frame.to_input(frame.to_field(p)), p);
    }
  }
}

TEST(Frame, origin_is_zero_near_zero_and_near_the_centre_far_away) {
  const Cloud near = make_cloud({{0, -10, 30}, {10, 10, 40}});
  EXPECT_EQ(frame_of(near, near).origin, (Point3{0, 0, 0}));
  const Cloud far = make_cloud({{500000, -4.0e6, 7}, {500100, -3.9999e6, 7}});
  const Frame frame = frame_of(far, far);
  EXPECT_LE(std::fabs(frame.origin.x - 500050), 64);
  EXPECT_EQ(std::fmod(frame.origin.x, 128), 0);
  EXPECT_LE(std::fabs(frame.origin.y + 3.99995e6), 64);
  EXPECT_EQ(frame.origin.z, 7) << "no extent: the coordinate itself";
}

TEST(Frame, utm_coordinates_lose_nothing_in_any_axis_direction) {
  const Cloud a = smooth_cloud(5000, 7, 800, {562766.123, 5116490.456, 2102.684});
  for (const auto kind : {Direction::Kind::axis_x, Direction::Kind::axis_y, Direction::Kind::axis_z}) {
    const Frame frame = frame_of(a, a, looking(kind));
    for (const Point3& p : a.points) {
      const Point3 back = frame.to_input(frame.to_field(p));
      ASSERT_EQ(std::memcmp(&back, &p, sizeof p), 0);
    }
  }
}

TEST(Frame, oblique_frames_return_within_1e_15_of_the_size) {
  const Cloud a = smooth_cloud(2000, 7, 800);
  const Frame frame = frame_of(a, a, looking(Direction::Kind::vector, {1, -2, 3}));
  for (const Point3& p : a.points) {
    const Point3 back = frame.to_input(frame.to_field(p));
    const double size = std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
    ASSERT_LE(std::hypot(back.x - p.x, back.y - p.y, back.z - p.z), 1e-15 * size);
  }
}

TEST(Frame, pose_moves_the_second_cloud_before_the_frame_is_chosen) {
  const Cloud a = smooth_cloud(100, 1), b = smooth_cloud(100, 2);
  Pose pose;
  pose.m[3] = 1e6;
  Cloud moved = b;
  for (Point3& p : moved.points) p.x += 1e6;
  EXPECT_TRUE(same_frame(choose_frame(a, b, pose, {}, {}), frame_of(a, moved)));
  EXPECT_FALSE(same_frame(choose_frame(a, b, pose, {}, {}), frame_of(a, b)));
}

TEST(Frame, curve_covers_both_clouds) {
  const Cloud a = smooth_cloud(100, 1), b = smooth_cloud(100, 2, 10, {35, 0, 0});
  const Frame frame = frame_of(a, b, looking(Direction::Kind::vector, {1, 2, 5}));
  const double width = std::ldexp(1 / frame.curve.scale, 32);
  for (const Cloud* cloud : {&a, &b})
    for (const Point3& p : cloud->points) {
      const Point3 q = frame.to_field(p);
      EXPECT_TRUE(q.x >= frame.curve.min.x && q.x <= frame.curve.min.x + width);
      EXPECT_TRUE(q.y >= frame.curve.min.y && q.y <= frame.curve.min.y + width);
    }
}

TEST(Frame, refuses_clouds_without_points_and_coordinates_without_bounds) {
  const Cloud some = smooth_cloud(10, 1);
  const Cloud none = make_cloud({{NAN, 0, 0}, {0, 0, std::numeric_limits<double>::infinity()}});
  EXPECT_THROW((void)frame_of(some, none), InputError);
  EXPECT_THROW((void)frame_of(none, some), InputError);
  EXPECT_THROW((void)frame_of(make_cloud({}), some), InputError);
  const Cloud wide = make_cloud({{-1e308, 0, 0}, {1e308, 0, 0}});
  EXPECT_THROW((void)frame_of(wide, some), InputError);
}

}  // namespace
}  // namespace isopach::test
