// The numbers of real scans that a comparison must come back with. Areas are those of the intersection of both
// footprints, as the exact overlay has them; other programs, which drop cells that hang over a border, have some less.
#include <gtest/gtest.h>

#include <cmath>

#include "isopach/compare/compare.hpp"
#include "isopach/io/read.hpp"
#include "tests/support/shared_data.hpp"

namespace isopach::test {
namespace {

Cloud read(const std::filesystem::path& path) { return read_cloud(path.string(), {}, {}); }

// Two flight strips over the same bare ground: nothing has changed.
TEST(RealData, SantaCruzStripsDifferByNoiseOnly) {
  ISOPACH_SHARED_OR_SKIP(folder, "santacruz");
  CompareOptions options;
  options.project.duplicates = DuplicatePolicy::mean;
  options.border = BorderRule::hull;  // the numbers to come back with were made over the hulls
  const Comparison c =
      compare(read(folder / "blanca_strip8706_120m.las"), read(folder / "blanca_strip8707_120m.las"), options, {});
  EXPECT_EQ(c.a.points, 77522u);
  EXPECT_EQ(c.b.points, 167868u);
  EXPECT_NEAR(c.domain_area, 13923.7, 0.001 * 13923.7);
  EXPECT_NEAR(c.measures.rho, 0.06946, 0.001 * 0.06946);
  EXPECT_NEAR(c.measures.difference.mean, -0.0023, 0.0005);
}

// The crater of Mount St. Helens within a week: the dome rises.
TEST(RealData, SaintHelensDomeRisesWithinAWeek) {
  ISOPACH_SHARED_OR_SKIP(folder, "msh-dome");
  CompareOptions options;
  options.border = BorderRule::hull;  // as above
  const Comparison c = compare(read(folder / "msh_2004-10-04.xyz"), read(folder / "msh_2004-10-11.xyz"), options, {});
  EXPECT_NEAR(c.domain_area, 209648, 0.005 * 209648);
  EXPECT_NEAR(c.measures.volume.net, 4.213e6, 0.005 * 4.213e6);
  EXPECT_NEAR(c.measures.volume.above, 4.258e6, 0.005 * 4.258e6);
  EXPECT_NEAR(c.measures.volume.below, 4.43e4, 0.005 * 4.43e4);
}

// Both rasters hold the heights of 2000 outside the dome: there the difference is exactly 0, not nearly.
TEST(RealData, SaintHelensRastersDifferOnTheDomeOnly) {
  ISOPACH_SHARED_OR_SKIP(folder, "msh-dome");
  const Cloud before = read(folder / "2.tif"), after = read(folder / "27.tif");
  const Comparison c = compare(before, after, {}, {});
  EXPECT_NEAR(c.measures.volume.net, 9.36e7, 0.005 * 9.36e7);

  ASSERT_EQ(before.points.size(), after.points.size());
  std::size_t unchanged = 0;
  for (std::size_t i = 0; i < before.points.size(); ++i) {
    ASSERT_EQ(before.points[i].x, after.points[i].x);
    const double dz = after.points[i].z - before.points[i].z;
    unchanged += dz == 0;
    EXPECT_EQ(c.fields_a.dz_signed[i], dz);
    EXPECT_EQ(c.fields_b.dz_signed[i], dz);
  }
  EXPECT_GT(unchanged, before.points.size() / 2);

  // The same grid twice: T is its triangulation. Cells without change carry no volume; the others carry all of it.
  EXPECT_EQ(c.interface, 0u);
  EXPECT_NEAR(c.coverage, 1, 1e-12);
  const CellView cells = c.cells.view();
  double still = 0, net = 0;
  for (Index t = 0; t < cells.t.real; ++t) {
    const Cell cell = cell_at(cells, t);
    if (cell.d[0] == 0 && cell.d[1] == 0 && cell.d[2] == 0) still += cell.area;
    net += cell.area * (cell.d[0] + cell.d[1] + cell.d[2]) / 3;
  }
  EXPECT_NEAR(net, c.measures.volume.net, 1e-9 * net);
  const double share = still / c.domain_area;
  EXPECT_GT(share, 0.5) << "share of the area that did not change at all";
  EXPECT_LT(share, 0.9);
  RecordProperty("unchanged_share", std::to_string(share));
}

}  // namespace
}  // namespace isopach::test
