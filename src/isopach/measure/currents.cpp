#include "isopach/measure/currents.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "isopach/base/array.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/measure/currents_kernel.hpp"

namespace isopach {
namespace {

constexpr int most_nodes = 24;      // along one side of a grid
constexpr double rounding = 1e-13;  // of one pair, relative to |n_i| |n_j| times its kernel
constexpr std::size_t cubes_a_block = 16;
constexpr int most_rounds = 8;

/// Points with a normal of each scan (zero where a point is of the other): sources of a cube, or nodes of its grid.
struct Points {
  std::array<std::vector<double>, 3> at;
  std::array<std::array<std::vector<double>, 3>, 2> normal;  ///< by scan

  void resize(std::size_t n) {
    for (auto& c : at) c.resize(n);
    for (auto& scan : normal)
      for (auto& c : scan) c.assign(n, 0.0);
  }
  [[nodiscard]] std::size_t size() const { return at[0].size(); }
};

struct Cube {
  std::array<std::int64_t, 3> key;
  std::size_t begin, end;           ///< sources
  std::array<double, 3> low, high;  ///< of the sources, in σ
  std::array<double, 2> weight{};   ///< Σ |n| by scan
  std::array<int, 3> p{};           ///< nodes of the grid; 0: none
  std::array<double, 3> error{};    ///< of interpolation along each side, at x = 0
  std::size_t first_node = 0;       ///< of its grid among all grids
  [[nodiscard]] bool has_grid() const { return p[0] > 0; }
  [[nodiscard]] std::size_t nodes() const {
    return static_cast<std::size_t>(p[0]) * static_cast<std::size_t>(p[1]) * static_cast<std::size_t>(p[2]);
  }
};

double lebesgue(int p) { return p == 1 ? 1 : 1 + 2 / std::numbers::pi * std::log(p); }

double interpolation_error(double tau, int p) {
  if (tau == 0) return 0;
  const double log = p * std::log(tau / std::numbers::sqrt2) - 0.5 * std::lgamma(p + 1.0);
  return 2 * 1.09 * std::exp(log);
}

double node(const Cube& cube, std::size_t side, int a) {
  const double middle = (cube.low[side] + cube.high[side]) / 2, tau = (cube.high[side] - cube.low[side]) / 2;
  return middle + tau * std::cos((2 * a + 1) * std::numbers::pi / (2 * cube.p[side]));
}

/// Sources in units of σ, sorted by cube, in each cube those of scan 1 first, each in the order given.
class Cubes {
 public:
  Cubes(const Current& a, const Current& b, double sigma) {
    const std::size_t n1 = a.centroids.size(), n = n1 + b.centroids.size();
    Box3 box;
    for (const Current* c : {&a, &b})
      for (const Point3& p : c->centroids) box.add(p);
    const std::array<double, 3> origin{box.min.x, box.min.y, box.min.z};
    struct Entry {
      std::array<std::int64_t, 3> key;
      std::size_t id;
      auto operator<=>(const Entry&) const = default;
    };
    const auto point = [&](std::size_t i) {
      const Point3& p = i < n1 ? a.centroids[i] : b.centroids[i - n1];
      return std::array{(p.x - origin[0]) / sigma, (p.y - origin[1]) / sigma, (p.z - origin[2]) / sigma};
    };
    std::vector<Entry> entries(n);
    for_each_index(n, [&](std::size_t i) {
      const auto p = point(i);
      for (std::size_t k = 0; k < 3; ++k) entries[i].key[k] = static_cast<std::int64_t>(std::floor(p[k] / 2));
      entries[i].id = i;
    });
    std::sort(entries.begin(), entries.end());
    sources.resize(n);
    for_each_index(n, [&](std::size_t i) {
      const std::size_t id = entries[i].id;
      const auto p = point(id);
      const Point3& m = id < n1 ? a.normals[id] : b.normals[id - n1];
      auto& normal = sources.normal[id < n1 ? 0 : 1];
      for (std::size_t k = 0; k < 3; ++k) sources.at[k][i] = p[k];
      normal[0][i] = m.x, normal[1][i] = m.y, normal[2][i] = m.z;
    });
    for (std::size_t i = 0; i < n;) {
      Cube cube{entries[i].key, i, i, {}, {}};
      while (cube.end < n && entries[cube.end].key == cube.key) ++cube.end;
      i = cube.end;
      cubes.push_back(cube);
    }
    for_each_index(cubes.size(), [&](std::size_t i) { describe(cubes[i]); });
    for (const Cube& cube : cubes)
      for (std::size_t s = 0; s < 2; ++s) {
        total[s] += cube.weight[s];
        heaviest[s] = std::max(heaviest[s], cube.weight[s]);
      }
  }

  /// Grids that keep the kernel's error of a pair below `share`, for cubes with enough sources to need one.
  void make_grids(double share) {
    std::size_t n = 0;
    for (Cube& cube : cubes) {
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
      if (nodes > 4 * (cube.end - cube.begin)) continue;
      cube.p = p;
      cube.first_node = n;
      n += nodes;
    }
    grid.resize(n);
    for_blocks(cubes.size(), cubes_a_block, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        if (cubes[i].has_grid()) fill(cubes[i]);
    });
  }

  Points sources, grid;
  std::vector<Cube> cubes;
  std::array<double, 2> total{}, heaviest{};

 private:
  void describe(Cube& cube) const {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto first = sources.at[k].begin();
      const auto [low, high] = std::minmax_element(first + static_cast<std::ptrdiff_t>(cube.begin),
                                                   first + static_cast<std::ptrdiff_t>(cube.end));
      cube.low[k] = *low, cube.high[k] = *high;
    }
    for (std::size_t s = 0; s < 2; ++s)
      for (std::size_t i = cube.begin; i < cube.end; ++i) {
        const auto& m = sources.normal[s];
        cube.weight[s] += std::sqrt(m[0][i] * m[0][i] + m[1][i] * m[1][i] + m[2][i] * m[2][i]);
      }
  }

  // Values of the Lagrange polynomials at x: L_a(t) = (1 + 2 Σ_k T_k(ξ_a) T_k(t)) / p.
  static void lagrange(double t, int p, const double* chebyshev, double* out) {
    for (int a = 0; a < p; ++a) out[a] = 1.0 / p;
    double before = 1, now = t;
    for (int k = 1; k < p; ++k) {
      const double scaled = 2 * now / p;
      for (int a = 0; a < p; ++a) out[a] += chebyshev[k * most_nodes + a] * scaled;
      const double next = 2 * t * now - before;
      before = now, now = next;
    }
  }

  void fill(const Cube& cube) {
    std::array<std::array<double, most_nodes * most_nodes>, 3> chebyshev;
    std::array<std::array<double, most_nodes>, 3> l{};
    for (std::size_t k = 0; k < 3; ++k)
      for (int order = 0; order < cube.p[k]; ++order)
        for (int a = 0; a < cube.p[k]; ++a)
          chebyshev[k][static_cast<std::size_t>(order * most_nodes + a)] =
              std::cos(order * (2 * a + 1) * std::numbers::pi / (2 * cube.p[k]));
    const auto px = static_cast<std::size_t>(cube.p[0]), py = static_cast<std::size_t>(cube.p[1]),
               pz = static_cast<std::size_t>(cube.p[2]);
    for (std::size_t z = 0, i = cube.first_node; z < pz; ++z)
      for (std::size_t y = 0; y < py; ++y)
        for (std::size_t x = 0; x < px; ++x, ++i) {
          grid.at[0][i] = node(cube, 0, static_cast<int>(x));
          grid.at[1][i] = node(cube, 1, static_cast<int>(y));
          grid.at[2][i] = node(cube, 2, static_cast<int>(z));
        }
    for (std::size_t i = cube.begin; i < cube.end; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        const double middle = (cube.low[k] + cube.high[k]) / 2, tau = (cube.high[k] - cube.low[k]) / 2;
        lagrange(tau > 0 ? (sources.at[k][i] - middle) / tau : 0.0, cube.p[k], chebyshev[k].data(), l[k].data());
      }
      for (std::size_t s = 0; s < 2; ++s)
        for (std::size_t c = 0; c < 3; ++c) {
          const double m = sources.normal[s][c][i];
          if (m == 0) continue;
          double* out = grid.normal[s][c].data() + cube.first_node;
          for (std::size_t z = 0; z < pz; ++z)
            for (std::size_t y = 0; y < py; ++y, out += px) {
              const double f = m * l[2][z] * l[1][y];
              for (std::size_t x = 0; x < px; ++x) out[x] += f * l[0][x];
            }
        }
    }
  }
};

/// ⟨1,1⟩, ⟨2,2⟩, ⟨1,2⟩ and ρ of what was summed, with what the kernel's errors can add to them.
struct Totals {
  std::array<Sum, 4> sums;
  std::array<Sum, 3> bounds;
  void add(const Totals& o) {
    for (std::size_t k = 0; k < 4; ++k) sums[k].add(o.sums[k]);
    for (std::size_t k = 0; k < 3; ++k) bounds[k].add(o.bounds[k]);
  }
};

struct Range {
  const Points* points;
  std::size_t begin, end;
};

/// For every target: Σ over the sources of one scan of n k, as three components (field[s][c][target]).
struct Field {
  std::array<std::array<std::vector<double>, 3>, 2> at;
  std::vector<double> kernel;
  void clear(std::size_t n) {
    for (auto& s : at)
      for (auto& c : s) c.assign(n, 0.0);
    kernel.resize(n);
  }
};

void add_directly(const Range& from, const Range& to, Field& field) {
  const std::size_t n = to.end - to.begin;
  field.clear(n);
  const double *x = to.points->at[0].data() + to.begin, *y = to.points->at[1].data() + to.begin,
               *z = to.points->at[2].data() + to.begin;
  double* k = field.kernel.data();
  for (std::size_t j = from.begin; j < from.end; ++j) {
    const double xj = from.points->at[0][j], yj = from.points->at[1][j], zj = from.points->at[2][j];
    for (std::size_t i = 0; i < n; ++i) {
      const double dx = x[i] - xj, dy = y[i] - yj, dz = z[i] - zj;
      k[i] = exp_minus(dx * dx + dy * dy + dz * dz);
    }
    for (std::size_t s = 0; s < 2; ++s)
      for (std::size_t c = 0; c < 3; ++c) {
        const double m = from.points->normal[s][c][j];
        if (m == 0) continue;
        double* out = field.at[s][c].data();
        for (std::size_t i = 0; i < n; ++i) out[i] += m * k[i];
      }
  }
}

/// out[o][b][i] = Σ_a in[o][a][i] matrix[a][b]: one side of the tensor.
void contract(const std::vector<double>& in, std::vector<double>& out, std::size_t outer, std::size_t pa,
              std::size_t pb, std::size_t inner, const std::vector<double>& matrix) {
  out.assign(outer * pb * inner, 0.0);
  for (std::size_t o = 0; o < outer; ++o)
    for (std::size_t b = 0; b < pb; ++b) {
      double* to = out.data() + (o * pb + b) * inner;
      for (std::size_t a = 0; a < pa; ++a) {
        const double m = matrix[a * pb + b];
        const double* from = in.data() + (o * pa + a) * inner;
        for (std::size_t i = 0; i < inner; ++i) to[i] += m * from[i];
      }
    }
}

// x is the fastest axis of a grid; contracted first by rows, so its matrix is walked along the targets.
void add_by_grids(const Cubes& all, const Cube& from, const Cube& to, Field& field) {
  std::array<std::vector<double>, 3> matrix;
  std::array<std::size_t, 3> pa{}, pb{};
  for (std::size_t k = 0; k < 3; ++k) {
    pa[k] = static_cast<std::size_t>(from.p[k]), pb[k] = static_cast<std::size_t>(to.p[k]);
    matrix[k].resize(pa[k] * pb[k]);
    for (std::size_t a = 0; a < pa[k]; ++a)
      for (std::size_t b = 0; b < pb[k]; ++b) {
        const double d = node(from, k, static_cast<int>(a)) - node(to, k, static_cast<int>(b));
        matrix[k][a * pb[k] + b] = exp_minus(d * d);
      }
  }
  field.clear(to.nodes());
  std::vector<double> first, second;
  for (std::size_t s = 0; s < 2; ++s)
    for (std::size_t c = 0; c < 3; ++c) {
      const double* m = all.grid.normal[s][c].data() + from.first_node;
      first.assign(pa[2] * pa[1] * pb[0], 0.0);
      for (std::size_t row = 0; row < pa[2] * pa[1]; ++row)
        for (std::size_t a = 0; a < pa[0]; ++a) {
          const double f = m[row * pa[0] + a];
          for (std::size_t b = 0; b < pb[0]; ++b) first[row * pb[0] + b] += f * matrix[0][a * pb[0] + b];
        }
      contract(first, second, pa[2], pa[1], pb[1], pb[0], matrix[1]);
      contract(second, field.at[s][c], 1, pa[2], pb[2], pb[1] * pb[0], matrix[2]);
    }
}

/// (n, field) at the targets, into the sums; `times` 2 for a pair of two cubes that stands for both its orders.
void sum_up(const Range& to, const Field& field, double times, Totals& totals) {
  double s11 = 0, s22 = 0, s12 = 0, s21 = 0, rho = 0;
  for (std::size_t i = to.begin; i < to.end; ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      const double m1 = to.points->normal[0][c][i], m2 = to.points->normal[1][c][i];
      const double f1 = field.at[0][c][i - to.begin], f2 = field.at[1][c][i - to.begin];
      s11 += m1 * f1, s22 += m2 * f2, s12 += m1 * f2, s21 += m2 * f1;
      rho += (m1 - m2) * (f1 - f2);
    }
  totals.sums[0].add(times * s11);
  totals.sums[1].add(times * s22);
  totals.sums[2].add(times * 0.5 * (s12 + s21));
  totals.sums[3].add(times * rho);
}

class FastSum {
 public:
  FastSum(const Cubes& all, double share) : all_(all), share_(share) {
    while (std::exp(-4.0 * reach_ * reach_) > 1e-3 * share) ++reach_;
  }

  [[nodiscard]] Totals run(const Context& context) const {
    Totals totals = reduce_blocks<Totals>(
        all_.cubes.size(), cubes_a_block,
        [&](std::size_t begin, std::size_t end) {
          context.check();
          Totals part;
          Field field;
          for (std::size_t i = begin; i < end; ++i) from_cube(i, field, part);
          return part;
        },
        [](Totals& total, const Totals& part) { total.add(part); });
    add_far_bound(totals);
    return totals;
  }

 private:
  // Cubes after this one in the order of keys, column by column: each pair is met once.
  void from_cube(std::size_t i, Field& field, Totals& totals) const {
    const Cube& cube = all_.cubes[i];
    pair(cube, cube, 1, field, totals);
    for (std::int64_t dx = 0; dx <= reach_; ++dx)
      for (std::int64_t dy = dx == 0 ? 0 : -reach_; dy <= reach_; ++dy) {
        const std::int64_t dz = dx == 0 && dy == 0 ? 1 : -reach_;
        const std::array<std::int64_t, 3> key{cube.key[0] + dx, cube.key[1] + dy, cube.key[2] + dz};
        auto other = std::lower_bound(all_.cubes.begin() + static_cast<std::ptrdiff_t>(i), all_.cubes.end(), key,
                                      [](const Cube& c, const auto& k) { return c.key < k; });
        for (; other != all_.cubes.end() && other->key[0] == key[0] && other->key[1] == key[1] &&
               other->key[2] <= cube.key[2] + reach_;
             ++other)
          pair(cube, *other, 2, field, totals);
      }
  }

  void pair(const Cube& a, const Cube& b, double times, Field& field, Totals& totals) const {
    std::array<double, 3> k{}, e{};
    const std::size_t in_a = a.end - a.begin, in_b = b.end - b.begin;
    const bool grid_a = a.has_grid() && a.nodes() < in_a, grid_b = b.has_grid() && b.nodes() < in_b;
    const auto direct = static_cast<double>(in_a) * static_cast<double>(in_b);
    const bool by_grids = a.has_grid() && b.has_grid() && cost_by_grids(a, b) < 2 * direct;
    const Range from = !by_grids && grid_a ? grid_of(a) : Range{&all_.sources, a.begin, a.end};
    const Range to = by_grids || grid_b ? grid_of(b) : Range{&all_.sources, b.begin, b.end};
    for (std::size_t side = 0; side < 3; ++side) {
      const double gap = std::max({0.0, a.low[side] - b.high[side], b.low[side] - a.high[side]});
      k[side] = std::exp(-gap * gap);
      const double ea = by_grids || grid_a ? a.error[side] : 0, eb = by_grids || grid_b ? b.error[side] : 0;
      const double lambda = std::max(a.has_grid() ? lebesgue(a.p[side]) : 1, b.has_grid() ? lebesgue(b.p[side]) : 1);
      e[side] = (std::max(ea, eb) + lambda * std::min(ea, eb)) * std::exp(-gap * gap / 2);
      if (ea > 0 && eb > 0) e[side] = std::max(ea + lambda * eb, eb + lambda * ea) * std::exp(-gap * gap / 2);
    }
    const double largest = k[0] * k[1] * k[2];
    double missed = (k[0] + e[0]) * (k[1] + e[1]) * (k[2] + e[2]) - largest + rounding * largest;
    const bool skip = largest < 0.1 * share_;
    if (skip) missed = largest;
    add_bound(times * missed, a.weight, b.weight, totals);
    if (skip) return;
    if (by_grids)
      add_by_grids(all_, a, b, field);
    else
      add_directly(from, to, field);
    sum_up(to, field, times, totals);
  }

  static void add_bound(double missed, const std::array<double, 2>& a, const std::array<double, 2>& b, Totals& totals) {
    totals.bounds[0].add(missed * a[0] * b[0]);
    totals.bounds[1].add(missed * a[1] * b[1]);
    totals.bounds[2].add(missed * 0.5 * (a[0] * b[1] + a[1] * b[0]));
  }

  // Of three tensor contractions of six components, against some forty operations a pair done directly.
  static double cost_by_grids(const Cube& a, const Cube& b) {
    const double x = a.p[0], y = a.p[1], z = a.p[2], u = b.p[0], v = b.p[1], w = b.p[2];
    return 0.3 * (z * y * x * u + z * y * v * u + z * w * v * u) + (x * u + y * v + z * w);
  }

  [[nodiscard]] Range grid_of(const Cube& c) const { return {&all_.grid, c.first_node, c.first_node + c.nodes()}; }

  // Pairs never looked at are at least 2 reach σ apart: all weights at that distance, or shell by shell the heaviest
  // cube in each place of it, whichever is less.
  void add_far_bound(Totals& totals) const {
    double shells = 0;
    for (double k = static_cast<double>(reach_) + 1; k < static_cast<double>(reach_) + 60; ++k)
      shells += (24 * k * k + 2) * std::exp(-4 * (k - 1) * (k - 1));
    const double nearest = std::exp(-4.0 * reach_ * reach_);
    std::array<double, 2> others{};
    for (std::size_t s = 0; s < 2; ++s) others[s] = std::min(nearest * all_.total[s], shells * all_.heaviest[s]);
    add_bound(1, all_.total, others, totals);
  }

  const Cubes& all_;
  double share_;
  std::int64_t reach_ = 1;
};

Totals direct_sum(const Points& sources, const Context& context) {
  constexpr std::size_t tile = 512;
  return reduce_blocks<Totals>(
      sources.size(), tile,
      [&](std::size_t begin, std::size_t end) {
        context.check();
        Totals part;
        Field field;
        const Range to{&sources, begin, end};
        for (std::size_t j = begin; j < sources.size(); j += tile) {
          add_directly({&sources, j, std::min(sources.size(), j + tile)}, to, field);
          sum_up(to, field, j == begin ? 1 : 2, part);
        }
        return part;
      },
      [](Totals& total, const Totals& part) { total.add(part); });
}

Currents result(const Totals& t, double sigma) {
  Currents c;
  c.sigma = sigma;
  c.norm_a2 = t.sums[0].value(), c.norm_b2 = t.sums[1].value(), c.inner = t.sums[2].value(), c.rho = t.sums[3].value();
  c.norm_a2_bound = t.bounds[0].value(), c.norm_b2_bound = t.bounds[1].value(), c.inner_bound = t.bounds[2].value();
  c.error_bound = c.norm_a2_bound + c.norm_b2_bound + 2 * c.inner_bound;
  return c;
}

/// The largest of the three bounds over what was asked for; infinite where nothing but 0 would do.
double excess(const Currents& c, double error) {
  const auto ratio = [&](double bound, double scale) { return bound == 0 ? 0.0 : bound / (error * scale); };
  const double a = std::max(c.norm_a2, 0.0), b = std::max(c.norm_b2, 0.0);
  return std::max({ratio(c.norm_a2_bound, a), ratio(c.norm_b2_bound, b), ratio(c.inner_bound, std::sqrt(a * b))});
}

void check(const CurrentsOptions& options) {
  if (!(options.sigma > 0) || std::isinf(options.sigma))
    throw UsageError(fmt::format("--sigma: {} is no width, give a length above 0", options.sigma));
  if (!(options.error >= 1e-11 && options.error < 1))
    throw UsageError(
        fmt::format("--currents-error: {} is out of range, give a relative error from 1e-11 to 1", options.error));
}

}  // namespace

Currents currents(const Current& a, const Current& b, const CurrentsOptions& options, const Context& context) {
  check(options);
  Cubes cubes(a, b, options.sigma);
  if (options.method == CurrentsMethod::direct) {
    Totals t = direct_sum(cubes.sources, context);
    const auto& w = cubes.total;
    t.bounds[0].add(rounding * w[0] * w[0]), t.bounds[1].add(rounding * w[1] * w[1]);
    t.bounds[2].add(rounding * w[0] * w[1]);
    return result(t, options.sigma);
  }
  double share = options.error / 4;
  for (int round = 1;; ++round) {
    cubes.make_grids(share);
    Currents c = result(FastSum(cubes, share).run(context), options.sigma);
    const double over = excess(c, options.error);
    c.reached = over <= 1;
    if (c.reached || round == most_rounds || share < 1e-16) return c;
    share = std::max(share * 0.5 / std::min(over, 1e6), 1e-17);
  }
}

}  // namespace isopach
