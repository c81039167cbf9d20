// The mean face is symmetric, has its tip at the origin, and its relief is what no smooth form explains.
#include "isopach/apps/face_template.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace isopach {
namespace {

TEST(FaceTemplate, IsSymmetricAndEvenlySampled) {
  const FaceTemplate& face = face_template();
  EXPECT_GT(face.points.size(), 550u);
  EXPECT_LT(face.points.size(), 1100u);
  ASSERT_EQ(face.points.size(), face.relief.size());
  double out = -1;
  for (const TemplatePoint& t : face.points) {
    const Point3 &p = t.point, &n = t.normal;
    EXPECT_NEAR(n.x * n.x + n.y * n.y + n.z * n.z, 1, 1e-12);
    EXPECT_LE(std::fabs(p.x), 0.5);
    const auto mirror = [&](const TemplatePoint& o) {
      return o.point.x == -p.x && o.point.y == p.y && o.point.z == p.z;
    };
    EXPECT_TRUE(std::any_of(face.points.begin(), face.points.end(), mirror));
    out = std::max(out, p.z);
  }
  EXPECT_NEAR(out, 0, 0.02);  // the tip of the nose, which points lie near
  EXPECT_NEAR(face.hairline - face.chin, 1.1, 0.1);
}

TEST(FaceTemplate, ReliefHasNoForm) {
  const FaceTemplate& face = face_template();
  for (std::size_t term = 0; term < form_terms; ++term) {
    double sum = 0, size = 0;
    for (std::size_t k = 0; k < face.points.size(); ++k) {
      const double t = form_of_face(face.points[k].point)[term];
      sum += t * face.relief[k];
      size += t * t;
    }
    EXPECT_NEAR(sum / std::sqrt(size), 0, 1e-9) << term;
  }
}

}  // namespace
}  // namespace isopach
