// Pair: the same as its stages one by one, for either scan.
#include "isopach/overlay/pair.hpp"

#include <gtest/gtest.h>

#include "isopach/delaunay/triangulate.hpp"
#include "isopach/overlay/interpolate.hpp"
#include "isopach/overlay/localise.hpp"
#include "tests/support/clouds.hpp"

namespace isopach::test {
namespace {

Pose lifted() {
  Pose pose;
  pose.m[11] = 0.5;
  return pose;
}

TEST(Pair, IsWhatItsStagesGive) {
  const auto slope = [](const Point2& p) { return p.x - 2 * p.y; };
  const Cloud a = cloud_over(uniform(300, 1), slope), b = cloud_over(uniform(200, 2), slope);
  Pair pair = project_pair(a, b, lifted(), {}, {});
  triangulate(pair, {});
  const Frame frame = choose_frame(a, b, lifted(), {}, {});
  EXPECT_EQ(pair.frame.origin, frame.origin);
  const HeightField field_a = project(a, Pose{}, frame, {}, {}), field_b = project(b, lifted(), frame, {}, {});
  EXPECT_EQ(pair.scan[0].field.z, field_a.z);
  EXPECT_EQ(pair.scan[1].field.z, field_b.z);
  for (const Scan& s : pair.scan) {
    const Triangulation t = triangulate(s.field.xy, frame.curve, {});
    ASSERT_EQ(s.t.real, t.real);
    for (Index i = 0; i < t.real; ++i) ASSERT_EQ(s.t.triangles[i].v, t.triangles[i].v);
  }
}

TEST(Pair, EitherMeshHasTheHeightsOfTheOther) {
  const auto slope = [](const Point2& p) { return p.x - 2 * p.y; };
  const Cloud a = cloud_over(uniform(300, 1), slope), b = cloud_over(uniform(200, 2), slope);
  Pair pair = project_pair(a, b, lifted(), {}, {});
  triangulate(pair, {});
  for_both([&](std::size_t k) {
    const Scan &own = pair.scan[k], &other = pair.scan[1 - k];
    pair.seen[k].at = localise_in_order(own.field.xy, other.t, other.field.xy, {});
    pair.seen[k].z = interpolate(pair.seen[k].at, own.field.xy, other.t, other.field.xy, other.field.z, {});
  });
  for (std::size_t k = 0; k < 2; ++k) {
    const OverlayMesh mesh = pair.mesh(k);
    const double lift = k == 0 ? 0.5 : -0.5;  // B was moved up
    std::size_t inside = 0;
    for (std::size_t i = 0; i < mesh.xy.size(); ++i) {
      if (mesh.in_other[i].kind != Location::Kind::triangle) continue;
      ++inside;
      EXPECT_NEAR(mesh.other_z[i] - mesh.z[i], lift, 1e-12);
    }
    EXPECT_GT(inside, mesh.xy.size() / 2);
  }
}

}  // namespace
}  // namespace isopach::test
