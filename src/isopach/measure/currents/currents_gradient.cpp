#include "isopach/measure/currents/currents_gradient.hpp"

#include <cassert>

#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/measure/currents/currents_pairs.hpp"

namespace isopach {
namespace {

using namespace currents_parts;

// A derivative is less smooth than its kernel: the nodes of a grid are chosen for this much less error.
constexpr double derivative_margin = 1.0 / 64;
constexpr std::size_t direct_tile = 512;

/// Σ of what pulls at triangles of a: lengths in σ.
struct Pull {
  Sum inner;
  std::array<Sum, 3> force, torque;
  void add(const Pull& o) {
    inner.add(o.inner);
    for (std::size_t k = 0; k < 3; ++k) force[k].add(o.force[k]), torque[k].add(o.torque[k]);
  }
};

/// At every target: F, and the derivatives of (n, F) along the axes.
struct PullField {
  std::array<std::vector<double>, 3> value, slope;
  std::vector<double> kernel, weight;
  TensorRoom room;
  void clear(std::size_t n) {
    for (auto* components : {&value, &slope})
      for (auto& c : *components) c.assign(n, 0.0);
  }
};

void pull_directly(const Range& from, const Range& to, const Vector& offset, PullField& field) {
  const std::size_t n = to.size();
  field.clear(n);
  field.kernel.resize(n);
  field.weight.resize(n);
  const auto& own = to.points->normal[0];
  for (std::size_t j = from.begin; j < from.end; ++j) {
    Vector at, m;
    for (std::size_t k = 0; k < 3; ++k) at[k] = from.points->at[k][j] - offset[k], m[k] = from.points->normal[1][k][j];
    kernels(to, at, field.kernel.data());
    const double *x = own[0].data() + to.begin, *y = own[1].data() + to.begin, *z = own[2].data() + to.begin;
    for (std::size_t i = 0; i < n; ++i)
      field.weight[i] = -2 * field.kernel[i] * (m[0] * x[i] + m[1] * y[i] + m[2] * z[i]);
    for (std::size_t k = 0; k < 3; ++k) {
      const double* place = to.points->at[k].data() + to.begin;
      double *value = field.value[k].data(), *slope = field.slope[k].data();
      for (std::size_t i = 0; i < n; ++i) value[i] += m[k] * field.kernel[i];
      for (std::size_t i = 0; i < n; ++i) slope[i] += field.weight[i] * (place[i] - at[k]);
    }
  }
}

void pull_by_grids(const Cubes& all, const Cube& from, const Cube& to, const Vector& offset, PullField& field) {
  const std::array<AxisMatrix, 3> axes = axis_matrices(from, to, offset, true);
  field.clear(to.nodes());
  for (std::size_t c = 0; c < 3; ++c) {
    const double* in = all.grids().normal[1][c].data() + from.first_node;
    const double* own = all.grids().normal[0][c].data() + to.first_node;
    contract(in, axes, {&axes[0].value, &axes[1].value, &axes[2].value}, field.value[c], field.room);
    for (std::size_t k = 0; k < 3; ++k) {
      std::array<const std::vector<double>*, 3> matrices{&axes[0].value, &axes[1].value, &axes[2].value};
      matrices[k] = &axes[k].slope;
      contract(in, axes, matrices, field.weight, field.room);
      for (std::size_t i = 0; i < to.nodes(); ++i) field.slope[k][i] += own[i] * field.weight[i];
    }
  }
}

/// `corner`: of the targets' cube less the centre.
void add_pulls(const Range& to, const PullField& field, const Vector& corner, Pull& pull) {
  double inner = 0;
  Vector force{}, torque{};
  const auto& p = *to.points;
  for (std::size_t i = 0; i < to.size(); ++i) {
    Vector n, r, f, g;
    for (std::size_t k = 0; k < 3; ++k) {
      n[k] = p.normal[0][k][to.begin + i], r[k] = corner[k] + p.at[k][to.begin + i];
      f[k] = field.value[k][i], g[k] = field.slope[k][i];
      inner += n[k] * f[k];
      force[k] += g[k];
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t u = (k + 1) % 3, v = (k + 2) % 3;
      torque[k] += n[u] * f[v] - n[v] * f[u] + r[u] * g[v] - r[v] * g[u];
    }
  }
  pull.inner.add(inner);
  for (std::size_t k = 0; k < 3; ++k) pull.force[k].add(force[k]), pull.torque[k].add(torque[k]);
}

/// What the triangles of b in `from` do to those of a in `to`.
void add_pair(const Cubes& all, const Cube& from, const Cube& to, const Point3& centre, PullField& field, Pull& pull) {
  const std::size_t sources = from.end - from.middle, targets = to.middle - to.begin;
  if (sources == 0 || targets == 0) return;
  const Plan p = plan(from, sources, to, targets);
  const Vector offset = all.offset(from, to);
  if (pair_error(from, to, p, offset).largest < 0.1 * all.share()) return;
  const Range range_to = p.grid_to ? all.grid_of(to) : Range{&all.sources(), to.begin, to.middle};
  if (p.by_grids)
    pull_by_grids(all, from, to, offset, field);
  else
    pull_directly(p.grid_from ? all.grid_of(from) : Range{&all.sources(), from.middle, from.end}, range_to, offset,
                  field);
  add_pulls(range_to, field, all.corner(to, centre), pull);
}

/// By cube: what pulls at the triangles of a in it.
std::vector<Pull> fast_pulls(const Cubes& all, const Point3& centre, const Context& context) {
  std::vector<Pull> pulls(all.cubes().size());
  for_blocks(pulls.size(), cubes_a_block, [&](std::size_t begin, std::size_t end) {
    context.check();
    PullField field;
    for (std::size_t i = begin; i < end; ++i)
      all.for_each_near(i, [&](const Cube& other) { add_pair(all, other, all.cubes()[i], centre, field, pulls[i]); });
  });
  return pulls;
}

/// The oracle: every pair.
std::vector<Pull> direct_pulls(const Cubes& all, const Point3& centre, const Context& context) {
  const std::vector<Cube>& cubes = all.cubes();
  std::vector<Pull> pulls(cubes.size());
  for_blocks(cubes.size(), 1, [&](std::size_t begin, std::size_t end) {
    context.check();
    PullField field;
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t at = cubes[i].begin; at < cubes[i].middle; at += direct_tile) {
        const Range to{&all.sources(), at, std::min(cubes[i].middle, at + direct_tile)};
        for (const Cube& from : cubes) {
          if (from.middle == from.end) continue;
          pull_directly({&all.sources(), from.middle, from.end}, to, all.offset(from, cubes[i]), field);
          add_pulls(to, field, all.corner(cubes[i], centre), pulls[i]);
        }
      }
  });
  return pulls;
}

CurrentsGradient gradient_of(const Pull& pull, double sigma) {
  CurrentsGradient g;
  g.inner = pull.inner.value();
  for (std::size_t k = 0; k < 3; ++k) {
    g.shift[k] = -2 * pull.force[k].value() / sigma;
    g.turn[k] = -2 * pull.torque[k].value();
  }
  return g;
}

struct Pulls {
  Cubes cubes;
  std::vector<Pull> by_cube;
};
Pulls pulls_of(const Current& a, const Current& b, const Point3& centre, const CurrentsOptions& options,
               const Context& context) {
  assert(a.centroids.size() == a.normals.size() && b.centroids.size() == b.normals.size());
  check(options);
  Pulls p{Cubes(a, b, options.sigma), {}};
  const bool direct = options.method == CurrentsMethod::direct;
  if (!direct) p.cubes.make_grids(options.error * derivative_margin);
  p.by_cube = direct ? direct_pulls(p.cubes, centre, context) : fast_pulls(p.cubes, centre, context);
  return p;
}

}  // namespace

CurrentsGradient currents_gradient(const Current& a, const Current& b, const Point3& centre,
                                   const CurrentsOptions& options, const Context& context) {
  Pull total;
  for (const Pull& pull : pulls_of(a, b, centre, options, context).by_cube) total.add(pull);
  return gradient_of(total, options.sigma);
}

std::vector<CurrentsGradient> currents_gradient_by_cube(const Current& a, const Current& b, const Point3& centre,
                                                        const CurrentsOptions& options, const Context& context) {
  const Pulls p = pulls_of(a, b, centre, options, context);
  std::vector<CurrentsGradient> parts;
  for (std::size_t i = 0; i < p.by_cube.size(); ++i)
    if (p.cubes.cubes()[i].middle > p.cubes.cubes()[i].begin) parts.push_back(gradient_of(p.by_cube[i], options.sigma));
  return parts;
}

}  // namespace isopach
