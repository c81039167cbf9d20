// project: what is kept, what is merged, in which order, and that nothing depends on order or threads.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/field/height_field.hpp"
#include "tests/field/clouds.hpp"

namespace isopach::test {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();

HeightField field_of(const Cloud& cloud, const ProjectOptions& options = {}) {
  return project(cloud, Pose{}, choose_frame(cloud, cloud, Pose{}, options, {}), options, {});
}

ProjectOptions merging(DuplicatePolicy policy) {
  ProjectOptions options;
  options.duplicates = policy;
  return options;
}

std::string input_error(const Cloud& cloud, const ProjectOptions& options, const Frame& frame = {}) {
  try {
    (void)project(cloud, Pose{}, frame, options, {});
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

bool same_nodes(const HeightField& a, const HeightField& b) { return same_bits(a.xy, b.xy) && same_bits(a.z, b.z); }

// A cloud on a coarse lattice: most places hold several points of different heights.
Cloud crowded_cloud(std::size_t n, std::uint64_t seed) {
  FieldRandom random(seed);
  Cloud cloud = make_cloud({});
  for (std::size_t i = 0; i < n; ++i)
    cloud.points.push_back(
        {static_cast<double>(random.below(60)) / 7, static_cast<double>(random.below(50)) / 3, random.uniform(-1, 1)});
  return cloud;
}

// Brute force: groups by place, in a map.
std::map<std::pair<double, double>, std::vector<double>> groups_of(const Cloud& cloud) {
  std::map<std::pair<double, double>, std::vector<double>> groups;
  for (const Point3& p : cloud.points) groups[{p.x, p.y}].push_back(p.z);
  for (auto& [place, heights] : groups) std::sort(heights.begin(), heights.end());
  return groups;
}

TEST(Project, nodes_are_the_points_in_curve_order) {
  const Cloud cloud = smooth_cloud(9000, 1);
  const Frame frame = choose_frame(cloud, cloud, Pose{}, {}, {});
  const HeightField field = field_of(cloud);
  ASSERT_EQ(field.xy.size(), cloud.points.size());
  ASSERT_EQ(field.z.size(), cloud.points.size());
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const Index node = field.node_of_point[i];
    ASSERT_LT(node, field.z.size());
    EXPECT_EQ(frame.to_input({field.xy[node].x, field.xy[node].y, field.z[node]}), cloud.points[i]);
  }
  for (std::size_t k = 1; k < field.xy.size(); ++k)
    ASSERT_LE(curve_key(frame.curve, field.xy[k - 1]), curve_key(frame.curve, field.xy[k]));
  EXPECT_EQ(field.cleaning.points, 9000U);
  EXPECT_EQ(field.cleaning.duplicates, 0U);
  EXPECT_EQ(field.cleaning.duplicate_max_spread, 0);
}

TEST(Project, each_policy_merges_as_it_says) {
  const Cloud cloud = make_cloud({{1, 1, 5}, {2, 2, 0}, {1, 1, 1}, {1, 1, 3}, {1, 1, 11}, {0, 2, 7}});
  const auto height = [&](DuplicatePolicy policy) {
    const HeightField field = field_of(cloud, merging(policy));
    EXPECT_EQ(field.xy.size(), 3U);
    EXPECT_EQ(field.cleaning.duplicates, 3U);
    EXPECT_EQ(field.cleaning.duplicate_max_spread, 10);
    for (const std::size_t i : {2, 3, 4}) EXPECT_EQ(field.node_of_point[i], field.node_of_point[0]);
    EXPECT_EQ(field.z[field.node_of_point[5]], 7);
    return field.z[field.node_of_point[0]];
  };
  EXPECT_EQ(height(DuplicatePolicy::mean), 5);
  EXPECT_EQ(height(DuplicatePolicy::min), 1);
  EXPECT_EQ(height(DuplicatePolicy::max), 11);
  EXPECT_EQ(height(DuplicatePolicy::median), 4);
  EXPECT_EQ(height(DuplicatePolicy::first), 5);
}

TEST(Project, median_of_an_odd_number_is_the_middle_one) {
  const Cloud cloud = make_cloud({{1, 1, 9}, {1, 1, 1}, {1, 1, 2}, {0, 0, 0}});
  const HeightField field = field_of(cloud, merging(DuplicatePolicy::median));
  EXPECT_EQ(field.z[field.node_of_point[0]], 2);
}

TEST(Project, policy_error_names_file_number_place_and_remedy) {
  const Cloud cloud = make_cloud({{1, 1, 5}, {2.5, 2, 0}, {1, 1, 1}, {1, 1, 5}});
  const std::string message = input_error(cloud, merging(DuplicatePolicy::error));
  EXPECT_NE(message.find("made.xyz: 2 points"), std::string::npos) << message;
  EXPECT_NE(message.find("first at 1, 1, 5"), std::string::npos) << message;
  EXPECT_NE(message.find("mean, min, max, median or first"), std::string::npos) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos);
  EXPECT_EQ(field_of(make_cloud({{1, 1, 5}, {2, 2, 0}}), merging(DuplicatePolicy::error)).xy.size(), 2U);
}

TEST(Project, equals_brute_force_on_crowded_places) {
  const Cloud cloud = crowded_cloud(20000, 3);
  const auto groups = groups_of(cloud);
  double spread = 0;
  for (const auto& [place, heights] : groups) spread = std::max(spread, heights.back() - heights.front());
  for (const auto policy :
       {DuplicatePolicy::mean, DuplicatePolicy::min, DuplicatePolicy::max, DuplicatePolicy::median}) {
    const HeightField field = field_of(cloud, merging(policy));
    ASSERT_EQ(field.xy.size(), groups.size());
    EXPECT_EQ(field.cleaning.duplicates, cloud.points.size() - groups.size());
    EXPECT_EQ(field.cleaning.duplicate_max_spread, spread);
    for (std::size_t i = 0; i < field.xy.size(); ++i) {
      const auto& z = groups.at({field.xy[i].x, field.xy[i].y});
      const double middle = (z[(z.size() - 1) / 2] + z[z.size() / 2]) / 2;
      if (policy == DuplicatePolicy::min) {
        ASSERT_EQ(field.z[i], z.front());
      } else if (policy == DuplicatePolicy::max) {
        ASSERT_EQ(field.z[i], z.back());
      } else if (policy == DuplicatePolicy::median) {
        ASSERT_NEAR(field.z[i], middle, 1e-15);
      } else {
        long double sum = 0;
        for (const double h : z) sum += h;
        ASSERT_NEAR(field.z[i], static_cast<double>(sum / static_cast<long double>(z.size())), 1e-15);
      }
    }
  }
}

TEST(Project, mean_of_equal_heights_keeps_their_bits) {
  for (const std::size_t n : {3, 7, 49, 1000}) {
    Cloud cloud = make_cloud({{5, 5, 0}});
    for (std::size_t i = 0; i < n; ++i) cloud.points.push_back({1, 2, 0.1});
    const HeightField field = project(cloud, Pose{}, Frame{}, {}, {});
    EXPECT_EQ(field.z[field.node_of_point[1]], 0.1);
  }
}

TEST(Project, order_of_the_points_does_not_matter) {
  Cloud cloud = crowded_cloud(30000, 5);
  for (const Point3& p : smooth_cloud(20000, 6).points) cloud.points.push_back(p);
  for (const auto policy :
       {DuplicatePolicy::mean, DuplicatePolicy::min, DuplicatePolicy::max, DuplicatePolicy::median}) {
    const HeightField field = field_of(cloud, merging(policy));
    Cloud shuffled = cloud;
    FieldRandom(17).shuffle(shuffled.points);
    EXPECT_TRUE(same_nodes(field, field_of(shuffled, merging(policy))));
  }
}

TEST(Project, first_takes_the_lowest_index) {
  Cloud cloud = crowded_cloud(20000, 5);
  const HeightField field = field_of(cloud, merging(DuplicatePolicy::first));
  std::vector<bool> seen(field.xy.size());
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const Index node = field.node_of_point[i];
    if (!seen[node]) {
      EXPECT_EQ(field.z[node], cloud.points[i].z);
    }
    seen[node] = true;
  }
}

TEST(Project, number_of_threads_does_not_matter) {
  Cloud cloud = crowded_cloud(30000, 5);
  for (const Point3& p : smooth_cloud(30000, 6).points) cloud.points.push_back(p);
  for (std::size_t i = 0; i < cloud.points.size(); i += 10) cloud.points[i].z = NAN;
  HeightField one;
  run_with_threads(1, [&] { one = field_of(cloud); });
  for (const int threads : {2, 7})
    run_with_threads(threads, [&] {
      const HeightField field = field_of(cloud);
      EXPECT_TRUE(same_nodes(one, field));
      EXPECT_TRUE(same_bits(one.node_of_point, field.node_of_point));
      EXPECT_EQ(one.cleaning.duplicates, field.cleaning.duplicates);
      EXPECT_EQ(one.cleaning.duplicate_max_spread, field.cleaning.duplicate_max_spread);
    });
}

TEST(Project, minus_zero_is_zero) {
  const Cloud cloud = make_cloud({{-0.0, 0.0, 1}, {0.0, -0.0, 3}, {1, 1, -0.0}});
  const HeightField field = field_of(cloud);
  ASSERT_EQ(field.xy.size(), 2U);
  const Index node = field.node_of_point[0];
  EXPECT_FALSE(std::signbit(field.xy[node].x) || std::signbit(field.xy[node].y));
  EXPECT_EQ(field.z[node], 2);
  EXPECT_FALSE(std::signbit(field.z[field.node_of_point[2]]));
  const Point3 zero = Frame{}.to_field({-0.0, -1, -0.0});  // every term of x is -0 here
  EXPECT_FALSE(std::signbit(zero.x) || std::signbit(zero.z));
}

TEST(Project, points_that_are_not_finite_are_dropped_and_counted) {
  const Cloud cloud = make_cloud({{NAN, 0, 0}, {1, 2, 3}, {0, inf, 0}, {4, 5, 6}, {0, 0, -inf}, {7, 9, NAN}});
  const HeightField field = field_of(cloud);
  EXPECT_EQ(field.cleaning.points, 6U);
  EXPECT_EQ(field.cleaning.dropped_nonfinite, 4U);
  EXPECT_EQ(field.xy.size(), 2U);
  for (const std::size_t i : {0, 2, 4, 5}) EXPECT_EQ(field.node_of_point[i], no_index);
  EXPECT_EQ(field.z[field.node_of_point[1]], 3);
  EXPECT_EQ(field.z[field.node_of_point[3]], 6);
}

TEST(Project, classes_keep_only_what_is_asked_for) {
  Cloud cloud = make_cloud({{0, 0, 1}, {1, 0, 2}, {0, 1, 3}, {1, 1, 4}});
  cloud.attributes.push_back({"classification", {2, 5, 8, 2}});
  ProjectOptions options;
  options.classes = {2, 8};
  const HeightField field = field_of(cloud, options);
  EXPECT_EQ(field.xy.size(), 3U);
  EXPECT_EQ(field.cleaning.dropped_class, 1U);
  EXPECT_EQ(field.node_of_point[1], no_index);
  options.classes = {7};
  EXPECT_NE(input_error(cloud, options).find("4 by class"), std::string::npos);
}

TEST(Project, classes_without_the_attribute_are_refused) {
  ProjectOptions options;
  options.classes = {2};
  EXPECT_NE(input_error(make_cloud({{0, 0, 1}}), options).find("made.xyz: points have no classification"),
            std::string::npos);
}

TEST(Project, crop_is_a_closed_box_in_input_coordinates) {
  const Cloud cloud = make_cloud({{0, 0, 1}, {1, 2, 2}, {2, 3, 3}, {2.0000001, 3, 4}, {1, 3.5, 5}});
  for (const auto kind : {Direction::Kind::axis_x, Direction::Kind::axis_z}) {
    ProjectOptions options;
    options.direction.kind = kind;
    options.crop = Box2{{0, 0}, {2, 3}};
    const HeightField field = field_of(cloud, options);
    EXPECT_EQ(field.cleaning.dropped_crop, 2U);
    EXPECT_EQ(field.node_of_point[3], no_index);
    EXPECT_EQ(field.node_of_point[4], no_index);
    EXPECT_EQ(field.xy.size(), 3U);
  }
}

TEST(Project, pose_comes_before_crop_and_frame) {
  const Cloud cloud = make_cloud({{0, 0, 1}, {1, 2, 2}});
  Pose pose;
  pose.m = {0, -1, 0, 10, 1, 0, 0, 20, 0, 0, 1, 30, 0, 0, 0, 1};  // quarter turn about z, then a shift
  ProjectOptions options;
  options.crop = Box2{{7, 20}, {9, 22}};
  const HeightField field = project(cloud, pose, Frame{}, options, {});
  EXPECT_EQ(field.node_of_point[0], no_index);
  ASSERT_EQ(field.xy.size(), 1U);
  EXPECT_EQ(field.xy[0], (Point2{8, 21}));
  EXPECT_EQ(field.z[0], 32);
}

TEST(Project, degenerate_clouds) {
  EXPECT_EQ(field_of(make_cloud({{3, 4, 5}})).xy.size(), 1U);
  Cloud equal = make_cloud({});
  for (int i = 0; i < 10000; ++i) equal.points.push_back({3, 4, 5});
  const HeightField field = field_of(equal);
  EXPECT_EQ(field.xy.size(), 1U);
  EXPECT_EQ(field.cleaning.duplicates, 9999U);
  EXPECT_EQ(field.cleaning.duplicate_max_spread, 0);
  for (const Index node : field.node_of_point) EXPECT_EQ(node, 0U);
  const std::string message = input_error(make_cloud({{NAN, 0, 0}, {0, NAN, 0}}), {});
  EXPECT_NE(message.find("made.xyz: no point is left of 2 (dropped: 2 not finite"), std::string::npos) << message;
  EXPECT_NE(input_error(make_cloud({}), {}).find("no point is left of 0"), std::string::npos);
}

TEST(Project, stops_when_cancelled) {
  const std::atomic<bool> cancelled{true};
  Context context;
  context.cancelled = &cancelled;
  EXPECT_THROW((void)project(smooth_cloud(10, 1), Pose{}, Frame{}, {}, context), Interrupted);
}

}  // namespace
}  // namespace isopach::test
