// The coarse start: images that no motion changes, consensus against noise, and poses found from any turn and shift.
#include "isopach/match/coarse/coarse.hpp"

#include <gtest/gtest.h>

#include "isopach/base/error.hpp"
#include "isopach/distance/vectors.hpp"
#include "isopach/match/coarse/consensus.hpp"
#include "isopach/match/coarse/landmarks.hpp"
#include "isopach/match/match.hpp"
#include "isopach/simulate/scene.hpp"
#include "tests/match/poses.hpp"
#include "tests/support/clouds.hpp"

namespace isopach {
namespace {

using test::chained;
using test::off_identity;

Scene scene(const std::string& name, const std::string& variant, std::size_t n, double noise) {
  SceneOptions o;
  o.points_a = n, o.points_b = n + n / 4;
  o.noise_a = o.noise_b = noise;
  o.variant = variant;
  Scene s = make_scene(name, o, {});
  s.a.attributes.clear(), s.b.attributes.clear();
  return s;
}

std::vector<Point3> waves(std::size_t n, std::uint64_t seed) {
  const Cloud cloud = test::cloud_over(
      test::uniform(n, seed), [](const Point2& p) { return 0.1 * std::sin(9 * p.x + 2 * p.y) * std::cos(7 * p.y); });
  return {cloud.points.begin(), cloud.points.end()};
}

MatchOptions unchecked() {
  MatchOptions o;
  o.compare.check_layers = false;
  return o;
}

/// Degrees and share of the extent that the start is off after MOVING was taken away.
test::PoseError start_error(const Cloud& fixed, const Cloud& moving, const Pose& away, double extent) {
  const Pose start = coarse_start(test::posed(moving, away), fixed, unchecked(), {});
  const test::PoseError e = off_identity(chained(start, away), test::middle_of(moving));
  return {e.degrees, e.shift / extent};
}

TEST(Landmarks, AreMeansOfCubes) {
  const std::vector<Point3> points = waves(3000, 1);
  const double side = 0.07;
  const Landmarks marks = landmarks(points, side, {});
  std::map<std::array<long, 3>, std::vector<Point3>> cubes;
  for (const Point3& p : points)
    cubes[{std::lround(std::floor(p.x / side)), std::lround(std::floor(p.y / side)),
           std::lround(std::floor(p.z / side))}]
        .push_back(p);
  ASSERT_EQ(marks.places.size(), cubes.size());
  std::size_t i = 0;
  for (const auto& [place, inside] : cubes) {
    Point3 sum{0, 0, 0};
    for (const Point3& p : inside) sum = sum + p;
    EXPECT_LT(length(marks.places[i++] - (1 / static_cast<double>(inside.size())) * sum), 1e-12);
  }
  const std::size_t wanted = landmark_side(points, points, 400) > 0 ? 400 : 0;
  const Landmarks few = landmarks(points, landmark_side(points, points, 400), {});
  EXPECT_NEAR(static_cast<double>(few.places.size()), static_cast<double>(wanted), 80);
}

TEST(Landmarks, NormalsPointToOneSide) {
  std::vector<Point3> ball;
  test::Random random(3);
  while (ball.size() < 4000) {
    const Point3 p{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    if (length(p) < 1 && length(p) > 0.1) ball.push_back((1 / length(p)) * p);
  }
  const Landmarks marks = landmarks(ball, 0.15, {});
  std::size_t out = 0;
  for (std::size_t i = 0; i < marks.places.size(); ++i) out += dot(marks.places[i], marks.normals[i]) > 0.9 ? 1u : 0u;
  EXPECT_TRUE(out == 0 || out == marks.places.size()) << out << " of " << marks.places.size();
  for (const Point3& n : landmarks(waves(3000, 1), 0.05, {}).normals) EXPECT_GT(n.z, 0.5);
}

// The definition, bin by bin, by every landmark.
TEST(Landmarks, ImagesCountNeighbours) {
  Landmarks a = landmarks(waves(2000, 1), 0.06, {}), b = landmarks(waves(2000, 2), 0.06, {});
  describe(a, b, {});
  double squares = 0, count_all = 0;
  for (const Landmarks* marks : {&a, &b})
    for (const double h : marks->heights) squares += h * h, count_all += 1;
  const double radius = support_sides * a.side, top = 5 * std::sqrt(squares / count_all);
  for (std::size_t i = 0; i < a.places.size(); i += 7) {
    std::array<double, SpinImage::rings> count{};
    std::array<double, SpinImage::rings * SpinImage::floors> cells{};
    for (std::size_t k = 0; k < a.places.size(); ++k) {
      const Point3 d = a.places[k] - a.places[i];
      if (k == i || length(d) > radius) continue;
      const double up = dot(d, a.normals[i]), out = std::sqrt(squared_length(d) - up * up);
      const auto ring = static_cast<std::size_t>(std::min(SpinImage::rings - 1.0, out / radius * SpinImage::rings));
      count[ring] += 1;
      for (std::size_t floor = 0; floor < SpinImage::floors; ++floor) {  // tents round the middle of each floor
        const double place = std::clamp((up / top + 1) / 2, 0.0, 1.0) * (SpinImage::floors - 1);
        cells[ring * SpinImage::floors + floor] += std::max(0.0, 1 - std::fabs(place - static_cast<double>(floor)));
      }
    }
    for (std::size_t k = 0; k < cells.size(); ++k) {
      const double n = count[k / SpinImage::floors];
      EXPECT_NEAR(a.images[i].cells[k], n < 3 ? 0 : cells[k] / n, 1e-5);
    }
    EXPECT_EQ(image_distance(a.images[i], a.images[i]), 0);
    EXPECT_EQ(flipped(flipped(a.images[i])).cells, a.images[i].cells);
  }
}

TEST(Consensus, FindsTheMotionOfOneInTen) {
  test::Random random(5);
  const Motion truth = moved(Motion{}, {0.4, -1, 2, 10, 20, -5, 0}, {0, 0, 0});
  const auto place = [&] { return Point3{random.uniform(-50, 50), random.uniform(-50, 50), random.uniform(-9, 9)}; };
  const auto normal = [&] {
    const Point3 n{random.uniform(-1, 1), random.uniform(-1, 1), 1};
    return (1 / length(n)) * n;
  };
  std::vector<Likeness> pairs;
  for (int i = 0; i < 600; ++i) {
    const Point3 p = place(), n = normal();
    const bool right = i % 10 == 0;
    const Point3 off{random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4)};
    pairs.push_back({p, right ? truth.apply(p) + off : place(), n, right ? truth.turn(n) : normal(), 0.1f});
  }
  const std::vector<Agreement> found = agreements(pairs, 1, 5, {});
  ASSERT_FALSE(found.empty());
  EXPECT_GE(found[0].support, 58u);
  for (const Point3& p : {Point3{0, 0, 0}, Point3{40, -30, 5}})
    EXPECT_LT(length(found[0].motion.apply(p) - truth.apply(p)), 0.3);
  for (std::size_t k = 1; k < found.size(); ++k) EXPECT_LT(found[k].support, 20u);
  EXPECT_TRUE(agreements({}, 1, 5, {}).empty());
}

TEST(Coarse, AnyTurnAboutTheAxis) {
  const Scene terrain = scene("terrain", "", 4000, 0.03), face = scene("face", "", 4000, 0.05);
  for (const auto& [s, extent, degrees] : {std::tuple{&terrain, 1000.0, 170.0}, std::tuple{&face, 220.0, 120.0}}) {
    const Point3 shift{0.4 * extent, -0.3 * extent, 0.2 * extent};
    const auto e =
        start_error(s->a, s->b, test::turn_and_shift({0, 0, 1}, degrees, test::middle_of(s->b), shift), extent);
    EXPECT_LT(e.degrees, 0.5) << s->name << degrees;
    EXPECT_LT(e.shift, 0.005) << s->name << degrees;
  }
}

TEST(Coarse, HalfInCommon) {
  const Scene s = scene("relief", "unchanged", 5000, 0.07);
  Cloud a = s.a, b = s.b;
  std::erase_if(a.points, [](const Point3& p) { return p.x > 667; });
  std::erase_if(b.points, [](const Point3& p) { return p.x < 333; });
  const auto e = start_error(a, b, test::turn_and_shift({0, 0, 1}, 100, test::middle_of(b), {-400, 200, 30}), 1000);
  EXPECT_LT(e.degrees, 0.5);
  EXPECT_LT(e.shift, 0.005);
}

TEST(Coarse, AnyTurnOfAFaceAndOfABody) {
  const Scene s = scene("face", "", 4000, 0.05);
  const auto e = start_error(s.a, s.b, test::turn_and_shift({1, 2, -1}, 150, {0, 0, 0}, {900, 100, -300}), 220);
  EXPECT_LT(e.degrees, 0.5);
  EXPECT_LT(e.shift, 0.005);
}

// From the coarse start the fine match ends where it ends from a near one.
TEST(Coarse, ThenFine) {
  const Scene s = scene("terrain", "", 4000, 0.03);
  const Pose away = test::turn_and_shift({0, 0, 1}, 137, test::middle_of(s.b), {300, -200, 20});
  for (const Objective objective : {Objective::measure, Objective::icp_plane}) {
    MatchOptions o = unchecked();
    o.objective = objective;
    const Matching near = match(s.b, s.a, o, {});
    o.coarse = true;
    const Cloud moving = test::posed(s.b, away);
    const Matching far = match(moving, s.a, o, {});
    EXPECT_NEAR(far.after.rho, near.after.rho, 0.02 * near.after.rho);
    EXPECT_LT(off_identity(chained(far.pose, away), test::middle_of(s.b)).degrees, 0.02);
    Context two;
    two.threads = 2;
    EXPECT_EQ(match(test::shuffled(moving, 1), test::shuffled(s.a, 2), o, two).pose.m, far.pose.m);
  }
}

TEST(Coarse, FlatAndUnrelated) {
  test::Random random(5);
  const auto flat = [&](const Point2&) { return 0.002 * random.uniform(-1, 1); };
  const Cloud plane = test::cloud_over(test::framed_square(3000, 1), flat);
  const Pose start = coarse_start(test::shifted(plane, {3, 2, 1}), plane, unchecked(), {});
  EXPECT_NEAR(start.m[11], -1, 0.01) << "nothing to recognise: middle on middle, unturned";
  EXPECT_LT(off_identity(start, {0, 0, 0}).degrees, 0.5);
  const Cloud few = test::cloud_over(test::uniform(20, 1), flat);
  EXPECT_NO_THROW((void)coarse_start(plane, plane, unchecked(), {}));
  try {
    (void)coarse_start(few, plane, unchecked(), {});
  } catch (const OverlapError& error) {
    EXPECT_NE(std::string(error.what()).find("@coarse"), std::string::npos);
  }
}

}  // namespace
}  // namespace isopach
