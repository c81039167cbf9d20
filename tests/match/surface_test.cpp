// The surface of a scan as the search sees it: what noise makes of its slopes, and how rough it is.
#include "isopach/match/surface/surface.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "isopach/base/random.hpp"
#include "tests/match/square.hpp"

namespace isopach {
namespace {

using test::square;

/// Of every node, height by height: its slope is read from how steep it is on two planes.
Array<SlopeNoise> noise_by_unit_heights(std::size_t n, std::uint64_t seed) {
  Array<SlopeNoise> noise(n);
  std::fill(noise.begin(), noise.end(), SlopeNoise{});
  for (std::size_t j = 0; j < n; ++j) {
    const auto steep = [&](double x, double y) {
      return steepness(
          square(n, seed, [&](const Point2& p, std::size_t i) { return x * p.x + y * p.y + (i == j ? 1.0 : 0.0); }));
    };
    const Array<double> flat = steep(0, 0), along_x = steep(1, 0), along_y = steep(0, 1);
    for (std::size_t i = 0; i < n; ++i) {
      const double square0 = flat[i] * flat[i];
      const double x = (along_x[i] * along_x[i] - square0 - 1) / 2, y = (along_y[i] * along_y[i] - square0 - 1) / 2;
      noise[i].xx += x * x, noise[i].xy += x * y, noise[i].yy += y * y;
    }
  }
  return noise;
}

TEST(Surface, NoiseOfSlopes) {
  for (const std::size_t n : {3u, 4u, 9u, 40u}) {
    const Array<SlopeNoise> found = slope_noise(square(n, 11 + n, [](const Point2&, std::size_t) { return 0.0; }));
    const Array<SlopeNoise> expected = noise_by_unit_heights(n, 11 + n);
    for (std::size_t i = 0; i < n; ++i) {
      const double size = expected[i].xx + expected[i].yy;
      EXPECT_NEAR(found[i].xx, expected[i].xx, 1e-7 * size) << n << ' ' << i;
      EXPECT_NEAR(found[i].xy, expected[i].xy, 1e-7 * size) << n << ' ' << i;
      EXPECT_NEAR(found[i].yy, expected[i].yy, 1e-7 * size) << n << ' ' << i;
    }
  }
}

TEST(Surface, RoughnessIsThatOfTheNoiseAndNotOfTheSlope) {
  const RandomStream random(4, 1);
  const auto noisy = [&](const Point2& p, std::size_t i) { return 30 * p.x - 7 * p.y + 0.2 * random.normal(i); };
  const double found = roughness(square(20000, 1, noisy));
  EXPECT_GT(found, 0.2);
  EXPECT_LT(found, 0.24);  // the mean of six neighbours has noise too
  EXPECT_LT(roughness(square(2000, 1, [](const Point2& p, std::size_t) { return 30 * p.x - 7 * p.y; })), 1e-12);
}

// A curved surface between its nodes: facets lie inside it, their rise brings them up to it; not quite, as slopes
// around unevenly spread nodes are those of their surroundings.
TEST(Surface, FacetsRiseToWhatIsCurved) {
  const auto bowl = [](const Point2& p, std::size_t) { return 3 * p.x * p.x + p.x * p.y - 2 * p.y * p.y + p.x; };
  const MatchSurface s = square(5000, 3, bowl);
  double off = 0, off_flat = 0, count = 0;
  for (Index t = 0; t < s.t.real; ++t) {
    const auto& v = s.t.triangles[t].v;
    const Facet& f = s.facets[t];
    Point2 middle{0, 0};
    bool is_inner = f.exists();
    for (const Index node : v) {
      const Point2& p = s.xy[node];
      middle = {middle.x + p.x / 3, middle.y + p.y / 3};
      is_inner = is_inner && p.x > 0.1 && p.x < 0.9 && p.y > 0.1 && p.y < 0.9;
      if (f.exists()) {  // at the corners it is the node itself
        EXPECT_NEAR(f.height(p.x, p.y), s.z[node], 1e-6);
      }
    }
    if (!is_inner) continue;
    Facet flat = f;
    flat.rise = 0;
    off += bowl(middle, 0) - f.height(middle.x, middle.y);
    off_flat += std::fabs(bowl(middle, 0) - flat.height(middle.x, middle.y));
    ++count;
  }
  ASSERT_GT(count, 1000);
  EXPECT_LT(std::fabs(off), 0.15 * off_flat);
}

}  // namespace
}  // namespace isopach
