// The law of tiles: what join_tiles makes of any tiling is compare() of all points, to the last bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "isopach/base/error.hpp"
#include "isopach/compare/changes.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/compare/stages.hpp"
#include "isopach/geom/convex_hull.hpp"
#include "isopach/geom/coordinate_hash.hpp"
#include "isopach/io/read.hpp"
#include "isopach/report/changes.hpp"
#include "isopach/report/report.hpp"
#include "isopach/simulate/scene.hpp"
#include "isopach/tiles/join.hpp"
#include "isopach/tiles/node_heights.hpp"
#include "isopach/tiles/solve.hpp"
#include "tests/support/clouds.hpp"
#include "tests/support/shared_data.hpp"

namespace isopach::test {
namespace {

/// Nodes of one scan that a tile holds: a run of the curve.
struct Run {
  std::size_t begin = 0, end = 0;
};

struct Square {
  int level = 0;
  std::uint64_t prefix = 0;
  std::array<Run, 2> run;
};

/// Squares of `least_level` or deeper, until none holds more than `most` nodes of both scans.
std::vector<Square> squares_of(const Pair& pair, int least_level, std::size_t most) {
  std::vector<Square> done,
      todo{{0, 0, {Run{0, pair.scan[0].field.keys.size()}, Run{0, pair.scan[1].field.keys.size()}}}};
  while (!todo.empty()) {
    const Square s = todo.back();
    todo.pop_back();
    const std::size_t count = (s.run[0].end - s.run[0].begin) + (s.run[1].end - s.run[1].begin);
    if (count == 0) continue;
    if (s.level >= least_level && (count <= most || s.level == 32)) {
      done.push_back(s);
      continue;
    }
    for (std::uint64_t digit = 4; digit-- > 0;) {
      Square part{s.level + 1, s.prefix << 2 | digit, {}};
      for (std::size_t k = 0; k < 2; ++k) {
        const auto& keys = pair.scan[k].field.keys;
        const auto at = [&](std::uint64_t prefix) {
          const auto from = keys.begin() + static_cast<std::ptrdiff_t>(s.run[k].begin),
                     to = keys.begin() + static_cast<std::ptrdiff_t>(s.run[k].end);
          const auto is_before = [&](std::uint64_t key, std::uint64_t p) { return key >> (64 - 2 * part.level) < p; };
          return static_cast<std::size_t>(std::lower_bound(from, to, prefix, is_before) - keys.begin());
        };
        part.run[k] = {at(part.prefix), digit == 3 ? s.run[k].end : at(part.prefix + 1)};
      }
      todo.push_back(part);
    }
  }
  return done;  // the last digit was taken up first
}

template <class T>
Array<T> slice(const Array<T>& all, const Run& run) {
  if (all.empty()) return {};
  return {all.begin() + static_cast<std::ptrdiff_t>(run.begin), all.begin() + static_cast<std::ptrdiff_t>(run.end)};
}

using Triangle3 = std::array<std::array<double, 4>, 3>;  // x, y, z1, z2 of each corner

Triangle3 from_least(Triangle3 t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

std::vector<Triangle3> cells_of(const CellView& cells) {
  std::vector<Triangle3> all;
  for_common(cells, [&](const CommonCell& c) {
    Triangle3 t;
    for (std::size_t k = 0; k < 3; ++k) {
      const Corner p = c.corner(k);
      t[k] = {p.x, p.y, p.z1, p.z2};
    }
    all.push_back(from_least(t));
  });
  return all;
}

struct Joined {
  Comparison comparison;
  std::vector<Triangle3> cells;
  std::optional<Displacement> displacement;
  std::array<Array<double>, 2> d;  // by point, as PointFields::dz_signed
  std::size_t tiles = 0, passed_up = 0, nodes = 0, final_cells = 0;
};

/// `heights`: by node of scan k, of the other surface.
Array<double> differences(const Cloud& cloud, const Pose& pose, const Pair& pair, std::size_t k,
                          const Array<double>& heights) {
  Array<double> d(cloud.points.size());
  for (std::size_t i = 0; i < d.size(); ++i) {
    const Index node = pair.scan[k].field.node_of_point[i];
    const double own = pair.frame.to_field(pose.apply(cloud.points[i])).z;
    const double other = node == no_index ? std::nan("") : heights[node];
    d[i] = k == 0 ? other - own : own - other;
  }
  return d;
}

bool same_bits(const Array<double>& a, const Array<double>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); });
}

Joined join(const Cloud& a, const Cloud& b, const CompareOptions& options, int level, std::size_t most,
            bool knows_hulls = true) {
  const Context context;
  Pair pair = project_pair(a, b, options.pose, options.project, context);
  Comparison c;
  c.options = options;
  c.frame = pair.frame;
  stages::check_units(a, b, options, c);
  stages::describe_inputs(a, b, pair, c, context);
  const stages::MergedSpreads spreads = stages::merged_spreads(a, b, pair, options);
  const stages::PointCounts points{stages::points_of_nodes(pair.scan[0].field),
                                   stages::points_of_nodes(pair.scan[1].field)};
  TilesToJoin tiles;
  tiles.is_raster = {spreads[0].is_raster, spreads[1].is_raster};
  std::array<ConvexHull, 2> hulls;
  for (std::size_t k = 0; k < 2 && knows_hulls; ++k) hulls[k].add(pair.scan[k].field.xy);
  std::vector<FinalCells> cells;
  Joined joined;
  const std::vector<Square> squares = squares_of(pair, level, most);
  for (const Square& s : squares) {
    TileInput input;
    input.frame = pair.frame;
    for (std::size_t k = 0; k < 2; ++k) {
      const HeightField& field = pair.scan[k].field;
      input.scan[k].field.xy = slice(field.xy, s.run[k]), input.scan[k].field.z = slice(field.z, s.run[k]);
      input.scan[k].field.keys = slice(field.keys, s.run[k]);
      input.scan[k].spread = slice(spreads[k].of_node, s.run[k]);
      input.scan[k].is_raster = spreads[k].is_raster;
      input.scan[k].points = slice(points[k], s.run[k]);
      input.scan[k].hull = hulls[k].corners();
    }
    const auto& first = input.scan[0].field.xy.empty() ? input.scan[1].field.xy : input.scan[0].field.xy;
    input.square = curve_square(pair.frame.curve, first[0], s.level);
    SolvedTile solved = solve_tile(std::move(input), options, context);
    for (const ScanPart& scan : solved.part.scan) joined.passed_up += scan.xy.size(), joined.nodes += scan.nodes;
    joined.final_cells += solved.cells.triangles.size();
    tiles.parts.push_back(std::move(solved.part));
    cells.push_back(std::move(solved.cells));
  }
  joined.tiles = cells.size();
  std::size_t first_node = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const auto part = std::make_shared<const CellPart>(cells[i].view(first_node));
    tiles.cells.push_back({cells[i].triangles.size(), [part] { return part; }});
    first_node += tiles.parts[i].nodes;
    for (const Corners& v : cells[i].triangles) {
      Triangle3 t;
      for (std::size_t k = 0; k < 3; ++k)
        t[k] = {cells[i].xy[v[k]].x, cells[i].xy[v[k]].y, cells[i].z1[v[k]], cells[i].z2[v[k]]};
      joined.cells.push_back(from_least(t));
    }
  }
  const std::vector<Part> parts = tiles.parts;
  HeightsOfOther found;
  tiles.heights = &found;
  joined.displacement = join_tiles(std::move(tiles), c, context);
  for (std::size_t k = 0; k < 2; ++k) {
    Array<double> heights;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const Array<Point2> nodes = slice(pair.scan[k].field.xy, squares[i].run[k]);
      const Array<double> some = node_heights(k, nodes, cells[i].view(0), parts[i].scan[k], found[k][i]);
      EXPECT_EQ(some.size(), nodes.size());
      heights.insert(heights.end(), some.begin(), some.end());
    }
    if (heights.size() == pair.scan[k].field.xy.size())
      joined.d[k] = differences(k == 0 ? a : b, k == 0 ? Pose{} : options.pose, pair, k, heights);
  }
  const std::vector<Triangle3> rest = cells_of(c.cells.view());
  joined.cells.insert(joined.cells.end(), rest.begin(), rest.end());
  joined.comparison = std::move(c);
  return joined;
}

nlohmann::json without_timing(const Comparison& c) {
  nlohmann::json json = nlohmann::json::parse(comparison_json(c, {}));
  json.erase("timing_s");
  json["localisation"].erase("visited_1_in_2"), json["localisation"].erase("visited_2_in_1");
  return json;
}

CompareOptions of_numbers() {
  CompareOptions options;
  options.keep_points = false;
  options.percentiles = {1, 37.5, 99.9};
  return options;
}

/// Gives what the last tiling did, to see that tiles did something.
Joined expect_whole(const Cloud& a, const Cloud& b, const CompareOptions& options,
                    const std::vector<std::array<int, 2>>& tilings) {
  Comparison whole;
  std::string refusal;
  try {
    CompareOptions with_points = options;
    with_points.keep_points = true;
    whole = compare(a, b, with_points, {});
  } catch (const Error& e) {
    refusal = e.what();
  }
  Joined joined;
  bool knows_hulls = false;
  for (const auto& [level, most] : tilings) {
    knows_hulls = !knows_hulls;
    SCOPED_TRACE("level " + std::to_string(level) + ", at most " + std::to_string(most) + " nodes");
    try {
      joined = join(a, b, options, level, static_cast<std::size_t>(most), knows_hulls);
    } catch (const Error& e) {
      EXPECT_EQ(std::string(e.what()), refusal);
      continue;
    }
    EXPECT_EQ(refusal, "");
    if (!refusal.empty()) continue;
    const nlohmann::json expected = without_timing(whole), found = without_timing(joined.comparison);
    EXPECT_EQ(found, expected) << nlohmann::json::diff(expected, found).dump(1).substr(0, 3000);
    EXPECT_EQ(joined.comparison.compared_points, whole.compared_points);
    if (options.changes.asked) {
      EXPECT_EQ(changes_csv(joined.comparison), changes_csv(whole));
      EXPECT_EQ(changes_geojson(joined.comparison), changes_geojson(whole));
    }
    const std::optional<Displacement> lies_off = plain_displacement(whole, {});
    EXPECT_EQ(joined.displacement.has_value(), lies_off.has_value());
    if (lies_off && joined.displacement) {
      EXPECT_EQ(joined.displacement->offset, lies_off->offset);
      EXPECT_EQ(joined.displacement->tilt, lies_off->tilt);
      EXPECT_EQ(joined.displacement->shift, lies_off->shift);
    }
    EXPECT_TRUE(same_bits(joined.d[0], whole.fields_a.dz_signed));
    EXPECT_TRUE(same_bits(joined.d[1], whole.fields_b.dz_signed));
    std::vector<Triangle3> cells = cells_of(whole.cells.view());
    std::sort(cells.begin(), cells.end()), std::sort(joined.cells.begin(), joined.cells.end());
    EXPECT_TRUE(cells == joined.cells) << cells.size() << " and " << joined.cells.size() << " cells";
    if (testing::Test::HasFailure()) return joined;
  }
  return joined;
}

constexpr int any = 1 << 30;

SceneOptions sized(std::size_t a, std::size_t b, const std::string& variant = "") {
  SceneOptions o;
  o.points_a = a, o.points_b = b, o.variant = variant;
  return o;
}

TEST(Tiles, AreTheWholeOfAHillside) {
  const Scene scene = make_scene("terrain", sized(20000, 16000), {});
  const Joined joined =
      expect_whole(scene.a, scene.b, of_numbers(), {{0, any}, {1, any}, {2, any}, {0, 900}, {3, any}, {5, any}});
  EXPECT_GT(joined.tiles, 900U);
  const Joined few = join(scene.a, scene.b, of_numbers(), 1, any);
  EXPECT_LT(few.passed_up, few.nodes * 7 / 10);
  EXPECT_GT(few.final_cells, 0U);
}

TEST(Tiles, TellOfAScanThatLiesOff) {
  Scene scene = make_scene("terrain", sized(5000, 4000), {});
  for (Point3& p : scene.b.points) p.z += 7 + 0.01 * (p.x - 412000), p.x += 3;
  const Joined joined = expect_whole(scene.a, scene.b, of_numbers(), {{1, any}, {3, any}});
  EXPECT_TRUE(joined.displacement.has_value());
}

TEST(Tiles, OfAtMostThreePoints) {
  const Scene scene = make_scene("terrain", sized(900, 700), {});
  const Joined joined = expect_whole(scene.a, scene.b, of_numbers(), {{0, 3}, {0, 1}, {0, 40}, {0, 250}});
  EXPECT_GT(joined.tiles, 1U);
}

// Folds, holes and rims are found over tiles.
TEST(Tiles, OfOtherScenes) {
  const std::vector<std::array<int, 2>> tilings{{1, any}, {2, any}, {0, 700}, {4, any}};
  for (const char* name : {"face", "relief", "cone", "skin", "plane"}) {
    SCOPED_TRACE(name);
    const Scene scene = make_scene(name, sized(4000, 3000), {});
    expect_whole(scene.a, scene.b, of_numbers(), tilings);
  }
}

/// Two layers over one another in a part, a hole, an island beside, steps.
Cloud folded(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  Cloud cloud;
  while (cloud.points.size() < n) {
    const double x = random.uniform(0, 1), y = random.uniform(0, 1), r = std::hypot(x - 0.5, y - 0.47);
    if (r < 0.12 || (x > 0.8 && y < 0.3 && y > 0.1)) continue;
    double z = 0.05 * std::sin(9 * x) + 0.04 * std::cos(11 * y) + 0.001 * random.uniform(-1, 1);
    if (x < 0.35 && y > 0.6 && random.uniform(0, 1) < 0.5) z -= 0.4;
    if (x > 0.7) z += 0.2;
    cloud.points.push_back({x, y, z});
  }
  for (std::size_t i = 0; i < n / 40; ++i)
    cloud.points.push_back({1.3 + 0.1 * random.uniform(0, 1), 0.4 + 0.1 * random.uniform(0, 1), 0.1});
  return cloud;
}

TEST(Tiles, OfScansWithFoldsHolesAndIslands) {
  const std::vector<std::array<int, 2>> tilings{{1, any}, {3, any}, {0, 300}, {0, 30}};
  const Cloud a = folded(3500, 1), b = folded(2500, 2);
  for (const FoldRule folds : {FoldRule::leave_out, FoldRule::keep})
    for (const BorderRule border : {BorderRule::trim, BorderRule::hull}) {
      CompareOptions options = of_numbers();
      options.folds = folds, options.border = border;
      const Comparison c = compare(a, b, options, {});
      EXPECT_GT(c.folds.area, 0.01);
      expect_whole(a, b, options, tilings);
    }
  for (const bool look : {false, true}) {
    CompareOptions options = of_numbers();
    options.check_layers = look;
    options.max_edge = 0.05;
    expect_whole(a, b, options, tilings);
    options.max_edge = 0, options.alpha = 0.02;
    expect_whole(a, b, options, tilings);
    options.border = BorderRule::hull;
    expect_whole(a, b, options, tilings);
  }
}

/// Small holes and small folds all over, so that tiles have some well inside.
Cloud pierced(std::size_t n, std::size_t holes, std::size_t folds, std::uint64_t seed) {
  Random random(seed);
  std::vector<Point2> centres;
  for (std::size_t i = 0; i < holes + folds; ++i) centres.push_back({random.uniform(0, 1), random.uniform(0, 1)});
  const double radius = 4 / std::sqrt(static_cast<double>(n));
  Cloud cloud;
  while (cloud.points.size() < n) {
    const Point2 p{random.uniform(0, 1), random.uniform(0, 1)};
    double z = 0.05 * std::sin(9 * p.x) + 0.04 * std::cos(11 * p.y);
    bool is_in_hole = false;
    for (std::size_t i = 0; i < centres.size(); ++i) {
      if (std::hypot(p.x - centres[i].x, p.y - centres[i].y) > radius) continue;
      is_in_hole = is_in_hole || i < holes;
      if (random.uniform(0, 1) < 0.5) z -= 0.4;
    }
    if (!is_in_hole) cloud.points.push_back({p.x, p.y, z});
  }
  return cloud;
}

TEST(Tiles, OfScansOfDifferentDetailWithHolesInsideTiles) {
  const std::vector<std::array<int, 2>> tilings{{1, any}, {2, any}};
  for (const auto& [n1, n2] : std::vector<std::array<std::size_t, 2>>{{14000, 60000}, {60000, 14000}, {20000, 30000}}) {
    SCOPED_TRACE(std::to_string(n1) + " and " + std::to_string(n2));
    const Cloud a = pierced(n1, 3, 0, n1), b = pierced(n2, 20, 12, n2);
    for (const bool look : {false, true}) {
      CompareOptions options = of_numbers();
      options.check_layers = look;
      const Joined joined = expect_whole(a, b, options, tilings);
      EXPECT_GT(joined.final_cells, 500U);
    }
  }
}

// Points of one place, nodes of both scans in one place.
TEST(Tiles, OfScansWithEqualPlaces) {
  Random random(5);
  Cloud a, b;
  const auto on_lattice = [&] { return std::floor(random.uniform(0, 40)) / 64; };
  for (int i = 0; i < 2500; ++i) a.points.push_back({on_lattice(), on_lattice(), random.uniform(0, 0.1)});
  for (int i = 0; i < 1800; ++i) b.points.push_back({on_lattice(), on_lattice(), random.uniform(0, 0.1)});
  for (const DuplicatePolicy policy : {DuplicatePolicy::mean, DuplicatePolicy::min, DuplicatePolicy::median}) {
    CompareOptions options = of_numbers();
    options.project.duplicates = policy;
    expect_whole(a, b, options, {{1, any}, {2, any}, {0, 100}, {5, any}});
    options.border = BorderRule::hull, options.check_layers = false;
    expect_whole(a, b, options, {{1, any}, {2, any}, {0, 3}});
  }
}

TEST(Tiles, OfScansThatHardlyOverlap) {
  const Cloud a = rough_cloud(uniform(1500, 1), 1);
  for (const double by : {0.5, 0.9, 0.999}) {
    SCOPED_TRACE(by);
    const Cloud b = shifted(rough_cloud(uniform(1500, 2), 2), {by, 0.1, 0});
    expect_whole(a, b, of_numbers(), {{1, any}, {3, any}, {0, 50}});
  }
  const Cloud inside = shifted(rough_cloud(tiny(1500, 3), 3), {0.5, 0.5, 0});
  expect_whole(a, inside, of_numbers(), {{1, any}, {3, any}, {0, 50}});
  expect_whole(inside, a, of_numbers(), {{1, any}, {3, any}, {0, 50}});
}

CompareOptions of_changes(double level, std::optional<double> min_area = std::nullopt) {
  CompareOptions options = of_numbers();
  options.uncertainty.lod = level;
  options.changes.asked = true;
  options.changes.min_area = min_area;
  return options;
}

// Objects are joined across tiles.
TEST(TiledChanges, OfAHillside) {
  const Scene scene = make_scene("terrain", sized(6000, 5000), {});
  for (const double level : {0.05, 0.3, 1.0}) {
    SCOPED_TRACE(level);
    const Joined joined =
        expect_whole(scene.a, scene.b, of_changes(level), {{1, any}, {0, 3}, {0, 40}, {0, 700}, {4, any}});
    ASSERT_TRUE(joined.comparison.changes.has_value());
    EXPECT_GT(joined.comparison.uncertainty.detected->area, 0);
  }
  CompareOptions options = of_changes(0.2, 0);
  options.changes.height = 0.1, options.changes.min_volume = 3;
  const Joined joined = expect_whole(scene.a, scene.b, options, {{2, any}, {0, 100}});
  EXPECT_FALSE(joined.comparison.changes->list.empty());
  options = of_changes(0);
  options.changes.height = 0.4;
  expect_whole(scene.a, scene.b, options, {{2, any}, {0, 100}});
}

TEST(TiledChanges, OfOneObjectOverAllTilesAndOfNone) {
  const Cloud a = rough_cloud(uniform(9000, 1), 1), b = shifted(rough_cloud(uniform(7000, 2), 2), {0, 0, 10});
  const Joined all = expect_whole(a, b, of_changes(1), {{1, any}, {3, any}, {0, 30}});
  ASSERT_EQ(all.comparison.changes->list.size(), 1U);
  EXPECT_GT(all.tiles, 60U);
  EXPECT_GT(join(a, b, of_changes(1), 1, any).final_cells, 0U);
  const Joined none = expect_whole(a, b, of_changes(100), {{1, any}, {0, 30}});
  EXPECT_TRUE(none.comparison.changes->list.empty());
}

// Holes, islands, folds and rims: cells that are cut lie beside final ones.
TEST(TiledChanges, OfScansWithFoldsHolesAndIslands) {
  const Cloud a = folded(3500, 1), b = folded(2500, 2);
  for (const FoldRule folds : {FoldRule::leave_out, FoldRule::keep})
    for (const BorderRule border : {BorderRule::trim, BorderRule::hull})
      for (const std::optional<double> min_area : {std::optional<double>{}, std::optional<double>{0}}) {
        CompareOptions options = of_changes(0.002, min_area);
        options.folds = folds, options.border = border;
        const Joined joined = expect_whole(a, b, options, {{1, any}, {3, any}, {0, 300}, {0, 3}});
        const Changes& found = *joined.comparison.changes;
        EXPECT_GT(found.list.size() + found.small.gained + found.small.lost, 5U);
        EXPECT_GT(found.list.size(), 1U);
      }
}

TEST(TiledChanges, OfScansWithHolesInsideTiles) {
  const Cloud a = pierced(20000, 3, 0, 4), b = pierced(30000, 20, 12, 5);
  const Joined joined = expect_whole(a, b, of_changes(0.0005, 0), {{1, any}, {2, any}});
  EXPECT_GT(joined.final_cells, 500U);
  EXPECT_GT(joined.comparison.changes->list.size(), 10U);
}

// Heights on a lattice: d is at the level, and objects touch in nodes and along sides.
TEST(TiledChanges, ThatTouchWhereTheyReachTheLevel) {
  Random random(7);
  Cloud a, b;
  for (int i = 0; i < 48; ++i)
    for (int k = 0; k < 40; ++k) {
      a.points.push_back({i / 64.0, k / 64.0, 0});
      b.points.push_back({i / 64.0, k / 64.0, std::floor(random.uniform(-3, 4)) / 4});
    }
  for (int i = 0; i < 300; ++i)  // several points of one place
    b.points.push_back({std::floor(random.uniform(0, 48)) / 64, std::floor(random.uniform(0, 40)) / 64, 0.25});
  for (const double level : {0.25, 0.5})
    for (const DuplicatePolicy policy : {DuplicatePolicy::mean, DuplicatePolicy::max}) {
      CompareOptions options = of_changes(level, 0);
      options.project.duplicates = policy;
      const Joined joined = expect_whole(a, b, options, {{1, any}, {2, any}, {0, 100}, {0, 3}});
      EXPECT_GT(joined.comparison.changes->list.size(), 10U);
    }
}

TEST(TiledChanges, OfScansThatHardlyOverlap) {
  const Cloud a = rough_cloud(uniform(1500, 1), 1);
  const Cloud b = shifted(rough_cloud(uniform(1500, 2), 2), {0.5, 0.1, 0});
  const Cloud inside = shifted(rough_cloud(tiny(1500, 3), 3), {0.5, 0.5, 0});
  for (const BorderRule border : {BorderRule::trim, BorderRule::hull})
    for (const Cloud* other : {&b, &inside}) {
      CompareOptions options = of_changes(0.1);
      options.border = border;
      expect_whole(a, *other, options, {{1, any}, {3, any}, {0, 50}});
      expect_whole(*other, a, options, {{1, any}, {3, any}, {0, 50}});
    }
}

// What lies beyond the hull of the other scan stays in its tile.
TEST(Tiles, KeepWhatLiesBeyondTheOtherScan) {
  Cloud a = rough_cloud(uniform(40000, 1), 1), b = rough_cloud(uniform(9000, 2), 2);
  for (Point3& p : b.points) {  // a disc in a corner
    const double r = std::sqrt(p.x) * 0.25, t = 6.283185307179586 * p.y;
    p.x = 0.3 + r * std::cos(t), p.y = 0.3 + r * std::sin(t);
  }
  for (const BorderRule border : {BorderRule::trim, BorderRule::hull}) {
    CompareOptions options = of_numbers();
    options.border = border;
    expect_whole(a, b, options, {{1, any}, {2, any}, {2, any}});
    expect_whole(b, a, options, {{3, any}, {0, 50}, {0, 2000}});
  }
  for (Cloud* scan : {&a, &b})  // without folds, which go up wherever they lie
    for (Point3& p : scan->points) p.z = 0.1 * p.x;
  const Joined kept = join(a, b, of_numbers(), 1, any), all = join(a, b, of_numbers(), 1, any, false);
  EXPECT_LT(kept.passed_up, all.passed_up * 6 / 10);
}

class TiledFamilies : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(All, TiledFamilies, testing::ValuesIn(families()),
                         [](const auto& family) { return family.param.name; });

TEST_P(TiledFamilies, WithEveryOther) {
  std::uint64_t seed = 0;
  for (const Family& other : families()) {
    SCOPED_TRACE(other.name);
    const std::uint64_t s = ++seed;
    const Cloud a = rough_cloud(GetParam().make(160, s), s), b = rough_cloud(other.make(120, s + 50), s + 50);
    CompareOptions options = of_numbers();
    expect_whole(a, b, options, {{0, 60}, {0, 7}});
    options.border = BorderRule::hull, options.check_layers = s % 2 == 0;
    expect_whole(a, b, options, {{0, 60}, {0, 7}});
    if (HasFailure()) return;
  }
}

// ISOPACH_TILE_SETS=20000 takes a minute.
TEST(Tiles, OfSmallSetsOnBorders) {
  const char* asked = std::getenv("ISOPACH_TILE_SETS");
  const int trials = asked != nullptr ? std::atoi(asked) : 1500;
  Random random(7);
  for (int trial = 0; trial < trials && !testing::Test::HasFailure(); ++trial) {
    SCOPED_TRACE(trial);
    const int kind = trial % 4;
    const auto place = [&]() -> Point2 {
      const double x = random.uniform(0, 1), y = random.uniform(0, 1);
      if (kind == 0) return {std::floor(8 * x) / 8, std::floor(8 * y) / 8};
      if (kind == 1) return {std::floor(16 * x) / 16, std::floor(16 * y) / 16};
      if (kind == 2) return {x, y};
      return {(x < 0.5 ? 0.2 : 0.7) + 0.05 * x, 0.45 + 0.1 * y};
    };
    const auto scan = [&] {
      Points points;
      const auto n = static_cast<std::size_t>(random.uniform(3, 70));
      for (std::size_t i = 0; i < n; ++i) points.push_back(place());
      return rough_cloud(points, static_cast<std::uint64_t>(trial));
    };
    const Cloud a = scan(), b = scan();
    CompareOptions options = of_numbers();
    if (trial % 3 == 1) options.border = BorderRule::hull;
    if (trial % 5 == 0) options.check_layers = false;
    expect_whole(a, b, options, {{1 + trial % 3, any}, {0, 5}});
  }
}

class TiledScans : public testing::TestWithParam<std::array<std::string, 2>> {};
INSTANTIATE_TEST_SUITE_P(Real, TiledScans,
                         testing::Values(std::array<std::string, 2>{"msh-dome/2.tif", "msh-dome/12.tif"},
                                         std::array<std::string, 2>{"goast-faces/neutral.ply", "goast-faces/smile.ply"},
                                         std::array<std::string, 2>{"santacruz/blanca_strip8706_120m.las",
                                                                    "santacruz/blanca_strip8707_120m.las"},
                                         std::array<std::string, 2>{"autzen-bmx/autzen-bmx-2010.las",
                                                                    "autzen-bmx/autzen-bmx-2023.las"}));

TEST_P(TiledScans, AreTheWhole) {
  ISOPACH_SHARED_OR_SKIP(file_a, GetParam()[0]);
  ISOPACH_SHARED_OR_SKIP(file_b, GetParam()[1]);
  const Cloud a = read_cloud(file_a.string(), {}, {}), b = read_cloud(file_b.string(), {}, {});
  CompareOptions options = of_numbers();
  options.allow_crs = true;
  const Joined joined = expect_whole(a, b, options, {{1, any}, {0, 20000}, {0, 900}});
  EXPECT_GT(joined.tiles, 4U);
}

TEST(Tiles, RefuseWhatTheyCannotDoByName) {
  CompareOptions options;
  options.noise_floor = true;
  try {
    check_tiled(options);
    FAIL();
  } catch (const UsageError& e) {
    EXPECT_EQ(e.option(), "noise-floor");
  }
}

}  // namespace
}  // namespace isopach::test
