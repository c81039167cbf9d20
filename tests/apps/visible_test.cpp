// What is seen of two plates one above the other, from any direction.
#include "isopach/apps/visible.hpp"

#include <gtest/gtest.h>

#include "isopach/base/error.hpp"

namespace isopach {
namespace {

/// A plate of n by n points at height z over [x, x + side]², with faces; its points carry their height as an attribute.
void add_plate(Cloud& cloud, int n, double x, double side, double z) {
  const auto first = static_cast<Index>(cloud.points.size());
  const auto width = static_cast<Index>(n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      cloud.points.push_back({x + side * i / (n - 1), x + side * j / (n - 1), z});
      cloud.attributes[0].values.push_back(z);
    }
  for (Index i = 0; i + 1 < width; ++i)
    for (Index j = 0; j + 1 < width; ++j) {
      const Index a = first + i * width + j, b = a + width;
      cloud.faces.push_back({a, b, a + 1});
      cloud.faces.push_back({b, b + 1, a + 1});
    }
}

Cloud plates() {
  Cloud cloud;
  cloud.attributes.push_back({"level", {}});
  add_plate(cloud, 21, 0, 20, 0);
  add_plate(cloud, 10, 4.5, 9, 5);  // over the lower points 5 to 13 in x and y
  return cloud;
}

Cloud seen(const Cloud& cloud, const Pose& pose = {}, const ProjectOptions& options = {}) {
  return visible_part(cloud, pose, choose_frame(cloud, cloud, pose, options, {}), options, {});
}

TEST(Visible, WhatLiesUnderAPlateIsHidden) {
  const Cloud cloud = plates(), visible = seen(cloud);
  EXPECT_EQ(cloud.points.size() - visible.points.size(), 81u);
  ASSERT_EQ(visible.attributes[0].values.size(), visible.points.size());
  for (std::size_t i = 0; i < visible.points.size(); ++i) {
    const Point3& p = visible.points[i];
    EXPECT_EQ(visible.attributes[0].values[i], p.z);
    EXPECT_FALSE(p.z == 0 && p.x > 4.5 && p.x < 13.5 && p.y > 4.5 && p.y < 13.5) << p.x << " " << p.y;
  }
  // In two corners of the hole one triangle of the cell has none of the hidden points.
  EXPECT_EQ(visible.faces.size(), 2u * (20 * 20 - 10 * 10 + 9 * 9) + 2);
  for (const auto& f : visible.faces)
    for (const Index corner : f) EXPECT_EQ(visible.points[corner].z, visible.points[f[0]].z);
  ASSERT_EQ(visible.notes.size(), 1u);
  EXPECT_NE(visible.notes[0].find("81 of 541"), std::string::npos) << visible.notes[0];
}

TEST(Visible, FromBelowTheUpperPlateIsHidden) {
  ProjectOptions from_below;
  from_below.direction = {Direction::Kind::vector, {0, 0, -1}};
  EXPECT_EQ(seen(plates(), {}, from_below).points.size(), 441u);
  Pose turned;  // about x by half a turn: the same
  turned.m[5] = turned.m[10] = -1;
  EXPECT_EQ(seen(plates(), turned).points.size(), 441u);
}

TEST(Visible, WithoutFacesItIsRefused) {
  Cloud cloud = plates();
  cloud.faces.clear();
  EXPECT_THROW((void)seen(cloud), UsageError);
}

}  // namespace
}  // namespace isopach
