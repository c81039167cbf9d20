#include "isopach/measure/currents/currents_cubes.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "isopach/base/parallel.hpp"

namespace isopach::currents_parts {

namespace {

constexpr std::size_t most_nodes_a_source = 10;  // below it a grid is made sooner than its pairs are summed directly
constexpr double most_cubes = 0x1p44;            // along an axis: a corner is a product of 44 and 8 bits, exact

double rounded_to_8_bits(double x) {
  int exponent = 0;
  const double fraction = std::frexp(x, &exponent);
  return std::ldexp(std::round(fraction * 256), exponent - 8);
}

// See currents.hpp.
double interpolation_error(double tau, int p) {
  if (tau == 0) return 0;
  return 2 * 1.09 * std::exp(p * std::log(tau / std::numbers::sqrt2) - 0.5 * std::lgamma(p + 1.0));
}

/// Both currents one after the other.
struct Sources {
  const Current &a, &b;
  [[nodiscard]] std::size_t size() const { return a.centroids.size() + b.centroids.size(); }
  [[nodiscard]] bool is_b(std::size_t i) const { return i >= a.centroids.size(); }
  [[nodiscard]] const Point3& centroid(std::size_t i) const {
    return is_b(i) ? b.centroids[i - a.centroids.size()] : a.centroids[i];
  }
  [[nodiscard]] const Point3& normal(std::size_t i) const {
    return is_b(i) ? b.normals[i - a.normals.size()] : a.normals[i];
  }
};

using Key = std::array<std::int64_t, 3>;

/// Triangles in a row in one cube.
struct Run {
  Key key;
  std::size_t begin, end;
  friend bool operator<(const Run& l, const Run& r) { return l.key != r.key ? l.key < r.key : l.begin < r.begin; }
};

void check_range(const Sources& s, double sigma, double side) {
  const double farthest = reduce_blocks<double>(
      s.size(), default_block,
      [&](std::size_t begin, std::size_t end) {
        double most = 0;
        for (std::size_t i = begin; i < end; ++i) {
          const Point3& p = s.centroid(i);
          most = std::max({most, std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
        }
        return most;
      },
      [](double& most, double part) { most = std::max(most, part); });
  if (!(farthest / side < most_cubes))
    throw UsageError(fmt::format("@sigma: {} is too narrow beside coordinates of {:.3g}: give {:.1g} or more", sigma,
                                 farthest, farthest / most_cubes));
}

/// Runs in the order of their cubes, in each in the order given.
std::vector<Run> sorted_runs(const Sources& s, double side) {
  const auto key = [&](std::size_t i) {
    const Point3& p = s.centroid(i);
    return Key{static_cast<std::int64_t>(std::floor(p.x / side)), static_cast<std::int64_t>(std::floor(p.y / side)),
               static_cast<std::int64_t>(std::floor(p.z / side))};
  };
  std::vector<Run> runs =
      gather_blocks<std::vector<Run>>(s.size(), default_block, [&](std::size_t begin, std::size_t end) {
        std::vector<Run> part;
        for (std::size_t i = begin; i < end; ++i) {
          const Key k = key(i);
          if (part.empty() || part.back().key != k || i == s.a.centroids.size()) part.push_back({k, i, i});
          part.back().end = i + 1;
        }
        return part;
      });
  std::sort(runs.begin(), runs.end());
  return runs;
}

/// Values at t of the Lagrange polynomials of p Chebyshev nodes: L_a(t) = (1 + 2 Σ_k T_k(ξ_a) T_k(t)) / p.
void lagrange(double t, int p, const double* chebyshev, double* out) {
  for (int a = 0; a < p; ++a) out[a] = 1.0 / p;
  double before = 1, now = t;
  for (int k = 1; k < p; ++k) {
    const double scaled = 2 * now / p;
    for (int a = 0; a < p; ++a) out[a] += chebyshev[k * most_nodes + a] * scaled;
    const double next = 2 * t * now - before;
    before = now, now = next;
  }
}

/// T_k(ξ_a) of p nodes, in rows of k.
void chebyshev_table(int p, double* out) {
  for (int k = 0; k < p; ++k)
    for (int a = 0; a < p; ++a) out[k * most_nodes + a] = std::cos(k * (2 * a + 1) * std::numbers::pi / (2 * p));
}

}  // namespace

void Points::resize(std::size_t n) {
  for (auto& c : at) c.resize(n);
  for (auto& scan : normal)
    for (auto& c : scan) c.assign(n, 0.0);
}

double Cube::node(std::size_t side, int a) const {
  const double middle_of = (low[side] + high[side]) / 2, tau = (high[side] - low[side]) / 2;
  return middle_of + tau * std::cos((2 * a + 1) * std::numbers::pi / (2 * p[side]));
}

double lebesgue(int p) { return p <= 1 ? 1 : 1 + 2 / std::numbers::pi * std::log(p); }

Cubes::Cubes(const Current& a, const Current& b, double sigma) : sigma_(sigma), side_(rounded_to_8_bits(2 * sigma)) {
  const Sources from{a, b};
  check_range(from, sigma, side_);
  width_ = side_ / sigma_;
  const std::vector<Run> runs = sorted_runs(from, side_);
  std::vector<std::size_t> places;  // of the runs among the sorted sources
  std::size_t n = 0;
  for (const Run& run : runs) {
    if (cubes_.empty() || cubes_.back().key != run.key) cubes_.push_back({run.key, n, n, n, {}, {}});
    places.push_back(n);
    n += run.end - run.begin;
    cubes_.back().end = n;
    if (!from.is_b(run.begin)) cubes_.back().middle = n;
  }
  sources_.resize(n);
  for_each_index(runs.size(), [&](std::size_t r) {
    const Run& run = runs[r];
    auto& normal = sources_.normal[from.is_b(run.begin) ? 1 : 0];
    const auto local = [&](double x, std::size_t k) { return (x - static_cast<double>(run.key[k]) * side_) / sigma_; };
    for (std::size_t i = run.begin, to = places[r]; i < run.end; ++i, ++to) {
      const Point3 &p = from.centroid(i), &m = from.normal(i);
      sources_.at[0][to] = local(p.x, 0), sources_.at[1][to] = local(p.y, 1), sources_.at[2][to] = local(p.z, 2);
      normal[0][to] = m.x, normal[1][to] = m.y, normal[2][to] = m.z;
    }
  });
  for_each_index(cubes_.size(), [&](std::size_t i) { describe(cubes_[i]); });
  for (const Cube& cube : cubes_)
    for (std::size_t s = 0; s < 2; ++s) {
      total_[s] += cube.weight[s];
      heaviest_[s] = std::max(heaviest_[s], cube.weight[s]);
    }
}

void Cubes::describe(Cube& cube) const {
  for (std::size_t k = 0; k < 3; ++k) {
    const auto first = sources_.at[k].begin();
    const auto [low, high] = std::minmax_element(first + static_cast<std::ptrdiff_t>(cube.begin),
                                                 first + static_cast<std::ptrdiff_t>(cube.end));
    cube.low[k] = *low, cube.high[k] = *high;
  }
  for (std::size_t i = cube.begin; i < cube.end; ++i) {
    const std::size_t s = i < cube.middle ? 0 : 1;
    const auto& m = sources_.normal[s];
    cube.weight[s] += std::sqrt(m[0][i] * m[0][i] + m[1][i] * m[1][i] + m[2][i] * m[2][i]);
  }
}

void Cubes::make_grids(double share) {
  share_ = share;
  for (reach_ = 1; std::exp(-std::pow(width_ * static_cast<double>(reach_), 2)) > 1e-3 * share;) ++reach_;
  std::size_t n = 0;
  for (Cube& cube : cubes_) {
    std::array<int, 3> p{};
    std::size_t nodes = 1;
    for (std::size_t k = 0; k < 3; ++k) {
      const double tau = (cube.high[k] - cube.low[k]) / 2;
      p[k] = 1;
      while (p[k] < most_nodes && 3 * (1 + lebesgue(p[k])) * interpolation_error(tau, p[k]) > share) ++p[k];
      cube.error[k] = interpolation_error(tau, p[k]);
      nodes *= static_cast<std::size_t>(p[k]);
    }
    cube.p = {};
    if (nodes > most_nodes_a_source * cube.sources()) continue;
    cube.p = p;
    cube.first_node = n;
    n += nodes;
  }
  grids_.resize(n);
  for_blocks(cubes_.size(), cubes_a_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      if (cubes_[i].has_grid()) fill(cubes_[i]);
  });
}

void Cubes::fill(const Cube& cube) {
  std::array<std::array<double, most_nodes * most_nodes>, 3> chebyshev;
  std::array<std::array<double, most_nodes>, 3> l{};
  for (std::size_t k = 0; k < 3; ++k) chebyshev_table(cube.p[k], chebyshev[k].data());
  const auto px = static_cast<std::size_t>(cube.p[0]), py = static_cast<std::size_t>(cube.p[1]),
             pz = static_cast<std::size_t>(cube.p[2]);
  for (std::size_t z = 0, i = cube.first_node; z < pz; ++z)
    for (std::size_t y = 0; y < py; ++y)
      for (std::size_t x = 0; x < px; ++x, ++i) {
        grids_.at[0][i] = cube.node(0, static_cast<int>(x));
        grids_.at[1][i] = cube.node(1, static_cast<int>(y));
        grids_.at[2][i] = cube.node(2, static_cast<int>(z));
      }
  for (std::size_t i = cube.begin; i < cube.end; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double middle = (cube.low[k] + cube.high[k]) / 2, tau = (cube.high[k] - cube.low[k]) / 2;
      lagrange(tau > 0 ? (sources_.at[k][i] - middle) / tau : 0.0, cube.p[k], chebyshev[k].data(), l[k].data());
    }
    const std::size_t s = i < cube.middle ? 0 : 1;
    for (std::size_t c = 0; c < 3; ++c) {
      const double m = sources_.normal[s][c][i];
      double* out = grids_.normal[s][c].data() + cube.first_node;
      for (std::size_t z = 0; z < pz; ++z)
        for (std::size_t y = 0; y < py; ++y, out += px) {
          const double f = m * l[2][z] * l[1][y];
          for (std::size_t x = 0; x < px; ++x) out[x] += f * l[0][x];
        }
    }
  }
}

Vector Cubes::offset(const Cube& from, const Cube& to) const {
  Vector o;
  for (std::size_t k = 0; k < 3; ++k) o[k] = static_cast<double>(to.key[k] - from.key[k]) * width_;
  return o;
}

Vector Cubes::corner(const Cube& c, const Point3& origin) const {
  const auto at = [&](std::size_t k, double o) { return (static_cast<double>(c.key[k]) * side_ - o) / sigma_; };
  return {at(0, origin.x), at(1, origin.y), at(2, origin.z)};
}

// Pairs never looked at are at least `reach_` sides apart: all weights at that distance, or shell by shell the heaviest
// cube in each place of it, whichever is less.
std::array<double, 2> Cubes::beyond_reach() const {
  const auto at = [&](double sides) { return std::exp(-(width_ * sides) * (width_ * sides)); };
  double shells = 0;
  for (int k = static_cast<int>(reach_) + 1; k < static_cast<int>(reach_) + 60; ++k)
    shells += (24.0 * k * k + 2) * at(k - 1);
  std::array<double, 2> others{};
  for (std::size_t s = 0; s < 2; ++s)
    others[s] = std::min(at(static_cast<double>(reach_)) * total_[s], shells * heaviest_[s]);
  return others;
}

}  // namespace isopach::currents_parts
