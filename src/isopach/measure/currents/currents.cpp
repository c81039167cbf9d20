#include "isopach/measure/currents/currents.hpp"

#include <fmt/format.h>

#include <cassert>
#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/measure/currents/currents_pairs.hpp"

namespace isopach {
namespace {

using namespace currents_parts;

constexpr int most_rounds = 8;
constexpr std::size_t direct_tile = 512;

/// ⟨1,1⟩, ⟨2,2⟩, ⟨1,2⟩ and ρ of what was summed, with what the kernel's errors can add to them.
struct Totals {
  std::array<Sum, 4> sums;
  std::array<Sum, 3> bounds;
  void add(const Totals& o) {
    for (std::size_t k = 0; k < 4; ++k) sums[k].add(o.sums[k]);
    for (std::size_t k = 0; k < 3; ++k) bounds[k].add(o.bounds[k]);
  }
  void add_bound(double missed, const std::array<double, 2>& a, const std::array<double, 2>& b) {
    bounds[0].add(missed * a[0] * b[0]);
    bounds[1].add(missed * a[1] * b[1]);
    bounds[2].add(missed * 0.5 * (a[0] * b[1] + a[1] * b[0]));
  }
};

/// For every target: Σ over the sources of one scan of n k, by scan and component.
struct Field {
  std::array<std::array<std::vector<double>, 3>, 2> at;
  std::vector<double> kernel;
  TensorRoom room;
};

void sum_directly(const Range& from, const Range& to, const Vector& offset, Field& field) {
  const std::size_t n = to.size();
  for (auto& scan : field.at)
    for (auto& c : scan) c.assign(n, 0.0);
  field.kernel.resize(n);
  const Points& p = *from.points;
  for (std::size_t j = from.begin; j < from.end; ++j) {
    kernels(to, {p.at[0][j] - offset[0], p.at[1][j] - offset[1], p.at[2][j] - offset[2]}, field.kernel.data());
    for (std::size_t s = 0; s < 2; ++s)
      for (std::size_t c = 0; c < 3; ++c) {
        const double m = p.normal[s][c][j];
        if (m == 0) continue;  // of the other scan
        double* out = field.at[s][c].data();
        for (std::size_t i = 0; i < n; ++i) out[i] += m * field.kernel[i];
      }
  }
}

void sum_by_grids(const Cubes& all, const Cube& from, const Cube& to, const Vector& offset, Field& field) {
  const std::array<AxisMatrix, 3> axes = axis_matrices(from, to, offset, false);
  for (std::size_t s = 0; s < 2; ++s)
    for (std::size_t c = 0; c < 3; ++c)
      contract(all.grids().normal[s][c].data() + from.first_node, axes,
               {&axes[0].value, &axes[1].value, &axes[2].value}, field.at[s][c], field.room);
}

/// (n, field) at the targets, into the sums; `times` 2 for a pair of two cubes that stands for both its orders.
void add_products(const Range& to, const Field& field, double times, Totals& totals) {
  double s11 = 0, s22 = 0, s12 = 0, s21 = 0, rho = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const double *n1 = to.points->normal[0][c].data() + to.begin, *n2 = to.points->normal[1][c].data() + to.begin;
    for (std::size_t i = 0; i < to.size(); ++i) {
      const double f1 = field.at[0][c][i], f2 = field.at[1][c][i];
      s11 += n1[i] * f1, s22 += n2[i] * f2, s12 += n1[i] * f2, s21 += n2[i] * f1;
      rho += (n1[i] - n2[i]) * (f1 - f2);
    }
  }
  totals.sums[0].add(times * s11);
  totals.sums[1].add(times * s22);
  totals.sums[2].add(times * 0.5 * (s12 + s21));
  totals.sums[3].add(times * rho);
}

void add_pair(const Cubes& all, const Cube& from, const Cube& to, double times, Field& field, Totals& totals) {
  const Plan p = plan(from, from.sources(), to, to.sources());
  const Vector offset = all.offset(from, to);
  const PairError error = pair_error(from, to, p, offset);
  const bool skip = error.largest < 0.1 * all.share();
  totals.add_bound(times * (skip ? error.largest : error.missed), from.weight, to.weight);
  if (skip) return;
  const Range targets = p.grid_to ? all.grid_of(to) : all.sources_of(to);
  if (p.by_grids)
    sum_by_grids(all, from, to, offset, field);
  else
    sum_directly(p.grid_from ? all.grid_of(from) : all.sources_of(from), targets, offset, field);
  add_products(targets, field, times, totals);
}

Totals fast_sum(const Cubes& all, const Context& context) {
  Totals totals = reduce_blocks<Totals>(
      all.cubes().size(), cubes_a_block,
      [&](std::size_t begin, std::size_t end) {
        context.check();
        Totals part;
        Field field;
        for (std::size_t i = begin; i < end; ++i) {
          const Cube& cube = all.cubes()[i];
          add_pair(all, cube, cube, 1, field, part);
          all.for_each_after(i, [&](const Cube& other) { add_pair(all, cube, other, 2, field, part); });
        }
        return part;
      },
      [](Totals& total, const Totals& part) { total.add(part); });
  totals.add_bound(1, all.total(), all.beyond_reach());
  return totals;
}

/// The oracle: every pair. Tiles lie in one cube each, so that places are as exact as in the fast sum.
Totals direct_sum(const Cubes& all, const Context& context) {
  struct Tile {
    const Cube* cube;
    Range range;
  };
  std::vector<Tile> tiles;
  for (const Cube& c : all.cubes())
    for (std::size_t i = c.begin; i < c.end; i += direct_tile)
      tiles.push_back({&c, {&all.sources(), i, std::min(c.end, i + direct_tile)}});
  Totals totals = reduce_blocks<Totals>(
      tiles.size(), 1,
      [&](std::size_t begin, std::size_t end) {
        context.check();
        Totals part;
        Field field;
        for (std::size_t t = begin; t < end; ++t)
          for (std::size_t u = t; u < tiles.size(); ++u) {
            sum_directly(tiles[u].range, tiles[t].range, all.offset(*tiles[u].cube, *tiles[t].cube), field);
            add_products(tiles[t].range, field, u == t ? 1 : 2, part);
          }
        return part;
      },
      [](Totals& total, const Totals& part) { total.add(part); });
  totals.add_bound(pair_rounding, all.total(), all.total());
  return totals;
}

Currents result(const Totals& t, double sigma) {
  Currents c;
  c.sigma = sigma;
  c.norm_a2 = t.sums[0].value(), c.norm_b2 = t.sums[1].value(), c.inner = t.sums[2].value();
  c.rho = std::max(0.0, t.sums[3].value());  // a squared norm
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

}  // namespace

void check(const CurrentsOptions& options) {
  if (!(options.sigma > 0 && options.sigma < 1e100))
    throw UsageError(fmt::format("@sigma: {} is no width, give a length above 0", options.sigma));
  if (!(options.error >= 1e-11 && options.error < 1))
    throw UsageError(
        fmt::format("@currents-error: {} is out of range, give a relative error from 1e-11 to below 1", options.error));
}

Currents currents(const Current& a, const Current& b, const CurrentsOptions& options, const Context& context) {
  assert(a.centroids.size() == a.normals.size() && b.centroids.size() == b.normals.size());
  check(options);
  Cubes cubes(a, b, options.sigma);
  if (options.method == CurrentsMethod::direct) return result(direct_sum(cubes, context), options.sigma);
  double share = options.error / 8;  // what the far and the cancelling pairs leave of it
  for (int round = 1;; ++round) {
    cubes.make_grids(share);
    Currents c = result(fast_sum(cubes, context), options.sigma);
    const double over = excess(c, options.error);
    c.reached = over <= 1;
    if (c.reached || round == most_rounds || share < 1e-16) return c;
    share = std::max(share * 0.5 / std::min(over, 1e6), 1e-17);
  }
}

}  // namespace isopach
