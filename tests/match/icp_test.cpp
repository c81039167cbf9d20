// ICP: pairs against every point, steps against dense least squares, the whole loop against a plain one, and known
// poses.
#include "isopach/match/pairs/icp.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <set>

#include "isopach/base/error.hpp"
#include "isopach/distance/vectors.hpp"
#include "isopach/match/match.hpp"
#include "isopach/match/pairs/least_squares.hpp"
#include "isopach/match/pairs/pairs.hpp"
#include "isopach/simulate/scene.hpp"
#include "tests/match/poses.hpp"
#include "tests/support/clouds.hpp"

namespace isopach {
namespace {

using test::chained;
using test::off_identity;

IcpOptions every_pair() {
  IcpOptions o;
  o.reject_distance = 0, o.reject_normal = 0, o.reject_boundary = false;
  o.weights = IcpOptions::Weights::uniform;
  return o;
}

MatchOptions by(Objective objective) {
  MatchOptions o;
  o.objective = objective;
  o.compare.check_layers = false;
  return o;
}
const Objective every_kind[] = {Objective::icp_point, Objective::icp_plane, Objective::icp_gicp};

/// A closed body with bumps, seen from all sides: no height field along any direction.
Cloud body(std::size_t n, std::uint64_t seed, double noise = 0) {
  test::Random random(seed);
  Cloud cloud;
  while (cloud.points.size() < n) {
    const Point3 d{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    const double r = length(d);
    if (r > 1 || r < 0.1) continue;
    const Point3 u = (1 / r) * d;
    const double size = 10 * (1 + 0.25 * std::sin(3 * u.x + 1) + 0.2 * std::cos(4 * u.y) + 0.15 * std::sin(5 * u.z)) +
                        noise * random.uniform(-1, 1);
    cloud.points.push_back({size * u.x, 1.3 * size * u.y, 0.8 * size * u.z});
  }
  return cloud;
}

/// Integer places, many of them twice.
Cloud lattice(std::size_t n, std::uint64_t seed) {
  test::Random random(seed);
  Cloud cloud;
  for (std::size_t i = 0; i < n; ++i)
    cloud.points.push_back({static_cast<double>(random.below(7)), static_cast<double>(random.below(7)),
                            static_cast<double>(random.below(3))});
  return cloud;
}

OrientedCloud oriented(const Cloud& cloud) {
  OrientedCloud o = order_points(cloud, Pose{}, Frame{}, {}, 0, {});
  orient(o, {});
  return o;
}

Motion some_motion(double size) {
  return moved(Motion{}, {0.3 * size, -0.2 * size, 0.5 * size, size, -size, 0.4 * size, 0}, {1, 2, 0});
}

double nearest(const OrientedCloud& target, const Point3& p) {
  double best = std::numeric_limits<double>::infinity();
  for (const Point3& q : target.points) best = std::min(best, squared_length(p - q));
  return best;
}

TEST(IcpPairs, AreThoseOfEveryPoint) {
  for (const bool degenerate : {false, true}) {
    const OrientedCloud a = oriented(degenerate ? lattice(300, 1) : body(400, 1)),
                        b = oriented(degenerate ? lattice(200, 2) : body(300, 2));
    PairSearch search(b, a, false), back(a, b, true);
    for (const double size :
         {0.0, 0.3, 0.301, 0.3011, 0.1, 2.0}) {  // remembered partners must be those of a full search
      const Motion motion = some_motion(size);
      const Array<Link> links = search.find(motion, 1, every_pair(), 1),
                        fresh = PairSearch(b, a, false).find(motion, 1, every_pair(), 1);
      ASSERT_EQ(links.size(), b.points.size());
      for (std::size_t i = 0; i < links.size(); ++i) {
        const Point3 place = motion.apply(b.points[links[i].query]);
        EXPECT_EQ(length(links[i].moving - place), 0);
        EXPECT_DOUBLE_EQ(squared_length(links[i].moving - links[i].fixed), nearest(a, place));
        EXPECT_EQ(length(links[i].fixed - fresh[i].fixed), 0);
      }
      for (const Link& l : back.find(motion, 1, every_pair(), 1))
        EXPECT_NEAR(squared_length(motion.undo(l.fixed) - motion.undo(l.moving)),
                    nearest(b, motion.undo(a.points[l.query])), 1e-12);
    }
  }
}

TEST(IcpPairs, Rejections) {
  const OrientedCloud a = oriented(body(500, 1)), b = oriented(body(400, 2));
  const Motion motion = some_motion(0.2);
  const Array<Link> all = PairSearch(b, a, false).find(motion, 1, every_pair(), 1);
  std::vector<double> lengths;
  for (const Link& l : all) lengths.push_back(length(l.moving - l.fixed));
  std::vector<double> sorted = lengths;
  std::sort(sorted.begin(), sorted.end());
  const auto kept = [&](const IcpOptions& o, double overlap = 1) {
    std::set<Index> queries;
    for (const Link& l : PairSearch(b, a, false).find(motion, 1, o, overlap)) queries.insert(l.query);
    return queries;
  };
  const auto expected = [&](auto&& keep) {
    std::set<Index> queries;
    for (std::size_t i = 0; i < all.size(); ++i)
      if (keep(i)) queries.insert(all[i].query);
    return queries;
  };
  IcpOptions o = every_pair();
  o.reject_distance = 1.2;
  EXPECT_EQ(kept(o), expected([&](std::size_t i) { return lengths[i] <= 1.2 * sorted[sorted.size() / 2]; }));
  o.reject_distance_absolute = true;
  EXPECT_EQ(kept(o), expected([&](std::size_t i) { return lengths[i] <= 1.2; }));
  o = every_pair();
  o.reject_normal = 20;
  EXPECT_EQ(kept(o), expected([&](std::size_t i) {
              const double cosine = dot(motion.turn(b.normals[all[i].query]), all[i].normal);
              return std::fabs(cosine) >= std::cos(20 * std::numbers::pi / 180);
            }));
  o = every_pair();
  o.one_to_one = true;
  EXPECT_EQ(kept(o), expected([&](std::size_t i) {
              for (std::size_t k = 0; k < all.size(); ++k)
                if (length(all[k].fixed - all[i].fixed) == 0 &&
                    (lengths[k] < lengths[i] || (lengths[k] == lengths[i] && all[k].query < all[i].query)))
                  return false;
              return true;
            }));
  o = every_pair();
  EXPECT_EQ(kept(o, 0.6), expected([&](std::size_t i) { return lengths[i] <= sorted[239]; }));
}

TEST(IcpPairs, NoneOnTheBoundary) {
  const Cloud square = test::cloud_over(test::framed_square(2000, 1), [](const Point2& p) { return 0.1 * p.x * p.y; });
  const OrientedCloud a = oriented(square), b = oriented(test::shifted(square, {0.3, 0, 0}));
  IcpOptions o = every_pair();
  o.reject_boundary = true;
  const Array<Link> links = PairSearch(b, a, false).find(Motion{}, 1, o, 1);
  std::size_t beyond = 0;
  for (const Link& l : links) beyond += l.moving.x > 1.05 ? 1u : 0u;
  EXPECT_GT(links.size(), 1200u);
  EXPECT_LT(beyond, 12u) << "points past the rim have their nearest on it";
}

TEST(IcpPairs, LeastFrmsdFindsTheOverlap) {
  const auto height = [](const Point2& p) { return 0.2 * std::sin(7 * p.x) * std::cos(5 * p.y); };
  Cloud part;
  for (const Point3& p : test::cloud_over(test::uniform(4000, 4), height).points)
    part.points.push_back({p.x + 0.4, p.y, height({p.x + 0.4, p.y})});
  const OrientedCloud a = oriented(test::cloud_over(test::uniform(4000, 3), height)), b = oriented(part);
  const std::size_t found = PairSearch(b, a, false).find(Motion{}, 1, every_pair(), 0).size();
  EXPECT_NEAR(static_cast<double>(found) / 4000, 0.6, 0.05);
}

Array<Link> random_links(std::size_t n, std::uint64_t seed, const Motion& motion, double noise) {
  test::Random random(seed);
  Array<Link> links;
  for (std::size_t i = 0; i < n; ++i) {
    const Point3 p{random.uniform(-5, 5), random.uniform(-3, 3), random.uniform(-1, 1)};
    const Point3 n0{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(0.2, 1)}, q = motion.apply(p);
    links.push_back({p,
                     {q.x + noise * random.uniform(-1, 1), q.y + noise * random.uniform(-1, 1), q.z},
                     (1 / length(n0)) * n0,
                     random.uniform(0.1, 1),
                     static_cast<Index>(i)});
  }
  return links;
}

double energy(const Array<Link>& links, const Motion& motion, bool plane) {
  double sum = 0, weight = 0;
  for (const Link& l : links) {
    const Point3 d = motion.apply(l.moving) - l.fixed;
    const double r = plane ? dot(d, l.normal) : length(d);
    sum += l.weight * r * r, weight += l.weight;
  }
  return sum / weight;
}

TEST(IcpStep, PointStepIsTheLeast) {
  for (const bool scale : {false, true}) {
    Motion truth = some_motion(0.8);
    if (scale) truth.scale = 1.3;
    const Array<Link> exact = random_links(50, 1, truth, 0);
    const Motion found = point_step(exact, pair_information(exact, PairKind::point), scale);
    for (std::size_t k = 0; k < 9; ++k) EXPECT_NEAR(found.rotation[k], truth.rotation[k], 1e-12);
    EXPECT_NEAR(found.scale, truth.scale, 1e-12);

    const Array<Link> noisy = random_links(50, 2, truth, 1);
    const Motion best = point_step(noisy, pair_information(noisy, PairKind::point), scale);
    const double least = energy(noisy, best, false);
    test::Random random(3);
    for (int i = 0; i < 100; ++i) {
      Twist t{};
      for (std::size_t k = 0; k < (scale ? 7u : 6u); ++k) t[k] = 0.01 * random.uniform(-1, 1);
      EXPECT_GT(energy(noisy, moved(best, t, {0, 0, 0}), false), least);
    }
  }
}

TEST(IcpStep, PointStepOfALineAndOfAPointIsARotation) {
  Array<Link> links = random_links(20, 1, some_motion(0.3), 0);
  for (const double spread : {1.0, 0.0}) {
    for (Link& l : links) l.moving = {spread * l.moving.x, 0, 0}, l.fixed = {0, spread * l.moving.x, 2};
    const Motion m = point_step(links, pair_information(links, PairKind::point), false);
    const auto& r = m.rotation;
    EXPECT_NEAR(dot({r[0], r[3], r[6]}, cross({r[1], r[4], r[7]}, {r[2], r[5], r[8]})), 1, 1e-12);
    EXPECT_NEAR(energy(links, m, false), 0, 1e-20);
  }
}

TEST(IcpStep, PlaneStepIsDenseLeastSquares) {
  const Array<Link> links = random_links(60, 4, some_motion(0.05), 0.1);
  const PairInformation in = pair_information(links, PairKind::plane);
  Eigen::MatrixXd rows(60, 6);
  Eigen::VectorXd right(60);
  for (Eigen::Index i = 0; i < 60; ++i) {
    const Link& l = links[static_cast<std::size_t>(i)];
    const Point3 turn = cross(l.moving - in.centre, l.normal);
    const double w = std::sqrt(l.weight);
    rows.row(i) << w * turn.x, w * turn.y, w * turn.z, w * l.normal.x, w * l.normal.y, w * l.normal.z;
    right(i) = -w * dot(l.moving - l.fixed, l.normal);
  }
  const Eigen::VectorXd x = rows.colPivHouseholderQr().solve(right);
  const Twist step = plane_step(in, Freedom{}, 1e-12);
  for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(step[k], x(static_cast<Eigen::Index>(k)), 1e-10);
  EXPECT_EQ(step[6], 0);
  EXPECT_NEAR(in.error, energy(links, Motion{}, true), 1e-12);
  Freedom lift{false, false, true, false, false, false, false};
  const Twist up = plane_step(in, lift, 1e-12);
  EXPECT_EQ(up[0], 0);
  EXPECT_NEAR(up[5], rows.col(5).dot(right) / rows.col(5).squaredNorm(), 1e-10);
}

/// Equations (1), (3) and those of [Segal2009], and nothing else: every point against every point, dense least squares,
/// the quaternion of Horn, covariances inverted as they stand.
class PlainIcp {
 public:
  PlainIcp(const OrientedCloud& moving, const OrientedCloud& fixed) : moving_(moving), fixed_(fixed) {}
  Motion run(int iterations, Objective objective) const {
    Motion motion;
    for (int i = 0; i < iterations; ++i)
      motion = objective == Objective::icp_plane   ? plane_next(motion)
               : objective == Objective::icp_point ? point_next(motion)
                                                   : planes_next(motion);
    return motion;
  }

 private:
  std::size_t partner(const Point3& p) const {
    std::size_t best = 0;
    for (std::size_t k = 1; k < fixed_.points.size(); ++k)
      if (squared_length(p - fixed_.points[k]) < squared_length(p - fixed_.points[best])) best = k;
    return best;
  }
  Motion point_next(const Motion& motion) const {
    const std::size_t n = moving_.points.size();
    Eigen::MatrixXd p(3, n), q(3, n);
    for (std::size_t i = 0; i < n; ++i) {
      const Point3 place = motion.apply(moving_.points[i]), t = fixed_.points[partner(place)];
      const Point3 from = moving_.points[i];
      p.col(static_cast<Eigen::Index>(i)) << from.x, from.y, from.z;
      q.col(static_cast<Eigen::Index>(i)) << t.x, t.y, t.z;
    }
    const Eigen::Vector3d pm = p.rowwise().mean(), qm = q.rowwise().mean();
    const Eigen::Matrix3d s = (p.colwise() - pm) * (q.colwise() - qm).transpose();
    Eigen::Matrix4d k;                                                                          // Horn 1987
    k << s(0, 0) + s(1, 1) + s(2, 2), s(1, 2) - s(2, 1), s(2, 0) - s(0, 2), s(0, 1) - s(1, 0),  //
        s(1, 2) - s(2, 1), s(0, 0) - s(1, 1) - s(2, 2), s(0, 1) + s(1, 0), s(2, 0) + s(0, 2),   //
        s(2, 0) - s(0, 2), s(0, 1) + s(1, 0), s(1, 1) - s(0, 0) - s(2, 2), s(1, 2) + s(2, 1),   //
        s(0, 1) - s(1, 0), s(2, 0) + s(0, 2), s(1, 2) + s(2, 1), s(2, 2) - s(0, 0) - s(1, 1);
    const Eigen::Vector4d v = Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(k).eigenvectors().col(3);
    const Eigen::Matrix3d r = Eigen::Quaterniond(v(0), v(1), v(2), v(3)).toRotationMatrix();
    const Eigen::Vector3d shift = qm - r * pm;
    Motion result;
    for (Eigen::Index i = 0; i < 3; ++i)
      for (Eigen::Index j = 0; j < 3; ++j) result.rotation[static_cast<std::size_t>(3 * i + j)] = r(i, j);
    result.shift = {shift(0), shift(1), shift(2)};
    return result;
  }
  Motion plane_next(const Motion& motion) const {
    const auto n = static_cast<Eigen::Index>(moving_.points.size());
    Eigen::MatrixXd rows(n, 6);
    Eigen::VectorXd right(n);
    Point3 centre{0, 0, 0};
    for (const Point3& p : moving_.points) centre = centre + (1 / static_cast<double>(n)) * motion.apply(p);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Point3 p = motion.apply(moving_.points[static_cast<std::size_t>(i)]);
      const std::size_t k = partner(p);
      const Point3 normal = fixed_.normals[k], turn = cross(p - centre, normal);
      rows.row(i) << turn.x, turn.y, turn.z, normal.x, normal.y, normal.z;
      right(i) = dot(fixed_.points[k] - p, normal);
    }
    const Eigen::VectorXd x = rows.colPivHouseholderQr().solve(right);
    return moved(motion, {x(0), x(1), x(2), x(3), x(4), x(5), 0}, centre);
  }
  Motion planes_next(const Motion& motion) const {
    Eigen::Matrix<double, 6, 6> h = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
    for (std::size_t i = 0; i < moving_.points.size(); ++i) {
      const Point3 p = motion.apply(moving_.points[i]);
      const std::size_t k = partner(p);
      const Eigen::Matrix3d m =
          (flat(fixed_.normals[k]) + flat(motion.turn(moving_.normals[i]))).inverse() * 2 * plane_flatness;
      Eigen::Matrix<double, 3, 6> rows;
      rows << 0, p.z, -p.y, 1, 0, 0, -p.z, 0, p.x, 0, 1, 0, p.y, -p.x, 0, 0, 0, 1;
      const Point3 d = p - fixed_.points[k];
      h += rows.transpose() * m * rows;
      g += rows.transpose() * m * Eigen::Vector3d(d.x, d.y, d.z);
    }
    // A turn about the origin, as one about the centre that the others turn about.
    const Eigen::Matrix<double, 6, 1> x = h.ldlt().solve(-g);
    Point3 centre{0, 0, 0};
    for (const Point3& p : moving_.points)
      centre = centre + (1 / static_cast<double>(moving_.points.size())) * motion.apply(p);
    const Point3 moves = cross({x(0), x(1), x(2)}, centre);
    return moved(motion, {x(0), x(1), x(2), x(3) + moves.x, x(4) + moves.y, x(5) + moves.z, 0}, centre);
  }
  static Eigen::Matrix3d flat(const Point3& n) {
    const Eigen::Vector3d v(n.x, n.y, n.z);
    return Eigen::Matrix3d::Identity() - (1 - plane_flatness) * v * v.transpose();
  }

  const OrientedCloud& moving_;
  const OrientedCloud& fixed_;
};

TEST(IcpPairs, PrecisionIsTheInverseOfBothCovariances) {
  test::Random random(3);
  for (int i = 0; i < 60; ++i) {
    const auto direction = [&] {
      const Point3 v{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
      return (1 / length(v)) * v;
    };
    Link l;
    l.normal = direction();
    l.asking = i % 5 == 0 ? l.normal : i % 5 == 1 ? Point3{0, 0, 0} : direction();
    if (i % 10 == 9) l.normal = l.asking = {0, 0, 0};
    const Symmetric3 p = precision(l);
    Eigen::Matrix3d m, c = 2 * Eigen::Matrix3d::Identity();
    m << p.xx, p.xy, p.xz, p.xy, p.yy, p.yz, p.xz, p.yz, p.zz;
    for (const Point3& n : {l.normal, l.asking}) {
      const Eigen::Vector3d v(n.x, n.y, n.z);
      c -= (1 - plane_flatness) * v * v.transpose();
    }
    EXPECT_LT((m * c - 2 * plane_flatness * Eigen::Matrix3d::Identity()).norm(), 1e-14);
    Link other = l;  // exchanged and turned round: the same bits
    other.normal = -1.0 * l.asking, other.asking = l.normal;
    EXPECT_EQ(precision(other).xy, p.xy);
    EXPECT_EQ(precision(other).zz, p.zz);
  }
}

TEST(IcpPairs, WhereNormalsAgreeResidualsAreDistancesFromThePlane) {
  Link l;
  l.normal = l.asking = {0, 0.6, 0.8};
  l.moving = {1, 2, 3}, l.fixed = {1, 1, 1};
  const double across = 0.6 + 1.6, along2 = 5 - across * across;
  EXPECT_NEAR(residual(l, PairKind::planes), std::sqrt(across * across + plane_flatness * along2), 1e-12);
  EXPECT_NEAR(dot(pull(l, PairKind::planes), l.moving - l.fixed), std::pow(residual(l, PairKind::planes), 2), 1e-12);
}

// Planes hold a shift across them alone: what else the precisions draw at is left, as for icp-plane.
TEST(IcpStep, PlanesAreNotDrawnAlongThemselves) {
  Array<Link> links = random_links(60, 4, Motion{}, 0.3);
  for (Link& l : links) l.normal = l.asking = {0, 0, 1}, l.fixed.z = l.moving.z = 0, l.moving.z += 0.1;
  const PairInformation in = pair_information(links, PairKind::planes);
  const Twist step = planes_step(in, Freedom{}, 1e-9);
  EXPECT_NEAR(step[5], -0.1, 1e-12);
  for (const std::size_t k : {2u, 3u, 4u}) EXPECT_NEAR(step[k], 0, 1e-12);
  EXPECT_EQ(planes_step(in, Freedom{true, false, false, false, false, false, false}, 1e-9)[3], 0);
}

TEST(Icp, EveryStepIsThatOfThePlainLoop) {
  const Cloud fixed = body(300, 1), moving = body(250, 2);
  const Frame frame = choose_frame(fixed, moving, Pose{}, {}, {});
  OrientedCloud a = order_points(fixed, Pose{}, frame, {}, 0, {}), b = order_points(moving, Pose{}, frame, {}, 0, {});
  orient(a, {}), orient(b, {});
  for (const Objective objective : every_kind)
    for (const int steps : {1, 2, 5}) {
      MatchOptions o = by(objective);
      o.icp = every_pair();
      o.overlap = 1;
      o.max_iterations = steps;
      o.tolerance = 1e-14;
      const Matching m = icp(moving, fixed, Pose{}, o, {});
      const Pose plain = pose_of(PlainIcp(b, a).run(steps, objective), frame, Pose{});
      EXPECT_EQ(m.iterations, steps);
      for (std::size_t k = 0; k < 16; ++k) EXPECT_NEAR(m.pose.m[k], plain.m[k], 1e-9) << steps;
    }
}

// Besl and McKay 1992: every step lowers E, since pairs and motion are each the best for the other.
TEST(Icp, EFallsForPlainPointToPoint) {
  const Cloud fixed = body(1500, 1);
  MatchOptions o = by(Objective::icp_point);
  o.icp = every_pair();
  o.overlap = 1;
  const Matching m = icp(test::posed(body(1200, 2), test::turn_and_shift({1, 2, 1}, 15, {0, 0, 0}, {0.5, 1, 0})), fixed,
                         Pose{}, o, {});
  ASSERT_GT(m.history.size(), 5u);
  for (std::size_t i = 1; i < m.history.size(); ++i) EXPECT_LE(m.history[i].rms, m.history[i - 1].rms * (1 + 1e-12));
  EXPECT_TRUE(m.converged) << m.reason;
}

TEST(Icp, BodiesThatAreNoHeightField) {
  const Cloud fixed = body(9000, 1, 0.01), moving = body(8000, 2, 0.01);
  const Pose away = test::turn_and_shift({1, -2, 3}, 20, {1, 1, 1}, {1, -0.5, 0.8});
  for (const Objective objective : every_kind) {
    const Matching m = icp(test::posed(moving, away), fixed, Pose{}, by(objective), {});
    const auto error = off_identity(chained(m.pose, away), test::middle_of(moving));
    const double slack = objective == Objective::icp_point ? 5 : 1;  // sampling enters (1) fully
    EXPECT_TRUE(m.converged) << m.reason;
    EXPECT_LT(error.degrees, 0.02 * slack);
    EXPECT_LT(error.shift, 0.003 * slack);
    EXPECT_TRUE(m.weak_directions.empty());
    EXPECT_EQ(m.stable.size(), moving.points.size());
  }
}

Scene terrain(const std::string& variant, std::size_t n) {
  SceneOptions o;
  o.points_a = n, o.points_b = n + n / 4;
  o.noise_a = o.noise_b = 0.03;
  o.variant = variant;
  return make_scene("terrain", o, {});
}

TEST(Icp, RealChangeDoesNotPull) {
  const Scene s = terrain("", 8000);
  const Pose away = test::turn_and_shift({0.1, 0.1, 1}, 2, test::middle_of(s.b), {10, -15, 3});
  MatchOptions o = by(Objective::icp_plane);
  const auto error = [&] {
    return off_identity(chained(icp(test::posed(s.b, away), s.a, Pose{}, o, {}).pose, away), test::middle_of(s.b));
  };
  const auto robust = error();
  o.icp = every_pair();
  o.overlap = 1;
  const auto plain = error();
  EXPECT_LT(robust.degrees, 0.02);
  EXPECT_LT(robust.shift, 0.1);
  EXPECT_GT(plain.shift, 2 * robust.shift);
}

/// A corridor 20 long, 4 wide and high, open above; noise 2 mm. Its ends are an eighth of it.
Cloud corridor(std::size_t n, std::uint64_t seed) {
  test::Random random(seed);
  Cloud cloud;
  for (std::size_t i = 0; i < n; ++i) {
    const double along = random.uniform(-10, 10), across = random.uniform(-2, 2), up = random.uniform(0, 4);
    const double side = random.below(2) == 0 ? -1 : 1, noise = 0.002 * random.uniform(-1, 1);
    const double part = random.uniform();
    if (part < 0.3)
      cloud.points.push_back({along, across, noise});
    else if (part < 0.88)
      cloud.points.push_back({along, side * 2 + noise, up});
    else
      cloud.points.push_back({side * 10 + noise, across, up});
  }
  return cloud;
}

// What fits already is no reason to leave out the pairs that show the motion: here six times longer than the others.
TEST(Icp, TheLongPairsOfAFewAreHeard) {
  const Cloud fixed = corridor(20000, 1), moving = corridor(20000, 2);
  const Pose away = test::turn_and_shift({0, 0, 1}, 0.2, {0, 0, 0}, {0.6, 0, 0});
  const Matching m = icp(test::posed(moving, away), fixed, Pose{}, by(Objective::icp_plane), {});
  EXPECT_LT(off_identity(chained(m.pose, away), {0, 0, 0}).shift, 0.001);
}

TEST(Icp, HalfOfEachScanInCommon) {
  const Scene s = terrain("", 12000);
  Cloud a = s.a, b = s.b;
  std::erase_if(a.points, [&](const Point3& p) { return p.x > test::middle_of(s.a).x + 170; });
  std::erase_if(b.points, [&](const Point3& p) { return p.x < test::middle_of(s.a).x - 170; });
  a.attributes.clear(), b.attributes.clear();
  const Pose away = test::turn_and_shift({0, 0.1, 1}, 2, test::middle_of(b), {8, 10, 2});
  const Matching m = icp(test::posed(b, away), a, Pose{}, by(Objective::icp_plane), {});
  const auto error = off_identity(chained(m.pose, away), test::middle_of(b));
  EXPECT_LT(error.degrees, 0.03);
  EXPECT_LT(error.shift, 0.2);
}

TEST(Icp, SameBitsForAnyThreadsAndOrder) {
  const Cloud fixed = body(9000, 1, 0.01),
              moving = test::posed(body(10000, 2, 0.01), test::turn_and_shift({1, 1, 0}, 5, {0, 0, 0}, {0.3, 0, 0}));
  for (const auto& [objective, symmetric] : {std::pair{Objective::icp_plane, false},
                                             {Objective::icp_plane, true},
                                             {Objective::icp_gicp, true},
                                             {Objective::icp_point, false}}) {
    MatchOptions o = by(objective);
    o.icp.symmetric = symmetric;
    const auto run = [&](int threads, const Cloud& b, const Cloud& a) {
      Context context;
      context.threads = threads;
      return icp(b, a, Pose{}, o, context);
    };
    const Matching one = run(1, moving, fixed);
    for (const int threads : {2, 7}) {
      const Matching m = run(threads, moving, fixed);
      EXPECT_EQ(m.pose.m, one.pose.m);
      EXPECT_EQ(m.covariance, one.covariance);
    }
    EXPECT_EQ(run(2, test::shuffled(moving, 3), test::shuffled(fixed, 4)).pose.m, one.pose.m);
  }
}

// Both ways alike, so forward and back are inverse; pairs sought one way only prefer one scan.
TEST(Icp, SymmetricForwardAndBack) {
  const Cloud a = body(4000, 1, 0.05),
              b = test::posed(body(3000, 2, 0.05), test::turn_and_shift({1, 1, 0}, 4, {0, 0, 0}, {0.3, 0.1, 0}));
  const auto error = [&](bool symmetric) {
    MatchOptions o = by(Objective::icp_point);
    o.icp.symmetric = symmetric;
    return off_identity(chained(icp(a, b, Pose{}, o, {}).pose, icp(b, a, Pose{}, o, {}).pose), {0, 0, 0});
  };
  EXPECT_LT(error(true).degrees, 0.01);
  EXPECT_LT(error(true).shift, error(false).shift);
}

// Both planes of a pair count alike, so with pairs sought from both sides no scan is preferred.
TEST(Icp, PlaneToPlaneForwardAndBack) {
  const Cloud a = body(4000, 1, 0.05),
              b = test::posed(body(3000, 2, 0.05), test::turn_and_shift({1, 1, 0}, 4, {0, 0, 0}, {0.3, 0.1, 0}));
  MatchOptions o = by(Objective::icp_gicp);
  o.icp.symmetric = true;
  const auto error = off_identity(chained(icp(a, b, Pose{}, o, {}).pose, icp(b, a, Pose{}, o, {}).pose), {0, 0, 0});
  EXPECT_LT(error.degrees, 0.002);  // a step is a linear one
  EXPECT_LT(error.shift, 0.0004);
}

// Few points, one place, a line, a plane: an answer whose free motions are named, or a refusal, and no number that is
// none.
TEST(Icp, PlaneToPlaneOfDegenerateScans) {
  test::Random random(7);
  for (const std::size_t n : {3u, 20u, 300u})
    for (const int dimensions : {0, 1, 2}) {
      Cloud cloud;
      for (std::size_t i = 0; i < n; ++i) {
        const double x = random.uniform(0, 1), y = random.uniform(0, 1);
        cloud.points.push_back({dimensions > 0 ? x : 0, dimensions > 1 ? y : 0, 0});
      }
      for (const bool any : {false, true}) {
        MatchOptions o = by(Objective::icp_gicp);
        if (any) o.icp = every_pair(), o.overlap = 1;
        try {
          const Matching m = icp(test::shifted(cloud, {0, 0, 1e-3}), cloud, Pose{}, o, {});
          for (const double v : m.pose.m) EXPECT_TRUE(std::isfinite(v)) << n << " " << dimensions;
          EXPECT_GE(m.weak_directions.size(), 3u);
        } catch (const Error&) {
          continue;  // too few pairs pass the rejections
        }
      }
    }
}

// Point to point creeps along a slope [Pottmann2006]; accelerated, it arrives.
TEST(Icp, PointToPointArrives) {
  const Scene s = terrain("", 6000);
  const Pose away = test::turn_and_shift({0.1, 0.1, 1}, 1, test::middle_of(s.b), {6, -8, 2});
  MatchOptions o = by(Objective::icp_point);
  o.max_iterations = 500;
  const Matching m = icp(test::posed(s.b, away), s.a, Pose{}, o, {});
  EXPECT_TRUE(m.converged) << m.reason;
  EXPECT_LT(m.iterations, 150);
}

TEST(Icp, FreedomAndScale) {
  const Cloud fixed = body(3000, 1);
  Cloud moving = body(3000, 2);
  for (Point3& p : moving.points) p = {1.02 * p.x + 0.2, 1.02 * p.y - 0.1, 1.02 * p.z};
  for (const Objective objective : every_kind) {
    MatchOptions o = by(objective);
    o.freedom.scale = true;
    EXPECT_NEAR(icp(moving, fixed, Pose{}, o, {}).scale * 1.02, 1, 2e-3);
    o.freedom = {true, true, true, false, false, false, false};
    const Matching shifts = icp(moving, fixed, Pose{}, o, {});
    EXPECT_EQ(off_identity(shifts.pose, {0, 0, 0}).degrees, 0);
    EXPECT_NEAR(shifts.pose.m[3], -0.2, 0.05);
    o.freedom.shift_x = false;
    EXPECT_EQ(icp(moving, fixed, Pose{}, o, {}).pose.m[3], 0);
  }
}

TEST(Icp, WhatNothingHoldsIsNamedAndStays) {
  test::Random random(5);
  const auto flat = [&](const Point2&) { return 0.002 * random.uniform(-1, 1); };
  const Cloud a = test::cloud_over(test::framed_square(4000, 1), flat);
  const Cloud b = test::shifted(test::cloud_over(test::framed_square(3000, 2), flat), {0, 0, 0.03});
  for (const Objective objective : {Objective::icp_plane, Objective::icp_gicp}) {
    const Matching m = icp(b, a, Pose{}, by(objective), {});
    EXPECT_EQ(m.weak_directions.size(), 3u);
    EXPECT_NEAR(m.pose.m[3], 0, 0.01);
    EXPECT_NEAR(m.pose.m[7], 0, 0.01);
    EXPECT_NEAR(m.pose.m[11], -0.03, 0.002);
  }
}

TEST(Icp, LargeCoordinates) {
  const Point3 far{5.1e6, 4.4e6, 300};
  const Cloud fixed = body(3000, 1),
              moving = test::posed(body(3000, 2), test::turn_and_shift({1, 1, 0}, 4, {0, 0, 0}, {0.3, 0.1, 0}));
  const Matching near = icp(moving, fixed, Pose{}, by(Objective::icp_plane), {}),
                 there =
                     icp(test::shifted(moving, far), test::shifted(fixed, far), Pose{}, by(Objective::icp_plane), {});
  for (const Point3& p : {Point3{0, 0, 0}, Point3{10, -5, 3}}) {
    const Point3 q = there.pose.apply(p + far);
    EXPECT_LT(length(q - far - near.pose.apply(p)), 1e-7);
  }
}

TEST(Icp, Refusals) {
  const Cloud fixed = body(400, 1), moving = body(300, 2);
  EXPECT_THROW((void)icp(test::shifted(moving, {500, 0, 0}), fixed, Pose{}, by(Objective::icp_plane), {}),
               OverlapError);
  EXPECT_THROW((void)icp(moving, fixed, Pose{}, by(Objective::measure), {}), UsageError);
  MatchOptions o = by(Objective::icp_plane);
  o.icp.reject_distance = -1;
  EXPECT_THROW((void)icp(moving, fixed, Pose{}, o, {}), UsageError);
  o = by(Objective::icp_plane), o.icp.reject_normal = 91;
  EXPECT_THROW((void)icp(moving, fixed, Pose{}, o, {}), UsageError);
  o = by(Objective::icp_plane), o.icp.reject_distance = 1e-9, o.icp.reject_distance_absolute = true;
  EXPECT_THROW((void)icp(moving, fixed, Pose{}, o, {}), OverlapError);
  o = by(Objective::measure), o.icp.symmetric = true;
  EXPECT_THROW((void)match(moving, fixed, o, {}), UsageError);
}

TEST(Icp, StopsWhenItMay) {
  MatchOptions o = by(Objective::icp_point);
  o.max_iterations = 1;
  const Matching m = icp(test::shifted(body(500, 2), {1, 0, 0}), body(500, 1), Pose{}, o, {});
  EXPECT_FALSE(m.converged);
  EXPECT_NE(m.reason.find("@max-iterations"), std::string::npos);
}

}  // namespace
}  // namespace isopach
