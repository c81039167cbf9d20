// layered_share on scenes whose answer is known, and on real scans.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/field/height_field.hpp"
#include "tests/field/clouds.hpp"
#include "tests/support/shared_data.hpp"

namespace isopach::test {
namespace {

double share_of(const Cloud& cloud, const ProjectOptions& options = {}) {
  return layered_share(cloud, Pose{}, choose_frame(cloud, cloud, Pose{}, options, {}), options, {});
}

using Height = std::function<double(double x, double y, FieldRandom& random)>;

Cloud scene(const Height& height, std::size_t n = 20000) {
  FieldRandom random(1);
  Cloud cloud = make_cloud({});
  for (std::size_t i = 0; i < n; ++i) {
    const double x = random.uniform(), y = random.uniform();
    cloud.points.push_back({x, y, height(x, y, random)});
  }
  return cloud;
}

Cloud sphere(bool upper_only) {
  FieldRandom random(2);
  Cloud cloud = make_cloud({});
  for (int i = 0; i < 20000; ++i) {
    const Point3 p{random.normal(), random.normal(), random.normal()};
    const double r = std::hypot(p.x, p.y, p.z);
    cloud.points.push_back({p.x / r, p.y / r, upper_only ? std::fabs(p.z / r) : p.z / r});
  }
  return cloud;
}

const double tan80 = std::tan(80 * std::acos(-1.0) / 180);

TEST(Layers, a_single_surface_has_none) {
  EXPECT_LE(share_of(scene([](double x, double y, FieldRandom&) { return std::sin(9 * x) * std::cos(7 * y); })), 0.002);
  EXPECT_LE(share_of(sphere(true)), 0.005);
}

TEST(Layers, noise_is_no_layer) {
  EXPECT_LE(share_of(scene([](double, double, FieldRandom& r) { return 0.01 * r.normal(); })), 0.005);
  EXPECT_LE(share_of(scene([](double, double, FieldRandom& r) { return 10 * r.normal(); })), 0.005);
  EXPECT_LE(share_of(scene([](double, double, FieldRandom& r) { return r.uniform(); })), 0.005);
}

TEST(Layers, rounding_of_heights_is_no_layer) {
  EXPECT_EQ(share_of(scene([](double, double, FieldRandom& r) { return 0.001 * std::round(0.4 + 0.3 * r.normal()); })),
            0);
}

TEST(Layers, a_cliff_is_no_layer) {
  EXPECT_LE(share_of(scene(
                [](double x, double y, FieldRandom& r) { return (x + 0.3 * y > 0.6 ? 1 : 0) + 0.001 * r.normal(); })),
            0.005);
  EXPECT_LE(share_of(scene([](double x, double y, FieldRandom& r) {
              return (x + 0.02 * std::sin(80 * y) > 0.5 ? 1 : 0) + 0.001 * r.normal();
            })),
            0.005);
  EXPECT_LE(share_of(scene([](double x, double, FieldRandom&) { return 0.1 * std::floor(10 * x); })), 0.005);
}

TEST(Layers, a_block_inside_a_cell_is_no_layer) {
  EXPECT_LE(share_of(scene([](double x, double y, FieldRandom&) {
              return std::hypot(std::fmod(16 * x, 1) - 0.5, std::fmod(16 * y, 1) - 0.5) < 0.3 ? 0.3 : 0;
            })),
            0.05);
}

TEST(Layers, a_steep_plane_is_no_layer) {
  EXPECT_LE(share_of(scene([](double x, double, FieldRandom& r) { return x * tan80 + 0.002 * r.normal(); })), 0.005);
  EXPECT_LE(share_of(scene([](double x, double, FieldRandom& r) { return x * tan80 + 0.02 * r.normal(); })), 0.005);
}

TEST(Layers, two_sheets_are_layers_everywhere) {
  const auto sheets = [](double share, double noise) {
    return [share, noise](double, double, FieldRandom& r) {
      const double level = r.uniform() < share ? 0.2 : 0;
      return level + noise * r.normal();
    };
  };
  EXPECT_GE(share_of(scene(sheets(0.5, 0.002))), 0.98);
  EXPECT_GE(share_of(scene(sheets(0.5, 0))), 0.98);
  EXPECT_GE(share_of(scene(sheets(0.35, 0.002))), 0.98);
  EXPECT_GE(share_of(scene([](double x, double y, FieldRandom& r) {
              return 3 * x - 2 * y + (r.uniform() < 0.5 ? 0.2 : 0) + 0.002 * r.normal();
            })),
            0.98);
}

TEST(Layers, two_points_at_every_place_are_layers) {
  Cloud cloud = make_cloud({});
  for (int i = 0; i < 100; ++i)
    for (int j = 0; j < 100; ++j)
      for (const double z : {0.0, 20.0}) cloud.points.push_back({double(i), double(j), z});
  EXPECT_EQ(share_of(cloud), 1);
}

TEST(Layers, half_the_area_in_two_sheets_is_half) {
  EXPECT_NEAR(share_of(scene([](double x, double, FieldRandom& r) {
                return (x < 0.5 && r.uniform() < 0.5 ? 0.2 : 0) + 0.002 * r.normal();
              })),
              0.5, 0.02);
}

TEST(Layers, a_whole_sphere_is_layered_but_for_its_rim) { EXPECT_GE(share_of(sphere(false)), 0.85); }

TEST(Layers, order_and_threads_do_not_matter) {
  Cloud cloud = sphere(false);
  for (const Point3& p : scene([](double, double, FieldRandom& r) { return r.normal(); }).points)
    cloud.points.push_back({p.x + 0.5, p.y + 0.5, p.z});
  FieldRandom random(4);
  for (int i = 0; i < 100000;
       ++i)  // many heights a place, at the edge of the rule: the sample of a cell must not shift
    cloud.points.push_back({3 + 0.001 * static_cast<double>(random.below(20)),
                            0.001 * static_cast<double>(random.below(20)),
                            static_cast<double>(random.below(2)) + 0.166 * random.normal()});
  const double share = share_of(cloud);
  EXPECT_GT(share, 0);
  FieldRandom(3).shuffle(cloud.points);
  for (const int threads : {1, 2, 7}) run_with_threads(threads, [&] { EXPECT_EQ(share_of(cloud), share); });
}

TEST(Layers, outliers_far_away_do_not_spoil_the_cells) {
  Cloud cloud =
      scene([](double, double, FieldRandom& r) { return (r.uniform() < 0.5 ? 0.2 : 0) + 0.002 * r.normal(); });
  for (int i = 0; i < 15; ++i) cloud.points.push_back({1000.0 + i, 500.0 * i, 0});
  EXPECT_GE(share_of(cloud), 0.97);
}

TEST(Layers, filters_and_degenerate_clouds) {
  Cloud cloud =
      scene([](double, double, FieldRandom& r) { return (r.uniform() < 0.5 ? 0.2 : 0) + 0.002 * r.normal(); });
  Attribute classes{"classification", {}};
  for (const Point3& p : cloud.points) classes.values.push_back(p.z > 0.1 ? 5 : 2);
  cloud.attributes.push_back(classes);
  ProjectOptions ground;
  ground.classes = {2};
  EXPECT_LE(share_of(cloud, ground), 0.005);
  EXPECT_EQ(share_of(make_cloud({{1, 2, 3}})), 0);
  Cloud equal = make_cloud({});
  for (int i = 0; i < 5000; ++i) equal.points.push_back({3, 4, 5});
  EXPECT_EQ(share_of(equal), 0);
  EXPECT_THROW((void)layered_share(make_cloud({}), Pose{}, Frame{}, {}, {}), InputError);
}

// Real scans
// -----------------------------------------------------------------------------------------------------------

// Points of a text file: lines "x y z" once `start` has been met, each after `skip` words.
Cloud read_text(const std::filesystem::path& path, const std::string& start, const std::string& first_word) {
  std::ifstream file(path);
  Cloud cloud = make_cloud({});
  std::string line;
  while (!start.empty() && std::getline(file, line) && line.rfind(start, 0) != 0) {
  }
  while (std::getline(file, line)) {
    std::istringstream words(line);
    std::string word;
    Point3 p{};
    if (!first_word.empty() && !(words >> word && word == first_word)) continue;
    if (words >> p.x >> p.y >> p.z) cloud.points.push_back(p);
  }
  return cloud;
}

TEST(Layers, real_terrain_has_none) {
  ISOPACH_SHARED_OR_SKIP(path, "msh-dome/msh_2004-10-11.xyz");
  EXPECT_LE(share_of(read_text(path, "", "")), 0.01);
}

TEST(Layers, real_range_scan_has_hardly_any_along_its_own_direction) {
  ISOPACH_SHARED_OR_SKIP(path, "stanford-bunny-range/bun000.ply");
  Cloud cloud = read_text(path, "end_header", "");
  cloud.points.resize(40256);  // the range grid follows
  EXPECT_LE(share_of(cloud), 0.02);
  ProjectOptions sideways;
  sideways.direction.kind = Direction::Kind::axis_x;
  EXPECT_GE(share_of(cloud, sideways), 0.3);
}

TEST(Layers, real_head_has_many_and_its_front_few) {
  ISOPACH_SHARED_OR_SKIP(path, "leeperrysmith/LeePerrySmith.obj");
  Cloud head = read_text(path, "", "v");
  EXPECT_GE(share_of(head), 0.35);
  Cloud front = make_cloud({});
  for (const Point3& p : head.points)
    if (p.z > 0) front.points.push_back(p);
  EXPECT_LE(share_of(front), 0.05);
}

}  // namespace
}  // namespace isopach::test
