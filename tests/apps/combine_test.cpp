// The combine application on the scene whose truth is known (tests/simulate/face_and_jaw_test.cpp).
#include "isopach/apps/combine.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <numbers>

#include "isopach/apps/motions.hpp"
#include "isopach/distance/vectors.hpp"
#include "isopach/simulate/face_and_jaw.hpp"
#include "tests/apps/held_object.hpp"
#include "tests/support/clouds.hpp"

namespace isopach {
namespace {

const FaceAndJaw& scene() {
  static const FaceAndJaw made = [] {
    FaceAndJawOptions o;
    o.points = 14000;
    return make_face_and_jaw(o, 2);
  }();
  return made;
}

const Combination& plain() {
  static const Combination c = combine(scene().face, scene().jaw, scene().reference, {}, {});
  return c;
}

/// Turn (degrees) and way of a place of the jaw between the found pose and the true one.
std::pair<double, double> error_of(const Combination& c, const FaceAndJaw& s) {
  const Pose off = composed(c.face_jaw, inverted(s.face_jaw));
  return {length(rotation_vector(off)) * 180 / std::numbers::pi,
          length(c.jaw_middle - inverted(off).apply(c.jaw_middle))};
}

TEST(Combine, PutsTheJawInItsPlace) {
  const Combination& c = plain();
  const auto [turn, shift] = error_of(c, scene());
  EXPECT_LT(turn, 0.1);
  EXPECT_LT(shift, 0.1);
  EXPECT_EQ(c.unit, "mm");
  EXPECT_GT(c.face.share, 0.8);
  EXPECT_NEAR(c.face.covered, scene().face_share, 0.05);
  EXPECT_NEAR(c.jaw.covered, scene().jaw_share, 0.05);
  // What it says of itself: neither a promise that is not kept nor a shrug.
  EXPECT_LT(turn, 4 * c.sigma_angle * 180 / std::numbers::pi);
  EXPECT_LT(shift, 4 * c.sigma_middle);
  EXPECT_LT(c.sigma_middle, 0.2);
  EXPECT_GE(c.sigma_farthest, c.sigma_middle);
}

TEST(Combine, ModelHoldsEveryPointWithItsPart) {
  const Combination& c = plain();
  const std::size_t faces = scene().face.points.size();
  ASSERT_EQ(c.points.size(), faces + scene().jaw.points.size());
  EXPECT_EQ(c.points[17], scene().face.points[17]);
  EXPECT_EQ(c.points[faces + 5], c.face_jaw.apply(scene().jaw.points[5]));
  std::array<std::size_t, 4> counts{};
  for (const CombinedPart part : c.part) ++counts[static_cast<std::size_t>(part)];
  EXPECT_EQ(counts, c.counts);
  EXPECT_GT(counts[2], 1000u);
  EXPECT_GT(counts[3], 1000u);
}

/// Oracle of the chain: many pairs of poses drawn from the two covariances spread the jaw's middle as sigma_middle
/// says.
TEST(Combine, ChainOfCovariancesIsWhatDrawsGive) {
  Combination c = plain();
  test::Random random(5);
  const auto normal = [&] {
    double sum = 0;
    for (int i = 0; i < 12; ++i) sum += random.uniform(-0.5, 0.5);
    return sum;
  };
  // Cholesky factors by hand: 6×6, lower.
  const auto factor = [](const std::array<double, 36>& a) {
    std::array<double, 36> l{};
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t j = 0; j <= i; ++j) {
        double s = a[6 * i + j];
        for (std::size_t k = 0; k < j; ++k) s -= l[6 * i + k] * l[6 * j + k];
        l[6 * i + j] = i == j ? std::sqrt(std::max(0.0, s)) : s / l[6 * j + j];
      }
    return l;
  };
  const auto draw = [&](const std::array<double, 36>& l, const Point3& centre, const Pose& pose) {
    std::array<double, 6> z{}, t{};
    for (double& v : z) v = normal();
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t j = 0; j <= i; ++j) t[i] += l[6 * i + j] * z[j];
    const Motion step = moved(Motion{}, {t[0], t[1], t[2], t[3], t[4], t[5], 0}, centre);
    Pose p;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) p.m[4 * i + j] = step.rotation[3 * i + j];
    p.m[3] = step.shift.x, p.m[7] = step.shift.y, p.m[11] = step.shift.z;
    return composed(p, pose);
  };
  const auto lf = factor(c.face.covariance), lj = factor(c.jaw.covariance);
  const Point3 middle = inverted(c.face_jaw).apply(c.jaw_middle);
  double squares = 0;
  constexpr int draws = 4000;
  for (int i = 0; i < draws; ++i) {
    const Pose chained = composed(draw(lf, c.face.centre, c.face.pose), inverted(draw(lj, c.jaw.centre, c.jaw.pose)));
    squares += squared_length(chained.apply(middle) - c.jaw_middle);
  }
  EXPECT_NEAR(std::sqrt(squares / draws) / c.sigma_middle, 1, 0.06);
}

TEST(Combine, SameBitsForAnyThreadsAndOrder) {
  Context one;
  one.threads = 1;
  Context three;
  three.threads = 3;
  const Combination a = combine(scene().face, scene().jaw, scene().reference, {}, one);
  const Combination b = combine(test::shuffled(scene().face, 1), test::shuffled(scene().jaw, 2),
                                test::shuffled(scene().reference, 3), {}, three);
  EXPECT_EQ(a.face_jaw.m, b.face_jaw.m);
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.counts, b.counts);
}

TEST(Combine, StartsAreUsed) {
  CombineOptions o;
  o.start_face = scene().face_reference;
  o.start_jaw = scene().jaw_reference;
  const Combination c = combine(scene().face, scene().jaw, scene().reference, o, {});
  EXPECT_LT(error_of(c, scene()).second, 0.1);
  // A start in the wrong place is not corrected by a search.
  o.start_jaw->m[3] += 500;
  EXPECT_THROW((void)combine(scene().face, scene().jaw, scene().reference, o, {}), OverlapError);
}

/// Face and jaw with `points` on the object, and a scan of the object alone with `reference`; starts at the truth.
Combination combine_held(std::size_t points, std::size_t reference, std::uint64_t seed, Pose& truth) {
  test::HeldObjectScanner scanner(seed);
  const Pose in_face = test::some_pose(0.3, 1, {40, -20, 7}), in_jaw = test::some_pose(-0.5, 0.4, {-30, 9, 55});
  const Cloud face = test::posed(scanner.held(points, 0.05, 0.1), in_face);
  const Cloud jaw = test::posed(scanner.held(points, 0.05, 0.15), in_jaw);
  CombineOptions o;
  o.start_face = in_face, o.start_jaw = in_jaw;
  truth = composed(in_face, inverted(in_jaw));
  return combine(face, jaw, scanner.alone(reference, 0.05), o, {});
}

/// Error of the pose (turn, then shift at the object) and its chi², of four draws.
struct HeldErrors {
  double turn = 0, shift = 0, chi2 = 0;
};
HeldErrors held_errors(std::size_t reference) {
  HeldErrors sum;
  constexpr int seeds = 4;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    Pose truth;
    const Combination c = combine_held(1200, reference, seed, truth);
    const Pose off = composed(c.face_jaw, inverted(truth));
    const Point3 w = rotation_vector(off), s = off.apply(c.centre) - c.centre;
    Eigen::Matrix<double, 6, 1> e;
    e << w.x, w.y, w.z, s.x, s.y, s.z;
    sum.turn += squared_length(w) / seeds;
    sum.shift += squared_length(s) / seeds;
    sum.chi2 += e.dot(Eigen::Map<const Eigen::Matrix<double, 6, 6>>(c.covariance.data()).ldlt().solve(e));
  }
  return {std::sqrt(sum.turn) * 180 / std::numbers::pi, std::sqrt(sum.shift), sum.chi2};
}
const HeldErrors& with_dense_reference() {
  static const HeldErrors errors = held_errors(30000);
  return errors;
}

/// Points put on planes of 16 neighbours lie off a hill by curvature × radius² / 4: a reference of ten times the
/// density of the scans does not, and what was to cancel became an error that grew with the density.
TEST(Combine, DenserReferenceMakesNoErrorGrow) {
  const HeldErrors sparse = held_errors(1500), &dense = with_dense_reference();
  EXPECT_LT(dense.turn, 1.2 * sparse.turn);
  EXPECT_LT(dense.shift, 1.2 * sparse.shift);
  EXPECT_LT(dense.turn, 0.07);
  EXPECT_LT(dense.shift, 0.025);
}

/// Chi² with 4 · 6 freedoms: beyond 51 one time in a thousand, below 8 as seldom. Distances of 30 000 points of the
/// reference counted as independent, though 1200 points of the scan made them.
TEST(Combine, StatedUncertaintyCoversWithADenseReference) {
  EXPECT_LT(with_dense_reference().chi2, 51);
  EXPECT_GT(with_dense_reference().chi2, 8);
}

/// Exit 5 of what the scans cannot tell: a plain plate slides, and what is its own half turn fits twice.
TEST(Combine, RefusesAShapeThatDoesNotSayWhereItIs) {
  const auto refused = [](const test::Surface& shape, const char* word) {
    test::HeldObjectScanner scanner(9);
    const Cloud face = test::posed(scanner.held(2000, 0.05, 0.05, shape), test::some_pose(0.2, 0.5, {10, 20, 30}));
    const Cloud jaw = test::posed(scanner.held(2000, 0.05, 0.05, shape), test::some_pose(-0.4, 1.5, {-10, 5, 0}));
    try {
      (void)combine(face, jaw, scanner.alone(2000, 0.05, shape), {}, {});
      ADD_FAILURE() << word;
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ExitCode::not_converged) << e.what();
      EXPECT_NE(std::string(e.what()).find(word), std::string::npos) << e.what();
    }
  };
  refused([](double, double) { return 0.0; }, "not determined");
  refused([](double x, double y) { return 0.5 * (test::held_object(x, y) + test::held_object(-x, -y)); },
          "fits as well elsewhere");
}

TEST(Combine, RefusesWhatIsNotThere) {
  const auto fails = [](const Cloud& face, const Cloud& jaw, const Cloud& reference, const CombineOptions& o,
                        const char* word) {
    try {
      (void)combine(face, jaw, reference, o, {});
      ADD_FAILURE() << word;
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find(word), std::string::npos) << e.what();
    }
  };
  FaceAndJawOptions without;
  without.points = 14000, without.held = false;
  const FaceAndJaw forgotten = make_face_and_jaw(without, 2);
  fails(scene().face, forgotten.jaw, scene().reference, {}, "jaw.ply: the reference object was not found");
  fails(forgotten.face, scene().jaw, scene().reference, {}, "face.ply: the reference object was not found");
  CombineOptions o;
  o.least_share = 0;
  fails(scene().face, scene().jaw, scene().reference, o, "@least-share");
  Cloud few = scene().reference;
  few.points.resize(20);
  o = {}, o.start_face = scene().face_reference, o.start_jaw = scene().jaw_reference;
  fails(scene().face, scene().jaw, few, o, "too few");
  Cloud metres = scene().jaw;
  metres.unit = "m";
  fails(scene().face, metres, scene().reference, {}, "@unit");
}

}  // namespace
}  // namespace isopach
