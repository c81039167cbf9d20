// What is computed of strided views of the caller's arrays has the bits of what is computed of the cloud that they are
// a copy of; and nothing is copied first.
#include "isopach/cloud/cloud_view.hpp"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "isopach/compare/compare.hpp"
#include "isopach/distance/distance.hpp"
#include "isopach/match/match.hpp"
#include "tests/match/poses.hpp"
#include "tests/support/clouds.hpp"

namespace isopach::test {
namespace {

/// A caller's array: rows of x, y, z, sigma and class.
struct Table {
  static constexpr std::size_t width = 5;
  std::vector<double> rows;

  [[nodiscard]] std::size_t size() const { return rows.size() / width; }
  [[nodiscard]] ValuesView column(std::size_t k) const { return {rows.data() + k, size(), width}; }
  [[nodiscard]] CloudView view() const {
    CloudView view{PointsView(rows.data(), size(), width)};
    view.attributes = {{"sigma", column(3)}, {"classification", column(4)}};
    view.path = "rows", view.unit = view.vertical_unit = "m";
    return view;
  }
  [[nodiscard]] Cloud copied() const {
    Cloud cloud;
    cloud.attributes = {{"sigma", {}}, {"classification", {}}};
    for (std::size_t i = 0; i < size(); ++i) {
      const double* const row = &rows[i * width];
      cloud.points.push_back({row[0], row[1], row[2]});
      cloud.attributes[0].values.push_back(row[3]);
      cloud.attributes[1].values.push_back(row[4]);
    }
    cloud.path = "rows", cloud.unit = cloud.vertical_unit = "m";
    return cloud;
  }
};

/// A hilly square of 10 by 10 with noise, a mound of height `rise`, some points of another class, some on one spot.
Table hills(std::size_t n, std::uint64_t seed, double rise) {
  Random random(seed);
  Table table;
  for (const Point2& p : framed_square(n, seed)) {
    const double x = 10 * p.x, y = 10 * p.y, from_mound = std::hypot(x - 6, y - 4);
    const double z = std::sin(x) * std::cos(0.7 * y) + rise * std::exp(-from_mound * from_mound);
    const int repeats = random.uniform(0, 1) < 0.03 ? 2 : 1;
    for (int k = 0; k < repeats; ++k) {
      const double noise = random.uniform(-0.01, 0.01), sigma = random.uniform(0.005, 0.01);
      const double kind = random.uniform(0, 1) < 0.1 ? 6 : 2;
      table.rows.insert(table.rows.end(), {x, y, z + noise, sigma, kind});
    }
  }
  return table;
}

/// Numbers by their bits, NaN included.
class Bits {
 public:
  void add(double v) { bits_.push_back(std::bit_cast<std::uint64_t>(v)); }
  void add(std::span<const double> values) {
    for (const double v : values) add(v);
    add(static_cast<double>(values.size()));
  }
  void add(const Volume& v) { add(std::array{v.above, v.below, v.net, v.absolute}); }
  void add(const Measures& m) {
    const DifferenceStatistics& d = m.difference;
    add(std::array{m.area, m.rho, m.error_estimate, d.mean, d.rms, d.std, d.median, d.nmad, d.max_above, d.max_below});
    add(m.volume), add(d.abs_percentiles), add(d.histogram.edges), add(d.histogram.areas);
    for (const Percentile& p : d.more_percentiles) add(p.value);
  }
  void add(const Pose& pose) { add(pose.m); }
  friend bool operator==(const Bits&, const Bits&) = default;

 private:
  std::vector<std::uint64_t> bits_;
};

Bits bits_of(const Comparison& c) {
  Bits bits;
  bits.add(c.measures);
  if (c.overlay) bits.add(*c.overlay);
  bits.add(std::array{c.domain_area, c.area_union, c.coverage, c.trimmed_area, c.trimmed_volume, c.sliver_area,
                      c.sliver_volume, c.folds.share_a, c.folds.share_b, c.a.layered_share, c.b.layered_share});
  for (const InputSummary* s : {&c.a, &c.b})
    bits.add(std::array{s->bounds.min.x, s->bounds.max.y, s->bounds.min.z, s->bounds.max.z,
                        static_cast<double>(s->points), static_cast<double>(s->nodes),
                        static_cast<double>(s->cleaning.dropped_class), s->cleaning.duplicate_max_spread});
  for (const Point2& p : c.cells.xy) bits.add(p.x), bits.add(p.y);
  bits.add(c.cells.z1), bits.add(c.cells.z2), bits.add(c.cells.lod);
  for (const PointFields* f : {&c.fields_a, &c.fields_b}) bits.add(f->dz_signed), bits.add(f->lod);
  if (c.uncertainty.sigma) bits.add(std::array{c.uncertainty.sigma->net, c.uncertainty.sigma->above});
  if (c.noise_floor) bits.add(c.noise_floor->rho), bits.add(c.noise_floor->debiased);
  if (c.weighted) bits.add(std::array{c.weighted->integral, c.weighted->net});
  if (c.detail) bits.add(std::array{c.detail->rho, c.detail->mean, c.detail->area});
  return bits;
}

/// All that reads points and attributes.
CompareOptions everything() {
  CompareOptions o;
  o.project.classes = {2};
  o.surface = Surface::both;
  o.percentiles = {75};
  o.noise_floor = true;
  o.weight = {WeightSource::Kind::attribute, WeightSource::Scan::b, "sigma"};
  o.uncertainty.model = UncertaintyModel::independent;
  o.uncertainty.sigma1 = o.uncertainty.sigma2 = {SigmaSource::Kind::attribute, 0, "sigma"};
  o.pose.m[11] = 0.125;
  return o;
}

TEST(CloudView, ComparisonOfStridedRowsHasTheBitsOfThatOfTheCloud) {
  const Table a = hills(1500, 1, 0), b = hills(2000, 2, 0.5);
  const Comparison of_views = compare(a.view(), b.view(), everything(), {});
  const Comparison of_clouds = compare(a.copied(), b.copied(), everything(), {});
  EXPECT_TRUE(bits_of(of_views) == bits_of(of_clouds));
  EXPECT_EQ(of_views.warnings, of_clouds.warnings);
  EXPECT_EQ(of_views.unit, "m");
  EXPECT_EQ(of_views.b.path, "rows");
  // Nothing above is equal because there is nothing of it.
  EXPECT_GT(of_views.a.cleaning.dropped_class, 0u);
  EXPECT_GT(of_views.b.cleaning.duplicates, 0u);
  EXPECT_TRUE(of_views.weighted && of_views.noise_floor && of_views.overlay && of_views.uncertainty.sigma);
  EXPECT_FALSE(bits_of(of_views) == bits_of(compare(b.view(), a.view(), everything(), {})));
}

// The differences of the points are taken from the points once more, near the end: one that moves meanwhile shows whose
// array it is.
TEST(CloudView, ComparisonReadsTheCallersArrayAndNoCopyOfIt) {
  Table a = hills(500, 3, 0);
  const Table b = hills(500, 4, 0.5);
  const Comparison before = compare(a.view(), b.view(), {}, {});
  const std::size_t point = 100;
  ASSERT_TRUE(std::isfinite(before.fields_a.dz_signed[point]));
  Context context;
  bool moved = false;
  context.progress = [&](std::string_view stage, double fraction) {
    if (stage == "border" && fraction == 0) a.rows[point * Table::width + 2] += 16, moved = true;
  };
  const Comparison after = compare(a.view(), b.view(), {}, context);
  ASSERT_TRUE(moved);
  EXPECT_NEAR(after.fields_a.dz_signed[point], before.fields_a.dz_signed[point] - 16, 1e-12);
  EXPECT_EQ(after.fields_a.dz_signed[point + 1], before.fields_a.dz_signed[point + 1]);
}

TEST(CloudView, MatchingOfStridedRowsHasTheBitsOfThatOfTheCloud) {
  const Table fixed = hills(1500, 5, 0);
  Table moving = hills(1500, 6, 0);
  const Pose away = turn_and_shift({0, 0.1, 1}, 2, {5, 5, 0}, {0.1, -0.15, 0.05});
  for (std::size_t i = 0; i < moving.size(); ++i) {
    double* const row = &moving.rows[i * Table::width];
    const Point3 p = away.apply({row[0], row[1], row[2]});
    row[0] = p.x, row[1] = p.y, row[2] = p.z;
  }
  for (const Objective objective : {Objective::measure, Objective::icp_plane}) {
    MatchOptions o;
    o.objective = objective;
    o.label_points = true;
    const Matching of_views = match(moving.view(), fixed.view(), o, {});
    const Matching of_clouds = match(moving.copied(), fixed.copied(), o, {});
    const auto bits_of = [](const Matching& m) {
      Bits bits;
      bits.add(m.pose), bits.add(m.covariance);
      bits.add(std::array{m.before.rho, m.before.rms, m.after.rho, m.after.rms, m.after.coverage, m.overlap});
      for (const MatchStep& s : m.history) bits.add(s.rms);
      if (m.verdict) bits.add(m.verdict->evidence.agree), bits.add(m.verdict->evidence.shape);
      return bits;
    };
    EXPECT_TRUE(bits_of(of_views) == bits_of(of_clouds));
    EXPECT_EQ(of_views.stable, of_clouds.stable);
    EXPECT_EQ(of_views.agreement, of_clouds.agreement);
    EXPECT_EQ(of_views.warnings, of_clouds.warnings);
    EXPECT_FALSE(of_views.pose.is_identity());
    EXPECT_TRUE(of_views.verdict.has_value());
    EXPECT_EQ(of_views.agreement.size(), moving.size());
  }
}

TEST(CloudView, DistancesOfStridedRowsAndOfFacesHaveTheBitsOfThoseOfTheCloud) {
  const Table a = hills(400, 7, 0), b = hills(400, 8, 0.5);
  const std::vector<std::array<Index, 3>> faces{{0, 1, 2}, {3, 4, 5}, {6, 7, 8}};  // of B, which is a mesh
  CloudView view = b.view();
  view.faces = faces;
  Cloud cloud = b.copied();
  cloud.faces.assign(faces.begin(), faces.end());
  const Table cores = hills(20, 9, 0);
  DistanceOptions o;
  o.measures = {true, true, true, true, false, true, true};
  o.m3c2.normal_scale = o.m3c2.projection_scale = o.m3c2.max_depth = 2;
  const Distances of_views = distance(a.view(), view, cores.view(), o, {});
  const Distances of_clouds = distance(a.copied(), cloud, cores.copied(), o, {});
  const auto bits_of = [](const Distances& d) {
    Bits bits;
    for (const auto* fields : {&d.fields_a, &d.fields_b})
      for (const Attribute& f : *fields) bits.add(f.values);
    for (const auto* figures : {&d.c2c, &d.c2s, &d.normal, &d.vertical})
      for (const Figures* f : {&(*figures)->a_to_b, &(*figures)->b_to_a})
        bits.add(std::array{f->mean, f->rms, f->max, f->p95, static_cast<double>(f->count)});
    bits.add(std::array{d.hausdorff->a_to_b.upper, d.hausdorff->b_to_a.upper});
    bits.add(d.m3c2->field.distance), bits.add(d.m3c2->field.lod);
    return bits;
  };
  EXPECT_TRUE(bits_of(of_views) == bits_of(of_clouds));
  EXPECT_EQ(of_views.faces_b, 3u);
  EXPECT_EQ(of_views.m3c2->cores.size(), cores.size());
  EXPECT_GT(of_views.m3c2->measured, 0u);
}

}  // namespace
}  // namespace isopach::test
