#include "isopach/measure/texture/form.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "isopach/base/array.hpp"
#include "isopach/base/error.hpp"
#include "tests/support/random.hpp"

namespace isopach {
namespace {

struct Nodes {
  Array<Point2> xy;
  Array<double> area, z;
};

Nodes random_nodes(std::size_t n, std::uint64_t seed, double shift = 0) {
  test::Random random(seed);
  Nodes out;
  for (std::size_t i = 0; i < n; ++i) {
    out.xy.push_back({shift + random.uniform(-3, 9), shift + random.uniform(0, 40)});
    out.area.push_back(random.uniform(0, 2));
    out.z.push_back(random.uniform(-1, 1));
  }
  return out;
}

double polynomial(const Point2& p, unsigned degree, double shift) {
  double sum = 0;
  for (unsigned i = 0; i <= degree; ++i)
    for (unsigned j = 0; i + j <= degree; ++j)
      sum += (1 + i - 2.0 * j) * std::pow((p.x - shift) / 9, i) * std::pow((p.y - shift) / 40, j);
  return sum;
}

Array<double> rest(const Nodes& n, unsigned degree) {
  const Form form = fit_form(n.xy, n.area, n.z, degree, {});
  Array<double> out(n.z.size());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = n.z[i] - form.at(n.xy[i]);
  return out;
}

TEST(Form, TakesPolynomialsOutAndNothingElse) {
  for (const double shift : {0.0, 1e6})
    for (unsigned degree = 0; degree <= most_form_degree; ++degree) {
      Nodes n = random_nodes(2000, degree + 1, shift);
      const Array<double> before = rest(n, degree);
      for (std::size_t i = 0; i < n.z.size(); ++i) n.z[i] += polynomial(n.xy[i], degree, shift);
      const Array<double> after = rest(n, degree);
      for (std::size_t i = 0; i < n.z.size(); ++i) EXPECT_NEAR(before[i], after[i], 1e-9) << degree << " at " << shift;
      for (std::size_t i = 0; i < n.z.size(); ++i) n.z[i] = polynomial(n.xy[i], degree, shift);
      for (const double r : rest(n, degree)) EXPECT_NEAR(r, 0, 1e-9) << degree << " at " << shift;
    }
}

TEST(Form, RestIsOrthogonalToEveryTermByArea) {
  const Nodes n = random_nodes(1500, 3);
  const Array<double> r = rest(n, 3);
  for (unsigned i = 0; i <= 3; ++i)
    for (unsigned j = 0; i + j <= 3; ++j) {
      double product = 0, size = 0;
      for (std::size_t k = 0; k < r.size(); ++k) {
        const double term = std::pow(n.xy[k].x / 9, i) * std::pow(n.xy[k].y / 40, j);
        product += n.area[k] * term * r[k], size += std::fabs(n.area[k] * term * r[k]);
      }
      EXPECT_LT(std::fabs(product), 1e-11 * size) << i << " " << j;
    }
}

TEST(Form, NodesWithoutAreaDoNotCount) {
  Nodes n = random_nodes(500, 4);
  for (std::size_t i = 0; i < n.z.size(); ++i) {
    n.z[i] = 1 + 2 * n.xy[i].x;
    if (i % 4 == 0) n.area[i] = 0, n.z[i] = 1e9;
  }
  const Form form = fit_form(n.xy, n.area, n.z, 1, {});
  EXPECT_NEAR(form.at({5, 5}), 11, 1e-9);
}

TEST(Form, FewNodesOrALineGiveTheLeastSolution) {
  Nodes line = random_nodes(100, 5);
  for (std::size_t i = 0; i < line.z.size(); ++i) line.xy[i].y = 2 * line.xy[i].x, line.z[i] = 3 * line.xy[i].x;
  for (const double r : rest(line, 2)) EXPECT_NEAR(r, 0, 1e-8);
  const Nodes two{{{0, 0}, {1, 3}}, {1, 1}, {4, 6}};
  for (const double r : rest(two, 2)) EXPECT_NEAR(r, 0, 1e-9);
  EXPECT_EQ(fit_form({}, {}, {}, 2, {}).at({1, 1}), 0);
}

TEST(Form, RefusesHighDegrees) { EXPECT_THROW((void)fit_form({}, {}, {}, most_form_degree + 1, {}), UsageError); }

}  // namespace
}  // namespace isopach
