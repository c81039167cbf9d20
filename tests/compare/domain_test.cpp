// Polygons and masks as values: what a program makes itself, with and without what GDAL knows of it. Files and the
// cutting itself: tests/cli/domain_test.py, tests/measure/source_test.cpp.
#include "isopach/compare/domain.hpp"

#include <gtest/gtest.h>

#include "isopach/base/error.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/io/polygons.hpp"
#include "tests/support/clouds.hpp"

namespace isopach::test {
namespace {

using Ring = std::vector<Point2>;

PolygonSet one_polygon(const Ring& ring) {
  PolygonSet set;
  set.path = "site";
  set.polygons = {{"field", {ring}}};
  return set;
}

const Ring bow_tie{{0.1, 0.1}, {0.9, 0.9}, {0.9, 0.1}, {0.1, 0.9}};  // two triangles of 0.16 each
const Ring square{{0.25, 0.25}, {0.75, 0.25}, {0.75, 0.75}, {0.25, 0.75}};

class Area : public testing::Test {
 protected:
  Area() { options_.check_layers = false; }
  Comparison compared() { return compare(a_, b_, options_, {}); }
  std::string refusal() {
    try {
      (void)compared();
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  }

  Cloud a_ = cloud_over(framed_square(300, 1), [](const Point2&) { return 1; });
  Cloud b_ = cloud_over(framed_square(200, 2), [](const Point2&) { return 1.5; });
  CompareOptions options_;
};

TEST_F(Area, MayBePolygonsAndAMaskInMemory) {
  options_.area.include = {one_polygon(square)};
  options_.area.mask = Mask{"south", "", edges_of({"", {{{0, 0}, {1, 0}, {1, 0.5}, {0, 0.5}}}}), {}, {}};
  const Comparison c = compared();
  EXPECT_NEAR(c.measures.area, 0.125, 1e-14);
  EXPECT_NEAR(c.measures.volume.net, 0.0625, 1e-14);
  ASSERT_EQ(c.budget.size(), 1u);
  EXPECT_EQ(c.budget[0].name, "field");
  EXPECT_EQ(c.budget[0].file, "site");
  EXPECT_NEAR(c.budget[0].coverage, 0.5, 1e-14);
}

TEST_F(Area, CrossingSidesAreMendedByWhomeverKnowsHow) {
  options_.area.include = {one_polygon(bow_tie)};
  EXPECT_NE(refusal().find("site: polygon 'field' has no area, or crosses itself near"), std::string::npos)
      << refusal();
  options_.area.include[0].geo = geo_functions();
  const Comparison c = compared();
  EXPECT_NEAR(c.measures.area, 0.32, 1e-12);
  ASSERT_FALSE(c.warnings.empty());
  EXPECT_NE(c.warnings[0].find("it was mended"), std::string::npos) << c.warnings[0];
}

TEST_F(Area, CornersTooFarAwayToReckonWithAreRefused) {
  const Ring far{{0, 0}, {1e308, 5}, {-1e308, 1}}, near{{0, 0}, {1e59, 5}, {0.5, 1}};
  options_.area.budget = {one_polygon(far)};
  EXPECT_EQ(refusal(),
            "site: polygon 'field' has a corner at (1e+308, 5), farther than 1e+60 from the scans: mend the file");
  options_.area.budget = {one_polygon(near)};
  EXPECT_EQ(refusal(), "");
  options_.area.budget.clear();
  options_.area.mask = Mask{"south", "", edges_of({"", {far}}), {}, {}};
  EXPECT_NE(refusal().find("south: @mask has a corner at (1e+308, 5)"), std::string::npos) << refusal();
}

TEST_F(Area, CoordinateSystemsAreComparedAsTextsWithoutGdal) {
  a_.crs = b_.crs = "EPSG:25832+5783";  // with a system of heights
  a_.unit = b_.unit = "m";
  options_.area.include = {one_polygon(square)};
  options_.area.include[0].crs = "EPSG:25832";
  const std::string said = refusal();
  EXPECT_NE(said.find("its CRS is EPSG:25832, that of the scans EPSG:25832+5783"), std::string::npos) << said;
  options_.area.include[0].geo = geo_functions();
  EXPECT_EQ(refusal(), "");
  options_.area.include[0].crs = "EPSG:25833";
  EXPECT_NE(refusal().find("its CRS is EPSG:25833"), std::string::npos) << refusal();
  options_.allow_crs = true;
  EXPECT_EQ(refusal(), "");
}

}  // namespace
}  // namespace isopach::test
