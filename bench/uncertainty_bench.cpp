// How often the stated uncertainty is true: uncertainty_bench, writes the tables of docs/use/uncertainty.md. 2000 pairs
// of known errors a row; with 2000 a share of 95 % is known to ±0.5 % (one standard deviation). Takes some minutes.
#include <fmt/format.h>

#include <cstdio>
#include <string>

#include "tests/support/noisy_pairs.hpp"

namespace {

using namespace isopach;
using namespace isopach::test;

constexpr int pairs = 2000;

CompareOptions options_of(UncertaintyModel model, double sigma1, double sigma2) {
  CompareOptions o;
  o.check_layers = false;
  o.uncertainty.model = model;
  if (sigma1 > 0) {
    o.uncertainty.sigma1 = {SigmaSource::Kind::constant, sigma1, ""};
    o.uncertainty.sigma2 = {SigmaSource::Kind::constant, sigma2, ""};
  }
  return o;
}

CompareOptions correlated(CorrelationShape shape, double range) {
  CompareOptions o = options_of(UncertaintyModel::correlated, 0.05, 0.02);
  o.uncertainty.correlation = shape;
  o.uncertainty.correlation_range = range;
  return o;
}

CompareOptions shifted(double sigma1, double sigma2, double range) {
  CompareOptions o = options_of(UncertaintyModel::registration, sigma1, sigma2);
  o.uncertainty.registration_error = 0.02;
  o.uncertainty.correlation_range = range;
  return o;
}

/// Turns of 0.01 about each axis, shifts of 0.03, 0.03, 0.01, some of them going together.
CompareOptions moved(double sigma1, double sigma2) {
  CompareOptions o = options_of(UncertaintyModel::registration, sigma1, sigma2);
  PoseCovariance c;
  constexpr std::array<double, 6> deviation{0.01, 0.01, 0.01, 0.03, 0.03, 0.01};
  for (std::size_t i = 0; i < 6; ++i) c.matrix[7 * i] = deviation[i] * deviation[i];
  c.matrix[6 * 0 + 5] = c.matrix[6 * 5 + 0] = 0.6 * deviation[0] * deviation[5];
  c.matrix[6 * 1 + 3] = c.matrix[6 * 3 + 1] = -0.5 * deviation[1] * deviation[3];
  c.centre = {0.5, 0.5, 0};
  o.uncertainty.registration_covariance = c;
  return o;
}

/// uniform() over a square of side 1.6 round the unit square: the domain is the hull of the other scan.
Points around(std::size_t n, std::uint64_t seed) {
  Points xy = uniform(n, seed);
  for (Point2& p : xy) p = {1.6 * p.x - 0.3, 1.6 * p.y - 0.3};
  return xy;
}

void table_of_net() {
  using Shape = CorrelationShape;
  struct Case {
    std::string name;
    CompareOptions options;
    bool wide = false;
  };
  const std::vector<Case> cases{{"`independent`", options_of(UncertaintyModel::independent, 0.05, 0.02)},
                                {"`correlated`, spherical, range 0.4", correlated(Shape::spherical, 0.4)},
                                {"`correlated`, exponential, 0.4", correlated(Shape::exponential, 0.4)},
                                {"`correlated`, gaussian, 0.4", correlated(Shape::gaussian, 0.4)},
                                {"`correlated`, exponential, 0.1", correlated(Shape::exponential, 0.1)},
                                {"`registration`, a shift alone", shifted(0, 0, 0)},
                                {"`registration`, a shift and independent noise", shifted(0.05, 0.02, 0)},
                                {"`registration`, a shift and correlated noise, 0.4", shifted(0.05, 0.02, 0.4)},
                                {"`registration`, a covariance alone", moved(0, 0), true},
                                {"`registration`, a covariance and independent noise", moved(0.05, 0.02), true}};
  constexpr std::array<std::pair<std::size_t, std::size_t>, 3> sizes{{{25, 40}, {120, 30}, {100, 150}}};
  fmt::print("| model |");
  for (const char* surface : {"common", "overlay"})
    for (const auto& [a, b] : sizes) fmt::print(" {}, {} + {} |", surface, a, b);
  fmt::print("\n|---|---|---|---|---|---|---|\n");
  std::uint64_t seed = 1000;
  for (const Case& c : cases) {
    fmt::print("| {} |", c.name);
    for (const Surface surface : {Surface::common, Surface::overlay})
      for (const auto& [a, b] : sizes) {
        NoisyPairs p{uniform(a, seed), c.wide ? around(2 * b, seed + 1) : uniform(b, seed + 1), c.options};
        p.options.surface = surface;
        fmt::print(" {:.1f} % |", 100 * truthful(p, pairs, seed + 2).net);
        std::fflush(stdout);
        seed += 3;
      }
    fmt::print("\n");
  }
}

void table_of_gross() {
  fmt::print(
      "\n| σ of d against the largest \\|d\\| | net | gained | lost | gross too large by | `rectification_bias_max`, "
      "both |\n|---|---|---|---|---|---|\n");
  for (const double sigma : {0.005, 0.02, 0.1, 0.5, 2.0}) {
    NoisyPairs p{uniform(100, 51), uniform(150, 52), options_of(UncertaintyModel::independent, sigma * 0.5, 0), 0, 1};
    const Truthful t = truthful(p, pairs, 53);
    NoisyPairMaker maker(p, 54);
    const auto [a, b] = maker.next();
    const Comparison c = compare(a, b, p.options, {});
    fmt::print("| {} | {:.1f} % | {:.1f} % | {:.1f} % | {:.4f} | {:.4f} |\n", sigma, 100 * t.net, 100 * t.above,
               100 * t.below, t.gross_bias, 2 * *c.uncertainty.rectification_bias / c.domain_area);
  }
}

}  // namespace

int main() {
  table_of_net();
  table_of_gross();
  return 0;
}
