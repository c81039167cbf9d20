// M3C2 against every point tried, closed forms, and the results of CloudCompare and PDAL on real data.
#include "isopach/distance/m3c2.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "isopach/base/parallel.hpp"
#include "isopach/distance/vectors.hpp"
#include "isopach/io/read.hpp"
#include "tests/support/random.hpp"
#include "tests/support/shared_data.hpp"

namespace isopach {
namespace {

std::vector<Point3> rough_plane(std::size_t n, double slope, double lift, double noise, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<Point3> points;
  for (std::size_t i = 0; i < n; ++i) {
    const double x = random.uniform(0, 10), y = random.uniform(0, 10);
    points.push_back({x, y, slope * x + lift + noise * random.bell()});
  }
  return points;
}

M3c2Options options(double D, double d, double depth, double reg = 0) { return {D, d, depth, reg}; }

struct Brute {
  std::size_t n = 0;
  double mean = 0, sigma = 0;
};
Brute brute(const std::vector<Point3>& points, const Point3& core, const Point3& normal, const M3c2Options& o) {
  std::vector<double> along;
  for (const Point3& p : points) {
    const Point3 d = p - core;
    const double t = dot(d, normal);
    if (std::fabs(t) <= o.max_depth && length(d - t * normal) <= o.projection_scale / 2) along.push_back(t);
  }
  Brute b;
  b.n = along.size();
  for (const double t : along) b.mean += t / static_cast<double>(b.n);
  for (const double t : along) b.sigma += (t - b.mean) * (t - b.mean) / static_cast<double>(b.n);
  b.sigma = std::sqrt(b.sigma);
  return b;
}

TEST(M3c2, IsThatOfEveryPointTried) {
  const auto a = rough_plane(600, 0.4, 0, 0.3, 1), b = rough_plane(500, 0.4, 0.6, 0.3, 2);
  for (const M3c2Options& o : {options(3, 2, 1), options(1.5, 0.5, 8), options(3, 2, 0.4, 0.02), options(4, 0.3, 40)}) {
    const M3c2Field f = m3c2(a, b, a, o, {});
    std::size_t measured = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      if (std::isnan(f.normal[i].x)) continue;
      EXPECT_NEAR(length(f.normal[i]), 1, 1e-14);
      EXPECT_GE(f.normal[i].z, 0);
      const Brute s1 = brute(a, a[i], f.normal[i], o), s2 = brute(b, a[i], f.normal[i], o);
      ASSERT_EQ(f.n1[i], static_cast<double>(s1.n));
      ASSERT_EQ(f.n2[i], static_cast<double>(s2.n));
      ASSERT_EQ(std::isnan(f.distance[i]), s1.n == 0 || s2.n == 0);
      ASSERT_EQ(std::isnan(f.lod[i]), s1.n < 4 || s2.n < 4);
      if (std::isnan(f.distance[i])) continue;
      ++measured;
      EXPECT_NEAR(f.distance[i], s2.mean - s1.mean, 1e-12);
      EXPECT_NEAR(f.sigma1[i], s1.sigma, 1e-12);
      EXPECT_NEAR(f.sigma2[i], s2.sigma, 1e-12);
      if (std::isnan(f.lod[i])) {
        EXPECT_EQ(f.significant[i], 0);
        continue;
      }
      const double variance = s1.sigma * s1.sigma / f.n1[i] + s2.sigma * s2.sigma / f.n2[i];
      EXPECT_NEAR(f.lod[i], 1.96 * (std::sqrt(variance) + o.registration_error), 1e-12);
      EXPECT_EQ(f.significant[i], std::fabs(f.distance[i]) > f.lod[i] ? 1 : 0);
    }
    EXPECT_GT(measured, 10u);
  }
}

TEST(M3c2, PlanesApartByAKnownDistance) {
  const auto a = rough_plane(2000, 0.75, 0, 0, 1), b = rough_plane(2000, 0.75, 0.5, 0, 2);
  const std::vector<Point3> cores{{5, 5, 3.75}, {3, 7, 2.25}};
  const M3c2Field f = m3c2(a, b, cores, options(2, 1, 3), {});
  for (std::size_t i = 0; i < cores.size(); ++i) {
    EXPECT_NEAR(f.normal[i].x, -0.6, 1e-12);
    EXPECT_NEAR(f.normal[i].y, 0, 1e-12);
    EXPECT_NEAR(f.normal[i].z, 0.8, 1e-12);
    EXPECT_NEAR(f.distance[i], 0.4, 1e-12);  // 0.5 up, along a normal that is 0.8 up
    EXPECT_LT(f.lod[i], 1e-9);
    EXPECT_EQ(f.significant[i], 1);
  }
  const M3c2Field loose = m3c2(a, b, cores, options(2, 1, 3, 0.3), {});
  EXPECT_NEAR(loose.lod[0], 1.96 * 0.3, 1e-9);
  EXPECT_EQ(loose.significant[0], 0);
  const M3c2Field shallow = m3c2(a, b, cores, options(2, 1, 0.3), {});
  EXPECT_TRUE(std::isnan(shallow.distance[0]));
  EXPECT_EQ(shallow.n2[0], 0);
}

TEST(M3c2, NoNormalFromALineOrTwoPoints) {
  const std::vector<Point3> line{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}}, two{{0, 0, 0}, {1, 0, 0}};
  for (const auto& a : {line, two}) {
    const M3c2Field f = m3c2(a, line, a, options(10, 10, 10), {});
    EXPECT_TRUE(std::isnan(f.distance[0]));
    EXPECT_TRUE(std::isnan(f.normal[0].z));
    EXPECT_EQ(f.significant[0], 0);
  }
}

TEST(M3c2, LevelOfDetectionHoldsAt95Percent) {
  // Two scans of one plane: a core point is called changed once in twenty. (A few more: σ is estimated, divided by n.)
  const auto a = rough_plane(60000, 0, 0, 0.05, 1), b = rough_plane(60000, 0, 0, 0.05, 2);
  test::Random random(3);
  std::vector<Point3> cores;
  for (int i = 0; i < 2000; ++i) cores.push_back({random.uniform(1, 9), random.uniform(1, 9), 0});
  const M3c2Field f = m3c2(a, b, cores, options(1.5, 0.5, 1), {});
  double significant = 0;
  for (const double s : f.significant) significant += s;
  EXPECT_GT(significant, 0.03 * 2000);
  EXPECT_LT(significant, 0.08 * 2000);
}

TEST(M3c2, SameBitsForAnyThreadsAndOrder) {
  auto a = rough_plane(3000, 0.4, 0, 0.3, 1), b = rough_plane(2500, 0.4, 0.6, 0.3, 2);
  const auto cores = a;
  std::vector<M3c2Field> all;
  for (const int threads : {1, 4})
    run_with_threads(threads, [&] { all.push_back(m3c2(a, b, cores, options(2, 1, 3), {})); });
  test::Random random(4);
  random.shuffle(a), random.shuffle(b);
  all.push_back(m3c2(a, b, cores, options(2, 1, 3), {}));
  for (const M3c2Field& f : all)
    for (std::size_t i = 0; i < cores.size(); ++i) {
      EXPECT_EQ(f.n2[i], all[0].n2[i]);
      if (!std::isnan(all[0].lod[i])) {
        EXPECT_EQ(f.lod[i], all[0].lod[i]);
      }
    }
}

/// A table with a header line of quoted names.
class Table {
 public:
  explicit Table(const std::filesystem::path& path) {
    std::ifstream file(path);
    std::string line;
    std::getline(file, line);
    std::istringstream head(line);
    for (std::string name; std::getline(head, name, ',');) names_.push_back(name.substr(1, name.size() - 2));
    while (std::getline(file, line)) {
      std::istringstream cells(line);
      rows_.emplace_back();
      for (std::string cell; std::getline(cells, cell, ',');)
        rows_.back().push_back(std::strtod(cell.c_str(), nullptr));
    }
  }
  [[nodiscard]] std::size_t rows() const { return rows_.size(); }
  [[nodiscard]] double at(std::size_t row, const std::string& name) const {
    const auto found = std::find(names_.begin(), names_.end(), name);
    return rows_.at(row).at(static_cast<std::size_t>(found - names_.begin()));
  }

 private:
  std::vector<std::string> names_;
  std::vector<std::vector<double>> rows_;
};

// Two airborne surveys of a track, 829 and 687 points, 103 core points; the references were made with radii 1.390432
// and 2.890432 and half length 5.5, and print three decimals.
class Autzen : public testing::Test {
 protected:
  void measure(const std::filesystem::path& folder) {
    const auto points = [&](const char* name) {
      const Cloud cloud = read_cloud((folder / name).string(), {}, {});
      return std::vector<Point3>(cloud.points.begin(), cloud.points.end());
    };
    a = points("autzen-bmx-2010.las"), b = points("autzen-bmx-2023.las");
    const Table table(folder / "autzen-bmx-cc.txt");
    for (std::size_t i = 0; i < table.rows(); ++i)
      cores.push_back({table.at(i, "X"), table.at(i, "Y"), table.at(i, "Z")});
    field = m3c2(a, b, cores, parameters, {});
  }
  const M3c2Options parameters = options(2 * 1.390432, 2 * 2.890432, 5.5);
  std::vector<Point3> a, b, cores;
  M3c2Field field;
};

TEST_F(Autzen, AgreesWithPdal) {
  ISOPACH_SHARED_OR_SKIP(folder, "autzen-bmx");
  measure(folder);
  const Table table(folder / "autzen-bmx-m3c2.txt");
  constexpr double printed = 0.0011;
  int same = 0, none = 0;
  for (std::size_t i = 0; i < cores.size(); ++i) {
    SCOPED_TRACE(i);
    const double n1 = table.at(i, "m3c2_count1"), n2 = table.at(i, "m3c2_count2");
    if (n1 == 0) {  // left out there: a core without a normal, or without points in both scans
      EXPECT_TRUE(std::isnan(field.distance[i]));
      ++none;
      continue;
    }
    EXPECT_EQ(field.n2[i], n2);
    if (i == 0) {  // it drops the nearest point of a core that is the first point of the first cloud
      EXPECT_EQ(field.n1[i], n1 + 1);
      continue;
    }
    EXPECT_EQ(field.n1[i], n1);
    EXPECT_NEAR(field.distance[i], table.at(i, "m3c2_distance"), printed);
    EXPECT_NEAR(field.sigma1[i], table.at(i, "m3c2_std_dev1"), printed);
    EXPECT_NEAR(field.sigma2[i], table.at(i, "m3c2_std_dev2"), printed);
    ++same;
    if (n1 < m3c2_least || n2 < m3c2_least) continue;  // it gives a level of detection even from one point
    EXPECT_NEAR(field.lod[i], table.at(i, "m3c2_uncertainty"), printed);
    EXPECT_EQ(field.significant[i], table.at(i, "m3c2_significant"));
  }
  EXPECT_EQ(same, 90);
  EXPECT_EQ(none, 12);
}

TEST_F(Autzen, AgreesWithCloudCompare) {
  ISOPACH_SHARED_OR_SKIP(folder, "autzen-bmx");
  measure(folder);
  const Table table(folder / "autzen-bmx-cc.txt");
  constexpr double coded = 0.004;  // it stores normals in a few bits, which moves all that is measured along them
  int same = 0, none = 0, rim = 0;
  for (std::size_t i = 0; i < cores.size(); ++i) {
    SCOPED_TRACE(i);
    const Point3 n{table.at(i, "NormalX"), table.at(i, "NormalY"), table.at(i, "NormalZ")};
    if (length(n) == 0) {
      EXPECT_TRUE(std::isnan(field.normal[i].x));
      ++none;
      continue;
    }
    EXPECT_LT(length(field.normal[i] - n), coded);
    const double n1 = table.at(i, "Npoints_cloud1"), n2 = table.at(i, "Npoints_cloud2");
    // With its normal the points in the cylinder are its points, everywhere.
    EXPECT_EQ(static_cast<double>(brute(a, cores[i], (1 / length(n)) * n, parameters).n), n1);
    EXPECT_EQ(static_cast<double>(brute(b, cores[i], (1 / length(n)) * n, parameters).n), n2);
    if (field.n1[i] != n1 || field.n2[i] != n2) {  // with ours, a point on the cylinder's rim is in or out
      EXPECT_EQ(std::fabs(field.n1[i] - n1) + std::fabs(field.n2[i] - n2), 1);
      ++rim;
      continue;
    }
    const double distance = table.at(i, "M3C2 distance"), lod = table.at(i, "distance uncertainty");
    ASSERT_EQ(std::isnan(field.distance[i]), std::isnan(distance));
    ASSERT_EQ(std::isnan(field.lod[i]), std::isnan(lod));
    EXPECT_NEAR(field.sigma1[i], table.at(i, "STD_cloud1"), coded);
    EXPECT_EQ(field.significant[i], table.at(i, "significant change"));
    ++same;
    if (std::isnan(distance)) continue;
    EXPECT_NEAR(field.distance[i], distance, coded);
    EXPECT_NEAR(field.sigma2[i], table.at(i, "STD_cloud2"), coded);
    if (!std::isnan(lod)) {
      EXPECT_NEAR(field.lod[i], lod, coded);
    }
  }
  EXPECT_EQ(same, 93);
  EXPECT_EQ(none, 6);
  EXPECT_EQ(rim, 4);
}

}  // namespace
}  // namespace isopach
