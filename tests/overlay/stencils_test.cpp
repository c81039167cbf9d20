// Stencils say what interpolate does: same heights, weights that are shares.
#include "isopach/overlay/stencils.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "isopach/delaunay/triangulate.hpp"
#include "isopach/overlay/interpolate.hpp"
#include "isopach/overlay/localise.hpp"
#include "tests/support/mesh.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

class StencilsOf : public testing::TestWithParam<Family> {};

TEST_P(StencilsOf, GiveTheInterpolatedHeights) {
  const Points nodes = GetParam().make(300, 411);
  Box2 box;
  for (const Point2& p : nodes) box.add(p);
  Random random(412);
  Points asked(nodes.begin(), nodes.begin() + static_cast<std::ptrdiff_t>(nodes.size() / 2));
  for (int i = 0; i < 300; ++i) {
    asked.push_back({box.min.x + (box.max.x - box.min.x) * random.uniform(-0.1, 1.1),
                     box.min.y + (box.max.y - box.min.y) * random.uniform(-0.1, 1.1)});
    const Point2 &p = nodes[random.below(nodes.size())], &q = nodes[random.below(nodes.size())];
    asked.push_back({(p.x + q.x) / 2, (p.y + q.y) / 2});
  }
  const SortedTriangulation mesh = triangulate_unsorted(nodes, {}), points = triangulate_unsorted(asked, {});
  const Locations where =
      localise(points.xy, spanning_tree(points.triangulation, points.xy, {}), mesh.triangulation, mesh.xy, {});
  std::vector<double> z;
  for (std::size_t i = 0; i < mesh.xy.size(); ++i) z.push_back(random.uniform(-1, 1));
  const Array<double> expected = interpolate(where, points.xy, mesh.triangulation, mesh.xy, z, {});
  const Array<Stencil> found = stencils(where, points.xy, mesh.triangulation, mesh.xy, {});
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_NEAR(found[i].apply(z), expected[i], 1e-8) << i;
    EXPECT_NEAR(found[i].weight[0] + found[i].weight[1] + found[i].weight[2], 1, 1e-15);
    for (const double w : found[i].weight) EXPECT_GE(w, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(All, StencilsOf, testing::ValuesIn(families()),
                         [](const auto& family) { return family.param.name; });

}  // namespace
}  // namespace isopach::test
