// Weighted integrals against closed forms, and against cutting every cell in long double and integrating its pieces by
// products of Gauss rules.
#include "isopach/measure/volume/weight.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/measure/volume/quadrature.hpp"
#include "tests/support/clouds.hpp"
#include "tests/support/formulas.hpp"

namespace isopach::test {
namespace {

using Real = long double;

// --- oracle ---------------------------------------------------------------------------------------------------------

struct GaussPoint {
  Real x, weight;
};
/// Gauss-Legendre on [0, 1], by Newton's method on the Legendre polynomial.
std::vector<GaussPoint> gauss(int n) {
  std::vector<GaussPoint> rule;
  for (int i = 0; i < n; ++i) {
    Real x = std::cos(std::acos(Real(-1)) * (i + Real(0.75)) / (n + Real(0.5))), slope = 1;
    for (int step = 0; step < 50; ++step) {
      Real before = 1, p = x;
      for (int k = 2; k <= n; ++k) {
        const Real next = ((2 * k - 1) * x * p - (k - 1) * before) / k;
        before = p, p = next;
      }
      slope = n * (x * p - before) / (x * x - 1);
      x -= p / slope;
    }
    rule.push_back({(1 - x) / 2, 1 / ((1 - x * x) * slope * slope)});
  }
  return rule;
}

struct Corner {
  Real x, y, z1, d;
};
using Polygon = std::vector<Corner>;
using OfCorner = std::function<Real(const Corner&)>;

/// The part of a convex polygon where the linear function `side` is not negative.
Polygon cut(const Polygon& p, const OfCorner& side) {
  Polygon out;
  for (std::size_t k = 0; k < p.size(); ++k) {
    const Corner &a = p[k], &b = p[(k + 1) % p.size()];
    const Real sa = side(a), sb = side(b);
    if (sa >= 0) out.push_back(a);
    if ((sa > 0 && sb < 0) || (sa < 0 && sb > 0)) {
      const Real t = sa / (sa - sb);
      out.push_back({a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.z1 + t * (b.z1 - a.z1), a.d + t * (b.d - a.d)});
    }
  }
  return out;
}

using OracleWeight = std::function<Real(Real x, Real y, Real z1, Real z2)>;
struct Integrals {
  Real mu = 0, above = 0, below = 0;
};

/// Of a polygon on which d has one sign and μ is smooth.
void add_smooth(const Polygon& p, const OracleWeight& mu, const std::vector<GaussPoint>& rule, Integrals& sum) {
  for (std::size_t k = 2; k < p.size(); ++k) {
    const Corner &a = p[0], &b = p[k - 1], &c = p[k];
    const Real twice = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    for (const GaussPoint& s : rule)
      for (const GaussPoint& t : rule) {
        const Real u = s.x, v = (1 - s.x) * t.x, w = s.weight * t.weight * (1 - s.x) * twice;
        const auto at = [&](Real Corner::*what) { return a.*what + u * (b.*what - a.*what) + v * (c.*what - a.*what); };
        const Real z1 = at(&Corner::z1), d = at(&Corner::d), value = mu(at(&Corner::x), at(&Corner::y), z1, z1 + d);
        sum.mu += w * value;
        (d > 0 ? sum.above : sum.below) += w * value * std::fabs(d);
      }
  }
}

/// μ is smooth on either side of every line x = breaks[i].
void add_broken(const Polygon& p, const OracleWeight& mu, const std::vector<Real>& breaks,
                const std::vector<GaussPoint>& rule, Integrals& sum) {
  Polygon rest = p;
  for (const Real at : breaks) {
    add_smooth(cut(rest, [&](const Corner& c) { return at - c.x; }), mu, rule, sum);
    rest = cut(rest, [&](const Corner& c) { return c.x - at; });
  }
  add_smooth(rest, mu, rule, sum);
}

struct Sample {
  SortedTriangulation mesh;
  std::vector<double> z1, z2;
  std::vector<unsigned char> in_domain;

  [[nodiscard]] CellView view() const { return {mesh.triangulation, mesh.xy, z1, z2, in_domain}; }
  [[nodiscard]] Polygon polygon(std::size_t i) const {
    Polygon p;
    for (const Index v : mesh.triangulation.triangles[i].v)
      p.push_back({mesh.xy[v].x, mesh.xy[v].y, z1[v], Real(z2[v]) - z1[v]});
    return p;
  }
  [[nodiscard]] Integrals oracle(const OracleWeight& mu, const std::vector<Real>& breaks = {}, int order = 12) const {
    const std::vector<GaussPoint> rule = gauss(order);
    Integrals sum;
    for (std::size_t i = 0; i < in_domain.size(); ++i) {
      if (in_domain[i] == 0) continue;
      add_broken(cut(polygon(i), [](const Corner& c) { return c.d; }), mu, breaks, rule, sum);
      add_broken(cut(polygon(i), [](const Corner& c) { return -c.d; }), mu, breaks, rule, sum);
    }
    return sum;
  }
};

using Height2 = std::function<double(const Point2&)>;
Sample sample(const Points& points, const Height2& z1, const Height2& z2) {
  Sample s{triangulate_unsorted(points, {}), {}, {}, {}};
  for (const Point2& p : s.mesh.xy) s.z1.push_back(z1(p)), s.z2.push_back(z2(p));
  s.in_domain.assign(s.mesh.triangulation.real, 1);
  return s;
}
Sample rough_sample(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  Sample s = sample(
      uniform(n, seed), [&](const Point2&) { return random.uniform(-1, 1); },
      [&](const Point2&) { return random.uniform(-1, 1); });
  for (auto& flag : s.in_domain) flag = random.uniform() < 0.9 ? 1 : 0;
  return s;
}

WeightedMeasures weigh_by(const Sample& s, const std::string& formula, const Point3& origin = {}) {
  return weigh(s.view(), {}, ExpressionWeight{formula, Expression(formula, "@weight"), origin}, {});
}

double relative_error(double found, Real expected) {
  return static_cast<double>(std::fabs(found - expected) / std::fabs(expected));
}

void expect_integrals(const WeightedMeasures& found, const Integrals& expected, double tolerance) {
  EXPECT_LE(relative_error(found.integral, expected.mu), tolerance);
  EXPECT_LE(relative_error(found.above, expected.above), tolerance);
  EXPECT_LE(relative_error(found.below, expected.below), tolerance);
  EXPECT_EQ(found.net, found.above - found.below);
}

// --- the rules ------------------------------------------------------------------------------------------------------

TEST(TriangleRule, IntegratesMonomialsUpToItsDegree) {
  const auto factorial = [](int n) {
    double f = 1;
    for (int i = 2; i <= n; ++i) f *= i;
    return f;
  };
  for (int degree = 0; degree <= 9; ++degree)
    for (int i = 0; i <= degree; ++i)
      for (int j = 0; i + j <= degree; ++j) {
        const int k = degree - i - j;
        double high = 0, low = 0;
        for (const QuadraturePoint& q : triangle_rule) {
          EXPECT_NEAR(q.at[0] + q.at[1] + q.at[2], 1, 1e-15);
          const double value = std::pow(q.at[0], i) * std::pow(q.at[1], j) * std::pow(q.at[2], k);
          high += q.high * value, low += q.low * value;
        }
        const double exact = 2 * factorial(i) * factorial(j) * factorial(k) / factorial(degree + 2);
        if (degree <= 8) {
          EXPECT_NEAR(high, exact, 4e-16) << i << j << k;
        }
        if (degree <= 5) {
          EXPECT_NEAR(low, exact, 4e-16) << i << j << k;
        }
        if (degree == 9 && i == 9) {
          EXPECT_GT(std::fabs(high - exact), 1e-6) << "beyond its degree";
        }
      }
}

TEST(TriangleRule, PredictsPolynomialsOfDegreeFourAtTheBorder) {
  for (const BorderPoint& b : triangle_border())
    for (int i = 0; i <= 5; ++i)
      for (int j = 0; i + j <= 5; ++j) {
        const auto value = [&](const std::array<double, 3>& p) { return std::pow(p[0], i) * std::pow(p[1], j); };
        double predicted = 0;
        for (std::size_t k = 0; k < triangle_rule.size(); ++k)
          predicted += b.prediction[k] * value(triangle_rule[k].at);
        if (i + j <= 4) {
          EXPECT_NEAR(predicted, value(b.at), 1e-13);
        } else if (i == 5 && b.at[0] == 1) {
          EXPECT_GT(std::fabs(predicted - value(b.at)), 1e-4) << "beyond its degree";
        }
      }
}

// --- expressions ----------------------------------------------------------------------------------------------------

/// ∫ |x − c| x^a over [0, 1], the parts right and left of c.
std::array<double, 2> moments(double c, int a) {
  const auto primitive = [&](double x) { return std::pow(x, a + 2) / (a + 2) - c * std::pow(x, a + 1) / (a + 1); };
  return {primitive(1) - primitive(c), primitive(0) - primitive(c)};
}

TEST(Weight, OfPolynomialsUpToDegreeFourIsTheClosedForm) {
  const double c = 0.37;
  const Sample s = sample(
      framed_square(400, 3), [](const Point2& p) { return 2 * p.y; },
      [&](const Point2& p) { return 2 * p.y + p.x - c; });
  for (int a = 0; a <= 4; ++a)
    for (int b = 0; a + b <= 4; ++b) {
      const WeightedMeasures m = weigh_by(s, "x^" + std::to_string(a) + " * y^" + std::to_string(b));
      const auto [above, below] = moments(c, a);
      EXPECT_NEAR(m.above, above / (b + 1), 1e-9 * above);
      EXPECT_NEAR(m.below, below / (b + 1), 1e-9 * below) << a << b;
      EXPECT_NEAR(m.integral, 1.0 / (a + 1) / (b + 1), 1e-9);
      EXPECT_NEAR(m.rho, (above + below) / (b + 1), 1e-9);
      EXPECT_LT(m.error_estimate, 1e-13) << "both rules are exact";
    }
}

TEST(Weight, OfPolynomialsOnRoughCellsIsTheOracle) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Sample s = rough_sample(60, seed);
    expect_integrals(weigh_by(s, "(x*y + z1*z2)^2"),
                     s.oracle([](Real x, Real y, Real z1, Real z2) { return (x * y + z1 * z2) * (x * y + z1 * z2); }),
                     1e-12);
    expect_integrals(weigh_by(s, "1"), s.oracle([](Real, Real, Real, Real) { return 1; }), 1e-12);
  }
}

TEST(Weight, OfOneIsTheMeasureItself) {
  const Sample s = rough_sample(2000, 5);
  const Measures plain = measure(s.view(), {});
  const std::vector<double> ones(s.z1.size(), 1);
  for (const WeightedMeasures& m : {weigh_by(s, "1"), weigh(s.view(), ones, LinearWeight{}, {})}) {
    EXPECT_NEAR(m.above, plain.volume.above, 1e-12 * plain.volume.above);
    EXPECT_NEAR(m.below, plain.volume.below, 1e-12 * plain.volume.below);
    EXPECT_NEAR(m.rho, plain.rho, 1e-12 * plain.rho);
    EXPECT_NEAR(m.integral, plain.area, 1e-12 * plain.area);
  }
}

TEST(Weight, KnowsTheSlopesOfBothSurfaces) {
  const Sample s = sample(
      framed_square(50, 1), [](const Point2& p) { return 3 * p.x + 4 * p.y; },
      [](const Point2& p) { return 3 * p.x + 4 * p.y + 1 + p.x; });
  EXPECT_NEAR(weigh_by(s, "slope1").integral, 5, 1e-9);
  EXPECT_NEAR(weigh_by(s, "slope2").integral, std::sqrt(32.0), 1e-9);
}

TEST(Weight, IsAFunctionOfInputCoordinates) {
  const Sample s = rough_sample(50, 2);
  const WeightedMeasures here = weigh_by(s, "x * y + z1 + z2 + 3");
  const WeightedMeasures there = weigh_by(s, "(x - 512) * (y + 64) + z1 + z2 - 2 * 8 + 3", {512, -64, 8});
  EXPECT_NEAR(here.above, there.above, 1e-12 * here.above);
  EXPECT_NEAR(here.integral, there.integral, 1e-12 * here.integral);
}

/// A random formula, and the same for the oracle.
struct Formula {
  std::string text;
  OracleWeight oracle;
  std::vector<Real> breaks;
  int order = 14;  ///< of the oracle: enough for its error to be nothing
};
std::string text_of(double v) { return "(" + std::to_string(v) + ")"; }

Formula random_formula(Random& random) {
  const auto number = [&](double low, double high) { return std::round(1000 * random.uniform(low, high)) / 1000; };
  const double a = number(0.1, 0.9), b = number(0.1, 0.9), k = number(1, 40);
  const std::string at = text_of(a), bt = text_of(b), kt = text_of(k);
  switch (random.below(7)) {
    case 0:
      return {"exp(-" + kt + "*((x-" + at + ")^2+(y-" + bt + ")^2))",
              [=](Real x, Real y, Real, Real) { return std::exp(-k * ((x - a) * (x - a) + (y - b) * (y - b))); },
              {}};
    case 1:
      return {"1+sin(" + kt + "*x+" + at + "*y)",
              [=](Real x, Real y, Real, Real) { return 1 + std::sin(k * x + a * y); },
              {}};
    case 2:
      return {"abs(x-" + at + ")", [=](Real x, Real, Real, Real) { return std::fabs(x - a); }, {a}};
    case 3:
      return {"x>" + at + " ? " + bt + " : y", [=](Real x, Real y, Real, Real) { return x > a ? b : y; }, {a}};
    case 4:
      return {"1/(" + at + "+" + kt + "*(z1-z2)^2)",
              [=](Real, Real, Real z1, Real z2) { return 1 / (a + k * (z1 - z2) * (z1 - z2)); },
              {},
              40};
    case 5:
      return {"max(x," + at + ")*exp(z2)",
              [=](Real x, Real, Real, Real z2) { return std::max(x, Real(a)) * std::exp(z2); },
              {a}};
    default:
      return {"sqrt(" + at + "+x*y)+z1^4",
              [=](Real x, Real y, Real z1, Real) { return std::sqrt(a + x * y) + z1 * z1 * z1 * z1; },
              {}};
  }
}

TEST(Weight, TheEstimateBoundsTheErrorOfAThousandRandomCasesSlow) {
  int rho_bounded = 0, integral_bounded = 0;
  constexpr int cases = 1000;
  double largest = 0;
  for (int i = 0; i < cases; ++i) {
    Random random(5000 + static_cast<std::uint64_t>(i));
    const Sample s = rough_sample(6 + random.below(14), 7000 + static_cast<std::uint64_t>(i));
    const Formula formula = random_formula(random);
    const Integrals exact = s.oracle(formula.oracle, formula.breaks, formula.order);
    const WeightedMeasures found = weigh_by(s, formula.text);
    const Real area = s.oracle([](Real, Real, Real, Real) { return 1; }, {}, 2).mu;
    const auto error = static_cast<double>(std::fabs(found.rho - (exact.above + exact.below) / area));
    rho_bounded += error <= found.error_estimate ? 1 : 0;
    integral_bounded += std::fabs(found.integral - exact.mu) <= found.integral_error ? 1 : 0;
    largest = std::max(largest, error / found.rho);
    EXPECT_LE(found.error_estimate, 1e-3 * found.rho) << formula.text << ": the bound is no use";
  }
  EXPECT_GE(rho_bounded, 0.99 * cases);
  EXPECT_GE(integral_bounded, 0.99 * cases);
  EXPECT_LE(largest, 5e-5);
  RecordProperty("rho_bounded", rho_bounded);
  std::printf("[ bounded  ] rho %d, integral %d of %d; largest relative error %.1e\n", rho_bounded, integral_bounded,
              cases, largest);
}

TEST(Weight, OfADiscIsItsAreaWithinTheEstimate) {
  const Sample s = sample(
      framed_square(300, 3), [](const Point2&) { return 0; }, [](const Point2&) { return 2; });
  for (int i = 0; i < 8; ++i) {
    Random random(40 + static_cast<std::uint64_t>(i));
    const double r = random.uniform(0.05, 0.4), x = random.uniform(0.4, 0.6), y = random.uniform(0.4, 0.6);
    const WeightedMeasures m = weigh_by(
        s, "(x-" + std::to_string(x) + ")^2+(y-" + std::to_string(y) + ")^2<" + std::to_string(r) + "^2 ? 1 : 0");
    const double exact = std::acos(-1.0) * std::pow(std::stod(std::to_string(r)), 2);
    EXPECT_NEAR(m.integral, exact, m.integral_error);
    EXPECT_NEAR(m.above, 2 * exact, m.error_estimate * 1.0000001);
    EXPECT_LT(m.integral_error, 3e-3 * exact);
  }
}

TEST(Weight, HasTheSameBitsForAnyNumberOfThreads) {
  const Sample s = rough_sample(5000, 9);
  const WeightedMeasures once = weigh_by(s, "x > y*y ? exp(z1) : 2");
  EXPECT_GT(once.error_estimate, 0);
  for (const int threads : {1, 3, 7})
    run_with_threads(threads, [&] {
      const WeightedMeasures again = weigh_by(s, "x > y*y ? exp(z1) : 2");
      EXPECT_EQ(again.rho, once.rho);
      EXPECT_EQ(again.integral, once.integral);
      EXPECT_EQ(again.error_estimate, once.error_estimate);
    });
}

std::string refusal_of(const Sample& s, const std::string& formula) {
  try {
    (void)weigh_by(s, formula);
  } catch (const UsageError& e) {
    const std::string message = e.what();
    EXPECT_EQ(message.find('\n'), std::string::npos);
    EXPECT_EQ(message.rfind("@weight", 0), 0u) << message;
    return message;
  }
  ADD_FAILURE() << formula << " is taken for a weight";
  return {};
}

TEST(Weight, RefusesWhatIsNoWeight) {
  const Sample s = rough_sample(300, 4);
  EXPECT_NE(refusal_of(s, "x - 0.5").find("-0."), std::string::npos);
  EXPECT_NE(refusal_of(s, "ln(x - 2)").find("no finite value"), std::string::npos);
  EXPECT_NE(refusal_of(s, "1/0").find("no finite value"), std::string::npos);
  EXPECT_NE(refusal_of(s, "distance + 1").find("unknown name 'distance'"), std::string::npos);
  EXPECT_NE(refusal_of(s, "x = 3").find("'=='"), std::string::npos);
  EXPECT_NE(refusal_of(s, "x, y").find("several"), std::string::npos);
  for (const char* broken : {"", "  ", "(x", "x +", "x y", "sin()", "\"x\"", "nosuch(x)", "x)", "1..2"})
    refusal_of(s, broken);
  EXPECT_EQ(refusal_of(s, "x - 0.5"), refusal_of(s, "x - 0.5")) << "the same place every time";
}

// --- attributes -----------------------------------------------------------------------------------------------------

TEST(Weight, LinearBetweenNodesIsTheClosedForm) {
  const double c = 0.37;
  const Sample s = sample(
      framed_square(400, 3), [](const Point2&) { return 0; }, [&](const Point2& p) { return p.x - c; });
  std::vector<double> mu;
  for (const Point2& p : s.mesh.xy) mu.push_back(p.x + 2 * p.y);
  const WeightedMeasures m = weigh(s.view(), mu, LinearWeight{}, {});
  const auto [above1, below1] = moments(c, 1);
  const auto [above0, below0] = moments(c, 0);
  EXPECT_NEAR(m.above, above1 + above0, 1e-12);
  EXPECT_NEAR(m.below, below1 + below0, 1e-12);
  EXPECT_NEAR(m.integral, 1.5, 1e-12);
  EXPECT_EQ(m.error_estimate, 0);
}

TEST(Weight, LinearOnRoughCellsIsTheOracle) {
  Sample s = rough_sample(100, 8);
  std::vector<double> mu;
  Random random(3);
  for (std::size_t i = 0; i < s.z1.size(); ++i) mu.push_back(random.below(4) == 0 ? 0 : random.uniform(0, 3));
  const WeightedMeasures found = weigh(s.view(), mu, LinearWeight{}, {});
  // z1 and d stand in for μ and d: the oracle's weight is then its z1.
  const Sample as_height{s.mesh, mu,
                         [&] {
                           std::vector<double> z;
                           for (std::size_t i = 0; i < mu.size(); ++i) z.push_back(mu[i] + (s.z2[i] - s.z1[i]));
                           return z;
                         }(),
                         s.in_domain};
  expect_integrals(found, as_height.oracle([](Real, Real, Real z1, Real) { return z1; }), 1e-11);
}

// --- rasters --------------------------------------------------------------------------------------------------------

Cloud raster_cloud(std::size_t columns, std::size_t rows, const std::array<double, 6>& g,
                   const std::function<double(double, double)>& value) {
  Cloud cloud;
  cloud.grid = RasterGrid{columns, rows, g};
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t c = 0; c < columns; ++c) {
      const double u = static_cast<double>(c) + 0.5, v = static_cast<double>(r) + 0.5;
      const double x = g[0] + u * g[1] + v * g[2], y = g[3] + u * g[4] + v * g[5], z = value(x, y);
      if (!std::isnan(z)) cloud.points.push_back({x, y, z});
    }
  return cloud;
}

TEST(Weight, OfABilinearRasterIsItsPolynomial) {
  const auto mu = [](double x, double y) { return (1 + x) * (3 - y); };
  for (const std::size_t cells : {4, 37, 300}) {
    const double h = 1.25 / static_cast<double>(cells);  // north up, half a cell or more beyond the square
    const RasterValues raster(raster_cloud(cells, cells, {-0.125, h, 0, 1.125, 0, -h}, mu));
    if (h / 2 > 0.125) continue;
    const Sample s = sample(
        framed_square(300, 3), [](const Point2&) { return 1; }, [](const Point2& p) { return 0.63 + p.x; });
    const WeightedMeasures found = weigh(s.view(), {}, RasterWeight{raster, "w.tif", {}}, {});
    const auto [above1, below1] = moments(0.37, 1);
    const auto [above0, below0] = moments(0.37, 0);
    EXPECT_NEAR(found.above, 2.5 * (above1 + above0), 1e-12);
    EXPECT_NEAR(found.below, 2.5 * (below1 + below0), 1e-12);
    EXPECT_NEAR(found.integral, 1.5 * 2.5, 1e-12);
  }
}

/// Every cell against every patch of the raster, cut in long double.
Integrals brute_raster(const Sample& s, const RasterValues& raster) {
  const RasterGrid& grid = raster.grid();
  const auto& g = grid.geotransform;
  const Real det = Real(g[1]) * g[5] - Real(g[2]) * g[4];
  const auto column = [&](Real x, Real y) { return ((x - g[0]) * g[5] - (y - g[3]) * g[2]) / det - Real(0.5); };
  const auto row = [&](Real x, Real y) { return ((y - g[3]) * g[1] - (x - g[0]) * g[4]) / det - Real(0.5); };
  const auto columns = static_cast<int>(grid.columns), rows = static_cast<int>(grid.rows);
  const std::vector<GaussPoint> rule = gauss(4);
  Integrals sum;
  for (std::size_t i = 0; i < s.in_domain.size(); ++i)
    for (int c = -1; c < columns && s.in_domain[i] != 0; ++c)
      for (int r = -1; r < rows; ++r) {
        Polygon p = s.polygon(i);
        p = cut(p, [&](const Corner& q) { return column(q.x, q.y) - c; });
        p = cut(p, [&](const Corner& q) { return c + 1 - column(q.x, q.y); });
        p = cut(p, [&](const Corner& q) { return row(q.x, q.y) - r; });
        p = cut(p, [&](const Corner& q) { return r + 1 - row(q.x, q.y); });
        const auto value = [&](int u, int v) {
          return Real(raster.value(static_cast<std::size_t>(std::clamp(u, 0, columns - 1)),
                                   static_cast<std::size_t>(std::clamp(v, 0, rows - 1))));
        };
        const auto mu = [&](Real x, Real y, Real, Real) {
          const Real fc = column(x, y) - c, fr = row(x, y) - r;
          return (1 - fr) * ((1 - fc) * value(c, r) + fc * value(c + 1, r)) +
                 fr * ((1 - fc) * value(c, r + 1) + fc * value(c + 1, r + 1));
        };
        add_smooth(cut(p, [](const Corner& q) { return q.d; }), mu, rule, sum);
        add_smooth(cut(p, [](const Corner& q) { return -q.d; }), mu, rule, sum);
      }
  return sum;
}

TEST(Weight, OfARoughRasterIsTheOracle) {
  Random random(77);
  const auto rough = [&](double, double) { return random.below(5) == 0 ? 0.0 : random.uniform(0, 1); };
  const std::vector<RasterValues> rasters{
      RasterValues(raster_cloud(9, 7, {-0.01, 1.02 / 9, 0, 1.01, 0, -1.02 / 7}, rough)),
      RasterValues(raster_cloud(1, 5, {-0.01, 1.02, 0, -0.01, 0, 1.02 / 5}, rough)),
      RasterValues(raster_cloud(12, 12, {-0.8, 0.16, 0.1, 0.4, -0.1, 0.16}, rough))};  // turned
  for (std::uint64_t seed = 1; seed <= 3; ++seed)
    for (const RasterValues& raster : rasters) {
      const Sample s = rough_sample(25, seed);
      expect_integrals(weigh(s.view(), {}, RasterWeight{raster, "w.tif", {}}, {}), brute_raster(s, raster), 1e-11);
    }
}

TEST(Weight, RefusesARasterThatDoesNotCoverTheDomainOrIsNegative) {
  const Sample s = rough_sample(100, 1);
  const std::array<double, 6> g{0, 0.1, 0, 0, 0, 0.1};
  const auto refused = [&](const RasterValues& raster) {
    try {
      (void)weigh(s.view(), {}, RasterWeight{raster, "w.tif", {}}, {});
    } catch (const Error& e) {
      EXPECT_EQ(std::string(e.what()).rfind("@weight", 0), 0u);
      return e.code();
    }
    return ExitCode::done;
  };
  EXPECT_EQ(refused(RasterValues(raster_cloud(10, 10, g, [](double, double) { return 1; }))), ExitCode::done);
  EXPECT_EQ(refused(RasterValues(raster_cloud(10, 8, g, [](double, double) { return 1; }))), ExitCode::input);
  EXPECT_EQ(
      refused(RasterValues(raster_cloud(
          10, 10, g, [](double x, double y) { return x > 0.5 && x < 0.6 && y > 0.5 && y < 0.6 ? std::nan("") : 1; }))),
      ExitCode::input);
  EXPECT_EQ(refused(RasterValues(raster_cloud(10, 10, g, [](double x, double) { return x < 0.6 ? 1 : -1; }))),
            ExitCode::usage);
}

// --- in comparisons -------------------------------------------------------------------------------------------------

Cloud with_attribute(Cloud cloud, const std::string& name, const std::function<double(const Point3&)>& value) {
  Attribute attribute{name, {}};
  for (const Point3& p : cloud.points) attribute.values.push_back(value(p));
  cloud.attributes.push_back(std::move(attribute));
  return cloud;
}
WeightedMeasures compared(const Cloud& a, const Cloud& b, const WeightSource& weight, Surface surface,
                          BorderRule border = BorderRule::hull) {
  CompareOptions o;
  o.check_layers = false;
  o.border = border;
  o.weight = weight;
  o.surface = surface;
  return *compare(a, b, o, {}).weighted;
}

TEST(WeightInComparisons, IsTheSameOnBothSurfacesWhereBothAreExact) {
  const double c = 0.37;
  const auto f1 = [](const Point2& p) { return p.x + p.y; };
  const auto f2 = [&](const Point2& p) { return 2 * p.x + p.y - c; };
  const auto mu = [](const Point3& p) { return p.x + 2 * p.y; };
  const Cloud a = with_attribute(cloud_over(framed_square(300, 1), f1), "trust", mu);
  const Cloud b = with_attribute(cloud_over(framed_square(500, 2), f2), "trust", mu);
  const auto [above1, below1] = moments(c, 1);
  const auto [above0, below0] = moments(c, 0);
  using Kind = WeightSource::Kind;
  using Scan = WeightSource::Scan;
  for (const Surface surface : {Surface::common, Surface::overlay, Surface::both})
    for (const WeightSource& w :
         {WeightSource{Kind::attribute, Scan::any, "trust"}, WeightSource{Kind::attribute, Scan::a, "trust"},
          WeightSource{Kind::attribute, Scan::b, "trust"}, weight_by("x + 2 * y"),
          weight_by("z2 - x + y + 0.37 + 0*slope1")}) {
      const WeightedMeasures m = compared(a, b, w, surface);
      EXPECT_NEAR(m.above, above1 + above0, 1e-10);
      EXPECT_NEAR(m.below, below1 + below0, 1e-10);
      EXPECT_NEAR(m.integral, 1.5, 1e-10);
    }
  // Slopes of the overlay are those of the two meshes.
  EXPECT_NEAR(compared(a, b, weight_by("slope2"), Surface::overlay).integral, std::sqrt(5), 1e-9);
}

TEST(WeightInComparisons, DoesNotDependOnTheOrderOfThePoints) {
  const auto noise = [](const Point3& p) { return 1 + p.z * p.z; };
  Cloud a = rough_cloud(uniform(800, 1), 2), b = rough_cloud(uniform(900, 3), 4);
  for (int i = 0; i < 50; ++i) b.points.push_back({b.points[0].x, b.points[0].y, 0.1 * i});  // one node of many points
  const WeightSource trust{WeightSource::Kind::attribute, WeightSource::Scan::any, "trust"};
  const WeightSource formula = weight_by("max(0, x - y)");
  for (const Surface surface : {Surface::common, Surface::overlay})
    for (const WeightSource& w : {trust, formula}) {
      const WeightedMeasures once =
          compared(with_attribute(a, "trust", noise), with_attribute(b, "trust", noise), w, surface);
      const WeightedMeasures again = compared(with_attribute(shuffled(a, 5), "trust", noise),
                                              with_attribute(shuffled(b, 6), "trust", noise), w, surface);
      EXPECT_EQ(once.rho, again.rho);
      EXPECT_EQ(once.integral, again.integral);
    }
}

TEST(WeightInComparisons, LeavesThePlainNumbersAlone) {
  const Cloud a = rough_cloud(uniform(800, 1), 2), b = rough_cloud(uniform(900, 3), 4);
  CompareOptions o;
  o.check_layers = false;
  const Comparison plain = compare(a, b, o, {});
  o.weight = weight_by("2");
  const Comparison weighted = compare(a, b, o, {});
  EXPECT_FALSE(plain.weighted);
  EXPECT_EQ(plain.measures.rho, weighted.measures.rho);
  EXPECT_NEAR(weighted.weighted->rho, 2 * plain.measures.rho, 1e-12);
  o.interpolation = Interpolation::cubic;
  EXPECT_THROW((void)compare(a, b, o, {}), UsageError);
}

// What the caller has of it is a function: no parser, no file.
TEST(WeightInComparisons, MayBeAnyFunctionOrRasterInMemory) {
  const Cloud a = rough_cloud(uniform(800, 1), 2), b = rough_cloud(uniform(900, 3), 4);
  using Kind = WeightSource::Kind;
  const WeightSource named{Kind::expression, WeightSource::Scan::any, "1 + x", [](const Place& p) { return 1 + p.x; }};
  const RasterValues raster(raster_cloud(2, 1, {-0.5, 1, 0, -0.5, 0, 2}, [](double x, double) { return 1 + x; }));
  const WeightSource of_raster{Kind::raster, WeightSource::Scan::any, "1 + x", nullptr, raster};
  for (const Surface surface : {Surface::common, Surface::overlay}) {
    const WeightedMeasures read = compared(a, b, weight_by("1 + x"), surface);
    EXPECT_EQ(compared(a, b, named, surface).rho, read.rho);
    EXPECT_NEAR(compared(a, b, of_raster, surface).rho, read.rho, 1e-12);  // linear: bilinear is the same
  }
}

TEST(WeightInComparisons, RefusesWhatIsNamedButNotRead) {
  const Cloud a = rough_cloud(uniform(80, 1), 2), b = rough_cloud(uniform(90, 3), 4);
  for (const auto kind : {WeightSource::Kind::expression, WeightSource::Kind::raster}) {
    try {
      (void)compared(a, b, {kind, WeightSource::Scan::any, "w.tif"}, Surface::common);
      ADD_FAILURE() << to_text(kind);
    } catch (const UsageError& e) {
      EXPECT_NE(std::string(e.what()).find("'w.tif' was named but not read"), std::string::npos) << e.what();
    }
  }
}

}  // namespace
}  // namespace isopach::test
