// Verdicts on poses: the numbers against a twin that looks at all pairs of points, what is trusted and what is not.
#include "isopach/match/verdict/verdict.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <numbers>

#include "isopach/base/error.hpp"
#include "isopach/distance/vectors.hpp"
#include "isopach/simulate/scene.hpp"
#include "tests/match/poses.hpp"
#include "tests/support/clouds.hpp"

namespace isopach {
namespace {

using test::turn_and_shift;

Context threads(int n) {
  Context c;
  c.threads = n;
  return c;
}

JudgedScan scan_of(const Cloud& cloud) { return judged_scan(cloud, {}, {}); }

/// A surface with hills of several widths over the unit square, and noise.
Cloud hills(std::size_t n, std::uint64_t seed, double noise) {
  test::Random random(seed + 100);
  return test::cloud_over(test::uniform(n, seed), [&](const Point2& p) {
    return 0.12 * std::sin(5 * p.x + 1.3 * p.y) * std::cos(4 * p.y - p.x) + 0.05 * std::sin(13 * p.x * p.y + 2) +
           0.04 * std::cos(17 * p.y - 9 * p.x * p.x) + noise * (random.uniform(-1, 1) + random.uniform(-1, 1));
  });
}

Scene scene(const std::string& name, const std::string& variant, std::size_t n, double noise) {
  SceneOptions o;
  o.points_a = n, o.points_b = n + n / 5;
  o.noise_a = o.noise_b = noise;
  o.variant = variant;
  return make_scene(name, o, {});
}

// --- the twin: every nearest point by looking at all, every sum as it is written down
// ---------------------------------

std::vector<Index> nearest_of(const Array<Point3>& points, const Point3& p, std::size_t k) {
  std::vector<Index> ids(points.size());
  for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = static_cast<Index>(i);
  std::sort(ids.begin(), ids.end(),
            [&](Index i, Index j) { return squared_length(points[i] - p) < squared_length(points[j] - p); });
  ids.resize(std::min(k, ids.size()));
  return ids;
}

Eigen::Vector3d vec(const Point3& p) { return {p.x, p.y, p.z}; }

Eigen::Vector3d twin_normal(const Array<Point3>& points, const std::vector<Index>& ids, const Eigen::Vector3d& eye) {
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(ids.size()), 3);
  for (std::size_t i = 0; i < ids.size(); ++i) rows.row(static_cast<Eigen::Index>(i)) = vec(points[ids[i]]).transpose();
  const Eigen::RowVector3d mean = rows.colwise().mean();
  rows.rowwise() -= mean;
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(rows, Eigen::ComputeThinV);
  const Eigen::Vector3d n = svd.matrixV().col(2);
  return n.dot(eye) < 0 ? Eigen::Vector3d(-n) : n;
}

double twin_correlation(const std::vector<Eigen::Vector3d>& at, const std::vector<Eigen::Vector3d>& a,
                        const std::vector<Eigen::Vector3d>& b) {
  const auto n = static_cast<Eigen::Index>(at.size());
  Eigen::MatrixXd x(n, 4), left(n, 3), right(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    x.row(i) << 1, at[k].transpose();
    left.row(i) = a[k].transpose(), right.row(i) = b[k].transpose();
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(x);
  left -= x * qr.solve(left), right -= x * qr.solve(right);
  return (left.array() * right.array()).sum() / std::sqrt(left.squaredNorm() * right.squaredNorm());
}

struct TwinScan {
  std::vector<Eigen::Vector3d> normals, mean_normals;
  double noise = 0, within = 0, detail = 0;

  explicit TwinScan(const JudgedScan& s) {
    const std::size_t n = s.points.size();
    std::vector<std::vector<Index>> near(n);
    for (std::size_t i = 0; i < n; ++i) {
      near[i] = nearest_of(s.points, s.points[i], 32);
      normals.push_back(twin_normal(s.points, {near[i].begin(), near[i].begin() + 12}, eye(s, i)));
    }
    for (std::size_t i = 0; i < n; ++i) mean_normals.push_back(mean(normals, {near[i].begin(), near[i].begin() + 12}));
    std::vector<Eigen::Vector3d> half(n);
    for (std::size_t i = 0; i < n; ++i) half[i] = twin_normal(s.points, some(s, near[i], i, true, 12), eye(s, i));
    std::vector<double> distances;
    std::vector<Eigen::Vector3d> at, a, b;
    for (const Index i :
         s.queries) {  // other points than the product draws: all of one half, so numbers are near, not same
      if (s.half[i] == 0) continue;
      const std::vector<Index> other = some(s, near[i], i, false, 8);
      Eigen::Vector3d centre = Eigen::Vector3d::Zero();
      for (const Index k : other) centre += vec(s.points[k]) / static_cast<double>(other.size());
      distances.push_back(std::fabs(twin_normal(s.points, other, eye(s, i)).dot(vec(s.points[i]) - centre)));
      at.push_back(vec(s.points[i]));
      a.push_back(mean(half, some(s, near[i], i, true, 12)));
      b.push_back(mean(half, some(s, near[other[0]], other[0], true, 12)));
    }
    detail = twin_correlation(at, a, b);
    std::sort(distances.begin(), distances.end());
    noise = 1.4826 * distances[distances.size() / 2];
    within = static_cast<double>(
                 std::count_if(distances.begin(), distances.end(), [&](double d) { return d < 3 * noise; })) /
             static_cast<double>(distances.size());
  }
  static Eigen::Vector3d eye(const JudgedScan& s, std::size_t i) { return vec(s.viewing.line_of_sight(s.points[i])); }
  static Eigen::Vector3d mean(const std::vector<Eigen::Vector3d>& v, const std::vector<Index>& ids) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Index k : ids) sum += v[k];
    return sum / static_cast<double>(ids.size());
  }
  static std::vector<Index> some(const JudgedScan& s, const std::vector<Index>& near, std::size_t i, bool own,
                                 std::size_t most) {
    std::vector<Index> ids;
    for (const Index k : near)
      if ((s.half[k] == s.half[i]) == own && ids.size() < most) ids.push_back(k);
    return ids;
  }
};

struct TwinWay {
  double agree = 0, shape = 0, in_view = 0;
  bool seen = false;
};

/// Queries of `a` seen by `b`, whose points are brought by `to_b`; `sign` of the normals of the moving scan.
template <class Place, class Turn>
TwinWay twin_way(const JudgedScan& a, const JudgedScan& b, double noise, double sign, const Place& to_b,
                 const Turn& turn) {
  Array<Point3> places;
  for (const Point3& p : b.points) places.push_back(b.viewing.place(p));
  TwinWay way;
  std::size_t facing = 0, agree = 0, in_view = 0;
  std::vector<Eigen::Vector3d> at, first, second;
  for (const Index q : a.queries) {
    const Point3 p = to_b(a.points[q]), place = b.viewing.place(p);
    const std::vector<Index> near = nearest_of(places, place, 4);
    if (!(length(places[near[0]] - place) < 1.5 * b.place_spacing)) continue;
    ++in_view;
    const Point3 eye = b.viewing.line_of_sight(p);
    double least = std::numeric_limits<double>::infinity();
    Index partner = 0;
    for (const Index k : near) {
      const double along = dot(b.normals[k], p - b.points[k]);
      const double depth = b.viewing.nearness(p) - b.viewing.nearness(b.points[k]);
      double g = dot(b.normals[k], eye) > 0.15 ? along : 0.3 * depth;
      if ((g > 0) != (depth > 0) && std::fabs(depth) >= 3 * b.place_spacing) g = 0.3 * depth;
      if (std::fabs(g) < least) least = std::fabs(g), partner = k;
    }
    if (!(sign * dot(turn(a.normals[q]), eye) > 0.2)) continue;
    ++facing;
    agree += least <= 3 * noise ? 1u : 0u;
    at.push_back(vec(p));
    first.push_back(sign * vec(turn(a.mean_normals[q])));
    second.push_back(vec(b.mean_normals[partner]));
  }
  way.in_view = static_cast<double>(in_view) / static_cast<double>(a.queries.size());
  if (facing < 30) return way;
  way.seen = true;
  way.agree = static_cast<double>(agree) / static_cast<double>(facing);
  way.shape = twin_correlation(at, first, second);
  return way;
}

/// About the origins of the two scans; no scale.
PoseEvidence twin_evidence(const JudgedScan& a, const JudgedScan& b, const Pose& pose) {
  Eigen::Matrix3d r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) r(i, j) = pose.m[static_cast<std::size_t>(4 * i + j)];
  const Eigen::Vector3d t = vec(pose.apply(a.origin)) - vec(b.origin);
  const auto point3 = [](const Eigen::Vector3d& v) { return Point3{v(0), v(1), v(2)}; };
  const auto there = [&](const Point3& p) { return point3(r * vec(p) + t); };
  const auto back = [&](const Point3& p) { return point3(r.transpose() * (vec(p) - t)); };
  const auto turn = [&](const Point3& v) { return point3(r * vec(v)); };
  const auto turn_back = [&](const Point3& v) { return point3(r.transpose() * vec(v)); };
  const double noise = std::hypot(a.noise, b.noise);
  PoseEvidence e;
  bool first_seen = false;
  for (const double sign : {1.0, -1.0}) {
    const TwinWay one = twin_way(a, b, noise, sign, there, turn), two = twin_way(b, a, noise, sign, back, turn_back);
    const double agree = std::min(one.agree, two.agree) / std::min(a.within_noise, b.within_noise);
    const double shape = std::min(one.shape, two.shape) / std::min(a.detail, b.detail);
    const bool is_seen = one.seen && two.seen;
    if (sign > 0) first_seen = is_seen;
    if (sign > 0 || (is_seen && (!first_seen || std::min(agree, shape) > e.least()))) e.agree = agree, e.shape = shape;
    e.in_view = {one.in_view, two.in_view};
  }
  return e;
}

TEST(JudgedScan, NormalsNoiseAndDetailAsByAllPairs) {
  const JudgedScan s = scan_of(hills(1500, 3, 0.004));
  const TwinScan twin(s);
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    EXPECT_NEAR(vec(s.normals[i]).dot(twin.normals[i]), 1, 1e-7);
    EXPECT_LT((vec(s.mean_normals[i]) - twin.mean_normals[i]).norm(), 1e-6);
  }
  EXPECT_NEAR(s.noise, twin.noise, 0.25 * twin.noise);  // of other points
  EXPECT_NEAR(s.within_noise, twin.within, 0.05);
  EXPECT_NEAR(s.detail, twin.detail, 0.05);
}

TEST(JudgedScan, NoiseIsWhatWasAdded) {
  for (const double sigma : {0.002, 0.004}) {
    test::Random random(9);
    const Cloud flat = test::cloud_over(test::uniform(6000, 4), [&](const Point2& p) {
      double z = 0;
      for (int k = 0; k < 12; ++k) z += random.uniform(-0.5, 0.5);
      return 0.1 * p.x + sigma * z;
    });
    // A point about a plane fitted to eight others: an eighth more variance, and some for the tilt.
    EXPECT_NEAR(scan_of(flat).noise, sigma * std::sqrt(1 + 3.0 / 8), 0.15 * sigma);
  }
}

TEST(Evidence, AsByAllPairs) {
  const Cloud a = hills(900, 1, 0.002), b = hills(1100, 2, 0.002);
  const JudgedScan moving = scan_of(a), fixed = scan_of(b);
  const Point3 middle = test::middle_of(a);
  for (const Pose& pose :
       {Pose{}, turn_and_shift({0, 0, 1}, 4, middle, {0.01, 0, 0}),
        turn_and_shift({1, 2, 0}, 25, middle, {0.1, -0.2, 0.02}), turn_and_shift({1, 0, 0}, 180, middle, {0, 0, 0})}) {
    const PoseEvidence e = evidence_at(moving, fixed, pose, {}, {1, 0, 0, 0, 1, 0, 0, 0, 1}),
                       twin = twin_evidence(moving, fixed, pose);
    EXPECT_NEAR(e.agree, twin.agree, 1e-12);
    EXPECT_NEAR(e.shape, twin.shape, 1e-6);
    EXPECT_EQ(e.in_view, twin.in_view);
  }
}

TEST(Verdict, TrustsTheTruthAndDoubtsWhatIsOff) {
  for (const auto& [name, variant] :
       {std::pair<std::string, std::string>{"terrain", ""}, {"face", ""}, {"relief", ""}}) {
    const Scene s = scene(name, variant, 9000, 0.05);
    const JudgedScan fixed = scan_of(s.a), moving = scan_of(s.b);
    EXPECT_EQ(judge(moving, fixed, Pose{}).grade, Grade::trusted)
        << name << ": " << sentence(judge(moving, fixed, {}), "m");
    const Point3 middle = test::middle_of(s.b);
    const double extent = fixed.extent;
    for (const Pose& off :
         {turn_and_shift({0, 0, 1}, 20, middle, {0, 0, 0}), turn_and_shift({1, 1, 0}, 15, middle, {0, 0, 0}),
          turn_and_shift({0, 0, 1}, 0, middle, {0.06 * extent, 0.02 * extent, 0}),
          turn_and_shift({1, 0, 0}, 180, middle, {0, 0, 0}), turn_and_shift({0, 0, 1}, 180, middle, {0, 0, 0}),
          turn_and_shift({0, 0, 1}, 0, middle, {0, 0, 0.05 * extent})})
      EXPECT_NE(judge(moving, fixed, off).grade, Grade::trusted) << name;
    if (name == "face") continue;  // its mirror image is itself
    Cloud mirrored = s.b;
    for (Point3& p : mirrored.points) p.x = 2 * middle.x - p.x;
    EXPECT_NE(judge(scan_of(mirrored), fixed, Pose{}).grade, Grade::trusted) << name;
  }
}

TEST(Verdict, SameForAnyOrderThreadsAndPlaceOfTheWorld) {
  const Cloud a = hills(3000, 1, 0.002), b = hills(3500, 2, 0.002);
  const Pose pose = turn_and_shift({0, 0, 1}, 2, {0.5, 0.5, 0}, {0.01, 0, 0});
  const auto numbers = [&](const Cloud& x, const Cloud& y, int n) {
    const Context c = threads(n);
    const PoseEvidence e = judge(judged_scan(x, {}, c), judged_scan(y, {}, c), pose).evidence;
    return std::array<double, 6>{e.agree, e.shape, e.slip, e.in_front, e.behind, e.in_view[0]};
  };
  const auto first = numbers(a, b, 1);
  EXPECT_EQ(first, numbers(test::shuffled(a, 5), test::shuffled(b, 6), 3));
  Cloud twice = a;
  twice.points.insert(twice.points.end(), a.points.begin(), a.points.end());
  EXPECT_EQ(first, numbers(twice, b, 2));
}

TEST(Verdict, LargeCoordinates) {
  const Point3 far{4.5e6, 5.1e6, 1000};
  const Cloud a = test::shifted(hills(4000, 1, 0.002), far), b = test::shifted(hills(4500, 2, 0.002), far);
  EXPECT_EQ(judge(scan_of(a), scan_of(b), Pose{}).grade, Grade::trusted);
  Pose off;
  off.m[3] = 0.05;
  EXPECT_EQ(judge(scan_of(a), scan_of(b), off).grade, Grade::doubted);
}

TEST(Verdict, IdenticalScansWithoutNoise) {
  const Cloud a = hills(4000, 1, 0);
  const Verdict v = judge(scan_of(a), scan_of(a), Pose{});
  EXPECT_EQ(v.grade, Grade::trusted) << sentence(v, "m");
  EXPECT_GT(v.evidence.noise[0], 0);
  EXPECT_EQ(judge(scan_of(a), scan_of(hills(6000, 2, 0)), Pose{}).grade, Grade::trusted);
}

TEST(Verdict, DifferentDensities) {
  const JudgedScan many = scan_of(hills(30000, 1, 0.002)), few = scan_of(hills(2500, 2, 0.002));
  EXPECT_EQ(judge(few, many, Pose{}).grade, Grade::trusted) << sentence(judge(few, many, Pose{}), "m");
  EXPECT_EQ(judge(many, few, Pose{}).grade, Grade::trusted);
}

/// Points on a unit sphere, cylinder (height 2) or square, with noise.
Cloud shape(const std::string& name, std::size_t n, std::uint64_t seed) {
  test::Random random(seed);
  Cloud cloud;
  while (cloud.points.size() < n) {
    const double r = 1 + 0.002 * (random.uniform(-1, 1) + random.uniform(-1, 1));
    const double a = random.uniform(0, 2 * std::numbers::pi), h = random.uniform(-1, 1);
    if (name == "sphere")
      cloud.points.push_back({r * std::sqrt(1 - h * h) * std::cos(a), r * std::sqrt(1 - h * h) * std::sin(a), r * h});
    else if (name == "cylinder")
      cloud.points.push_back({r * std::cos(a), r * std::sin(a), h});
    else
      cloud.points.push_back({random.uniform(-1, 1), h, r - 1});
  }
  return cloud;
}

TEST(Verdict, WhatSlidesIsUndeterminedAndTheMotionNamed) {
  for (const std::string name : {"sphere", "cylinder", "plane"}) {
    const Verdict v = judge(scan_of(shape(name, 6000, 1)), scan_of(shape(name, 7000, 2)), Pose{});
    EXPECT_EQ(v.grade, Grade::undetermined) << name;
    EXPECT_FALSE(v.evidence.loosest.empty()) << name;
    EXPECT_THROW(require_trust(v, "m", "match"), Error);
  }
  const Verdict cylinder = judge(scan_of(shape("cylinder", 6000, 1)), scan_of(shape("cylinder", 7000, 2)), Pose{});
  EXPECT_NE(sentence(cylinder, "m").find("(0.00, 0.00, 1.00)"), std::string::npos) << sentence(cylinder, "m");
}

TEST(Verdict, AskedForHeightsAlone) {
  Freedom heights{false, false, true, false, false, false, false};
  const JudgedScan a = scan_of(shape("plane", 5000, 1)), b = scan_of(shape("plane", 6000, 2));
  const std::array<double, 9> axes{1, 0, 0, 0, 1, 0, 0, 0, 1};
  EXPECT_EQ(judge(a, b, Pose{}, heights, axes).grade, Grade::trusted);
  Pose off;
  off.m[11] = 0.05;
  EXPECT_EQ(judge(a, b, off, heights, axes).grade, Grade::doubted);
  Freedom sideways = heights;
  sideways.shift_x = true;
  EXPECT_EQ(judge(a, b, Pose{}, sideways, axes).grade, Grade::undetermined);
}

TEST(Verdict, TooFewPointsAreDoubtedInWords) {
  const Verdict v = judge(scan_of(hills(40, 1, 0)), scan_of(hills(4000, 2, 0)), Pose{});
  EXPECT_EQ(v.grade, Grade::doubted);
  EXPECT_NE(sentence(v, "m").find("too few points"), std::string::npos);
}

TEST(Verdict, NothingInViewEndsWithExit4ElseWith5) {
  const JudgedScan a = scan_of(hills(4000, 1, 0.002)), b = scan_of(hills(4000, 2, 0.002));
  const auto code = [&](const Pose& pose) {
    try {
      require_trust(judge(a, b, pose), "m", "match");
    } catch (const Error& error) {
      return error.code();
    }
    return ExitCode::done;
  };
  Pose away;
  away.m[3] = 3;
  EXPECT_EQ(code(away), ExitCode::no_overlap);
  EXPECT_EQ(code(turn_and_shift({0, 0, 1}, 90, {0.5, 0.5, 0}, {0, 0, 0})), ExitCode::not_converged);
  EXPECT_EQ(code(Pose{}), ExitCode::done);
}

TEST(Verdict, ChangeOverASmallPartIsTrustedOverMostOfItDoubted) {
  const Cloud before = hills(6000, 1, 0.002);
  const auto mound = [](Cloud cloud, double reach) {
    for (Point3& p : cloud.points) p.z += p.x < reach ? 0.03 + 0.05 * std::sin(20 * p.y) : 0;
    return cloud;
  };
  const JudgedScan fixed = scan_of(before);
  EXPECT_EQ(judge(scan_of(mound(hills(6000, 2, 0.002), 0.15)), fixed, Pose{}).grade, Grade::trusted);
  const Verdict v = judge(scan_of(mound(hills(6000, 2, 0.002), 0.8)), fixed, Pose{});
  EXPECT_EQ(v.grade, Grade::doubted);
  EXPECT_NE(sentence(v, "m").find("really changed"), std::string::npos);
}

TEST(Verdict, WhatASurfaceHoldsLooselyNeedsMoreAgreement) {
  PoseEvidence e;
  e.slip = 2, e.agree = 0.9;
  EXPECT_DOUBLE_EQ(agreement_needed(e), 0.70);
  e.slip = 0.5;
  EXPECT_DOUBLE_EQ(agreement_needed(e), 0.85);
  e.slip = 0.01;
  EXPECT_DOUBLE_EQ(agreement_needed(e), 0.95);
  // Two samples of gentle ground by 800 points, noise of a tenth of its height: a quarter of it raised is change, or a
  // wrong pose, and nothing tells which.
  const auto gentle = [](std::uint64_t seed, double raised) {
    Cloud cloud = hills(800, seed, 0.01);
    for (Point3& p : cloud.points) p.z += p.x < raised ? 0.08 : 0;
    return cloud;
  };
  const JudgedScan fixed = scan_of(gentle(1, 0));
  const Verdict same = judge(scan_of(gentle(2, 0)), fixed, Pose{});
  EXPECT_LT(same.evidence.slip, 0.8) << sentence(same, "m");
  EXPECT_EQ(same.grade, Grade::trusted) << sentence(same, "m");
  const Verdict raised = judge(scan_of(gentle(2, 0.22)), fixed, Pose{});
  EXPECT_GT(raised.evidence.agree, least_agreement) << sentence(raised, "m");
  EXPECT_EQ(raised.grade, Grade::doubted) << sentence(raised, "m");
}

TEST(Verdict, ShapeMayBeLessWhereAllAgreesInPlace) {
  PoseEvidence e;
  e.agree = 1.02;
  EXPECT_DOUBLE_EQ(shape_needed(e), 0.50);
  e.agree = 0.8;
  EXPECT_DOUBLE_EQ(shape_needed(e), 0.60);
  e.agree = 0.6;
  EXPECT_DOUBLE_EQ(shape_needed(e), 0.70);
}

TEST(Viewing, DirectionOfAReliefPlaceOfWhatIsAllRound) {
  const JudgedScan relief = scan_of(hills(3000, 1, 0.002));
  EXPECT_EQ(relief.viewing.kind, Viewing::Kind::direction);
  EXPECT_GT(relief.viewing.axis.z, 0.95);
  EXPECT_EQ(scan_of(shape("sphere", 4000, 1)).viewing.kind, Viewing::Kind::around);
}

TEST(Agreement, LabelsFollowTheEye) {
  const Cloud a = hills(4000, 1, 0.001);
  const JudgedScan fixed = scan_of(hills(4000, 2, 0.001));
  Cloud moving = a;
  for (std::size_t i = 0; i < moving.points.size(); ++i) moving.points[i].z += i % 3 == 0 ? 0.1 : i % 3 == 1 ? -0.1 : 0;
  moving.points.push_back({5, 5, 0});
  moving.points.push_back({std::nan(""), 0, 0});
  const Array<PointVerdict> labels = agreement_of(moving, fixed, Pose{}, std::hypot(fixed.noise, fixed.noise), {});
  std::array<std::size_t, 3> right{};
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    constexpr std::array<PointVerdict, 3> expected{PointVerdict::in_front, PointVerdict::behind, PointVerdict::agrees};
    right[i % 3] += labels[i] == expected[i % 3] ? 1u : 0u;
  }
  for (const std::size_t r : right) EXPECT_GT(r, 1150u);  // of 1333; near the border of the view there may be none
  EXPECT_EQ(labels[a.points.size()], PointVerdict::not_in_view);
  EXPECT_EQ(labels.back(), PointVerdict::not_in_view);
}

}  // namespace
}  // namespace isopach
