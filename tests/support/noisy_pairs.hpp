// Pairs of scans of two planes with known errors, and how often what `compare` says of its uncertainty is true. Planes,
// because no interpolation errs on them: what is left is the noise alone. For tests and for
// bench/uncertainty_bench.cpp.
#pragma once
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "isopach/compare/compare.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {

/// Lower triangular L with L Lᵀ = C, row by row; where nothing is left of a variance (C singular) its column is 0.
inline std::vector<std::vector<double>> cholesky(std::size_t n,
                                                 const std::function<double(std::size_t, std::size_t)>& c) {
  std::vector<std::vector<double>> l(n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = c(i, j);
      for (std::size_t k = 0; k < j; ++k) sum -= l[i][k] * l[j][k];
      if (i == j)
        l[i].push_back(sum > 1e-12 * c(i, i) ? std::sqrt(sum) : 0);
      else
        l[i].push_back(l[j][j] > 0 ? sum / l[j][j] : 0);
    }
  return l;
}

/// d without any error is lift + tilt · (x − 1/2).
struct NoisyPairs {
  Points xy_a, xy_b;
  CompareOptions options;  ///< with constant sigmas, or none
  double lift = 0.01, tilt = 0;
};

struct Truthful {
  double net = 0, above = 0, below = 0;  ///< share of the pairs whose interval holds the truth
  double gross_bias = 0;                 ///< mean of above + below, less the truth, per area
};

class NoisyPairMaker {
 public:
  NoisyPairMaker(const NoisyPairs& p, std::uint64_t seed) : p_(p), u_(p.options.uncertainty), random_(seed) {
    const std::array<const Points*, 2> xy{&p.xy_a, &p.xy_b};
    for (std::size_t scan = 0; scan < 2 && u_.correlation_range > 0; ++scan)
      noise_[scan] = cholesky(xy[scan]->size(), [&](std::size_t i, std::size_t j) {
        const Point2 &s = (*xy[scan])[i], &t = (*xy[scan])[j];
        return correlation(u_.correlation, u_.correlation_range, std::hypot(s.x - t.x, s.y - t.y));
      });
    if (u_.registration_covariance)
      motion_ =
          cholesky(6, [&](std::size_t i, std::size_t j) { return u_.registration_covariance->matrix[6 * i + j]; });
  }

  [[nodiscard]] std::array<Cloud, 2> next() {
    std::array<Cloud, 2> pair{scan(0, p_.xy_a, u_.sigma1.value), scan(1, p_.xy_b, u_.sigma2.value)};
    const double shift = u_.registration_error > 0 ? u_.registration_error * random_.bell() : 0;
    for (Point3& p : pair[1].points) p.z += p_.lift + p_.tilt * (p.x - 0.5) + shift;
    if (!motion_.empty()) move(pair[1]);
    return pair;
  }

 private:
  std::vector<double> errors(const std::vector<std::vector<double>>& l, std::size_t n) {
    std::vector<double> e(n), mixed(n);
    for (double& x : e) x = random_.bell();
    if (l.empty()) return e;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t k = 0; k <= i; ++k) mixed[i] += l[i][k] * e[k];
    return mixed;
  }
  Cloud scan(std::size_t number, const Points& xy, double sigma) {
    const std::vector<double> e = errors(noise_[number], xy.size());
    Cloud cloud;
    for (std::size_t i = 0; i < xy.size(); ++i)
      cloud.points.push_back({xy[i].x, xy[i].y, 0.3 * xy[i].x - 0.2 * xy[i].y + sigma * e[i]});
    return cloud;
  }
  void move(Cloud& cloud) {
    const std::vector<double> m = errors(motion_, 6);
    const Point3 c = u_.registration_covariance->centre;
    for (Point3& p : cloud.points) {
      const Point3 r{p.x - c.x, p.y - c.y, p.z - c.z};
      p = {p.x + m[1] * r.z - m[2] * r.y + m[3], p.y + m[2] * r.x - m[0] * r.z + m[4],
           p.z + m[0] * r.y - m[1] * r.x + m[5]};
    }
  }

  const NoisyPairs& p_;
  const UncertaintyOptions& u_;
  Random random_;
  std::array<std::vector<std::vector<double>>, 2> noise_;
  std::vector<std::vector<double>> motion_;
};

/// Of `pairs` simulated pairs. The true volumes are those of the same nodes without errors.
inline Truthful truthful(const NoisyPairs& p, int pairs, std::uint64_t seed) {
  NoisyPairs clean = p;
  UncertaintyOptions& none = clean.options.uncertainty;
  none = {};
  const auto without_errors = NoisyPairMaker(clean, seed).next();
  Context alone;
  alone.threads = 1;  // such small scans are not worth a second one
  const Comparison truth = compare(without_errors[0], without_errors[1], clean.options, alone);
  NoisyPairMaker maker(p, seed);
  Truthful found;
  for (int i = 0; i < pairs; ++i) {
    const auto [a, b] = maker.next();
    const Comparison c = compare(a, b, p.options, alone);
    const auto holds = [&](double measured, double sigma, double true_value) {
      return std::fabs(measured - true_value) <= c.uncertainty.deviations * sigma ? 1.0 / pairs : 0;
    };
    // Per area: a pose error also moves the rim of the domain by a little.
    const double scale = c.domain_area / truth.domain_area;
    const Volume &v = c.measures.volume, &t = truth.measures.volume;
    found.net += holds(v.net, c.uncertainty.sigma->net, scale * t.net);
    found.above += holds(v.above, c.uncertainty.sigma->above, scale * t.above);
    found.below += holds(v.below, c.uncertainty.sigma->below, scale * t.below);
    found.gross_bias += (v.absolute / c.domain_area - t.absolute / truth.domain_area) / pairs;
  }
  return found;
}

}  // namespace isopach::test
