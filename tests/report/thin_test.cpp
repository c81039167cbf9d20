// The surface of a page: what it says of its own error is so, and what is read back from its numbers is what was meant.
#include <gtest/gtest.h>
#include <cmath>
#include <set>

#include "isopach/compare/compare.hpp"
#include "isopach/report/view/block.hpp"
#include "isopach/report/view/thin.hpp"
#include "isopach/report/view/view.hpp"

namespace isopach {
namespace {

/// Two scans of a hill, the second with a mound, at coordinates of a national grid.
Comparison hill(std::size_t points, const CompareOptions& options = {}) {
  const auto scan = [&](std::uint64_t seed, double mound) {
    Cloud cloud;
    cloud.unit = "m";
    std::uint64_t state = seed;
    const auto uniform = [&] {
      state = state * 6364136223846793005ull + 1442695040888963407ull;
      return static_cast<double>(state >> 11) * 0x1p-53;
    };
    for (std::size_t i = 0; i < points; ++i) {
      const double x = 100 * uniform(), y = 100 * uniform();
      const double r2 = (x - 60) * (x - 60) + (y - 40) * (y - 40);
      cloud.points.push_back(
          {512300 + x, 5405100 + y,
           300 + 5 * std::sin(x / 15) * std::cos(y / 20) + mound * std::exp(-r2 / 80) + 0.02 * (uniform() - 0.5)});
    }
    return cloud;
  };
  return compare(scan(1, 0), scan(2, 3), options, {});
}

struct Place {
  Point2 at;
  double z, d;
};

/// Nodes of the cells in the domain, and corners of their pieces.
std::vector<Place> places(const Comparison& c) {
  std::vector<Place> out;
  std::set<Index> seen;
  for (Index t = 0; t < c.cells.triangulation.real; ++t)
    if (c.cells.in_domain[t])
      for (const Index v : c.cells.triangulation.triangles[t].v)
        if (seen.insert(v).second) out.push_back({c.cells.xy[v], c.cells.z1[v], c.cells.d(v)});
  return out;
}

/// The value of the thinned surface by trying every triangle, the nearest one where none holds the place.
double d_at(const ThinSurface& s, const Point2& p) {
  double best = -INFINITY, value = NAN;
  for (const auto& v : s.triangles) {
    const auto x = [&](int k) { return s.x.at(v[static_cast<std::size_t>(k)]); };
    const auto y = [&](int k) { return s.y.at(v[static_cast<std::size_t>(k)]); };
    const double all = (x(1) - x(0)) * (y(2) - y(0)) - (x(2) - x(0)) * (y(1) - y(0));
    const double b = ((p.x - x(0)) * (y(2) - y(0)) - (x(2) - x(0)) * (p.y - y(0))) / all;
    const double g = ((x(1) - x(0)) * (p.y - y(0)) - (p.x - x(0)) * (y(1) - y(0))) / all;
    const double inside = std::min({1 - b - g, b, g});
    if (inside <= best) continue;
    best = inside;
    value = (1 - b - g) * s.d.at(v[0]) + b * s.d.at(v[1]) + g * s.d.at(v[2]);
  }
  return best > -1e-6 ? value : NAN;
}

TEST(ThinSurface, ErrorIsTheLargestOfAllNodes) {
  const Comparison c = hill(3000);
  const ThinSurface s = thin_surface(c, 900, {});
  ASSERT_LE(s.nodes(), 900u);
  ASSERT_FALSE(s.is_whole);
  double largest = 0;
  std::size_t outside = 0;
  for (const Place& p : places(c)) {
    const double d = d_at(s, p.at);
    if (std::isnan(d))
      ++outside;
    else
      largest = std::max(largest, std::fabs(d - p.d));
  }
  EXPECT_LE(largest, s.d_error * (1 + 1e-6) + 1e-9);
  EXPECT_GE(largest, 0.5 * s.d_error);  // those outside of the triangles kept are in the bound, too
  EXPECT_LT(outside, places(c).size() / 20);
  EXPECT_LE(s.d_rms, s.d_error);
  EXPECT_LT(s.d_error, 0.1);
  EXPECT_NEAR(s.above, c.measures.volume.above, s.d_error * c.domain_area);
  EXPECT_NEAR(s.area, c.domain_area, 0.01 * c.domain_area);
}

TEST(ThinSurface, FewNodesAreKeptAsTheyAre) {
  const Comparison c = hill(1000);
  const ThinSurface s = thin_surface(c, 100000, {});
  EXPECT_TRUE(s.is_whole);
  EXPECT_EQ(s.nodes(), s.nodes_of_cells);
  EXPECT_NEAR(s.area, c.domain_area, 1e-6 * c.domain_area);
  EXPECT_NEAR(s.above, c.measures.volume.above, 1e-4 * c.measures.volume.above);
  EXPECT_NEAR(s.below, c.measures.volume.below, s.d_error * c.domain_area);
  EXPECT_LE(s.d_error, s.d.step);
}

TEST(ThinSurface, TheLargestDifferencesAreKept) {
  const Comparison c = hill(3000);
  const ThinSurface s = thin_surface(c, 400, {});
  double largest = 0, kept = 0;
  for (const Place& p : places(c)) largest = std::max(largest, p.d);
  for (std::size_t i = 0; i < s.nodes(); ++i) kept = std::max(kept, s.d.at(i));
  EXPECT_NEAR(kept, largest, s.d.step);
}

TEST(ThinSurface, TheLargestDifferenceOfEveryChangeIsKept) {
  CompareOptions options;
  options.changes.asked = true;
  options.changes.height = 0.012;  // so that noise makes many
  options.changes.min_area = 0;
  const Comparison c = hill(3000, options);
  ASSERT_TRUE(c.changes);
  ASSERT_GT(c.changes->list.size(), 100u);
  constexpr std::size_t most = 600;
  const ThinSurface s = thin_surface(c, most, {});
  for (std::size_t k = 0; k < most / 5; ++k) {
    const Change& change = c.changes->list[k];
    bool found = false;
    for (std::size_t i = 0; i < s.nodes() && !found; ++i)
      found = std::hypot(s.x.at(i) - change.largest_at.x, s.y.at(i) - change.largest_at.y) < 2 * s.x.step &&
              std::fabs(s.d.at(i) - change.largest_d()) <= s.d.step;
    EXPECT_TRUE(found) << k;
  }
}

TEST(ThinSurface, UnchangedGroundStaysExactlySo) {
  Comparison c = hill(1000);
  for (std::size_t i = 0; i < c.cells.xy.size(); ++i)
    if (c.cells.xy[i].x < 0) c.cells.z2[i] = c.cells.z1[i];
  const ThinSurface s = thin_surface(c, 300, {});
  std::size_t zeros = 0;
  for (std::size_t i = 0; i < s.nodes(); ++i) zeros += s.d.at(i) == 0 ? 1 : 0;
  EXPECT_GT(zeros, 10u);
}

TEST(ThinSurface, TheSameForAnyNumberOfThreads) {
  const Comparison c = hill(3000);
  Context one, four;
  one.threads = 1, four.threads = 4;
  EXPECT_EQ(view_block(thin_surface(c, 500, one)), view_block(thin_surface(c, 500, four)));
}

TEST(ThinSurface, NothingComparedIsNoView) {
  Comparison c = hill(300);
  std::fill(c.cells.in_domain.begin(), c.cells.in_domain.end(), static_cast<unsigned char>(0));
  c.cells.pieces.clear();
  EXPECT_EQ(thin_surface(c, 100, {}).triangles.size(), 0u);
  EXPECT_EQ(view_of({{"", &c}}, {}, {}, {}, {}), "");
}

TEST(View, MarkupInNamesIsText) {
  Comparison c = hill(300);
  c.a.path = "</script><script>alert(1)</script>";
  c.a.crs = "<!--<script>";
  const std::string view = view_of({{"", &c}}, {}, {}, {}, {});
  const std::string data = view.substr(0, view.find("</script>"));
  EXPECT_NE(data.find("\\u003c/script>\\u003cscript>alert(1)"), std::string::npos);
  EXPECT_EQ(data.find('<', 1), std::string::npos);
}

TEST(View, OneScriptIsAllowed) {
  const std::string policy = view_policy();
  EXPECT_EQ(policy.substr(0, 19), "script-src 'sha256-");
  EXPECT_EQ(policy.size(), 19u + 44u + 1u);
}

}  // namespace
}  // namespace isopach
