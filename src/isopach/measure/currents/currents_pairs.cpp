#include "isopach/measure/currents/currents_pairs.hpp"

#include <cmath>

#include "isopach/measure/currents/currents_kernel.hpp"

namespace isopach::currents_parts {

namespace {

// Of three tensor contractions of six components, against some forty operations a pair done directly.
double cost_by_grids(const Cube& a, const Cube& b) {
  const double x = a.p[0], y = a.p[1], z = a.p[2], u = b.p[0], v = b.p[1], w = b.p[2];
  return 0.3 * (z * y * x * u + z * y * v * u + z * w * v * u) + (x * u + y * v + z * w);
}

/// out[o][b][i] = Σ_a in[o][a][i] matrix[a][b]: one axis of a tensor, `inner` > 1.
void contract_axis(const std::vector<double>& in, std::vector<double>& out, std::size_t outer, std::size_t inner,
                   const AxisMatrix& axis, const std::vector<double>& matrix) {
  out.assign(outer * axis.to * inner, 0.0);
  for (std::size_t o = 0; o < outer; ++o)
    for (std::size_t b = 0; b < axis.to; ++b) {
      double* to = out.data() + (o * axis.to + b) * inner;
      for (std::size_t a = 0; a < axis.from; ++a) {
        const double m = matrix[a * axis.to + b];
        const double* from = in.data() + (o * axis.from + a) * inner;
        for (std::size_t i = 0; i < inner; ++i) to[i] += m * from[i];
      }
    }
}

}  // namespace

Plan plan(const Cube& from, std::size_t sources_from, const Cube& to, std::size_t sources_to) {
  Plan p;
  const auto direct = static_cast<double>(sources_from) * static_cast<double>(sources_to);
  p.by_grids = from.has_grid() && to.has_grid() && cost_by_grids(from, to) < 2 * direct;
  p.grid_from = p.by_grids || (from.has_grid() && from.nodes() < sources_from);
  p.grid_to = p.by_grids || (to.has_grid() && to.nodes() < sources_to);
  return p;
}

PairError pair_error(const Cube& from, const Cube& to, const Plan& plan, const Vector& offset) {
  double largest = 1, with_error = 1;
  for (std::size_t k = 0; k < 3; ++k) {
    const double gap = std::max({0.0, from.low[k] - offset[k] - to.high[k], to.low[k] - from.high[k] + offset[k]});
    const double value = std::exp(-gap * gap), envelope = std::exp(-gap * gap / 2);
    const double e = plan.grid_from ? from.error[k] : 0, f = plan.grid_to ? to.error[k] : 0;
    // f interpolated in one place, then in the other: e + Λ f, in whichever order is worse.
    const double both = std::max(e + lebesgue(from.p[k]) * f, f + lebesgue(to.p[k]) * e);
    largest *= value;
    with_error *= value + envelope * (e > 0 && f > 0 ? both : e + f);
  }
  return {largest, with_error - largest + pair_rounding * largest};
}

std::array<AxisMatrix, 3> axis_matrices(const Cube& from, const Cube& to, const Vector& offset, bool with_slopes) {
  std::array<AxisMatrix, 3> axes;
  for (std::size_t k = 0; k < 3; ++k) {
    AxisMatrix& m = axes[k];
    m.from = static_cast<std::size_t>(from.p[k]), m.to = static_cast<std::size_t>(to.p[k]);
    m.value.resize(m.from * m.to);
    if (with_slopes) m.slope.resize(m.from * m.to);
    std::array<double, most_nodes> places{};
    for (int b = 0; b < to.p[k]; ++b) places[static_cast<std::size_t>(b)] = to.node(k, b) + offset[k];
    for (std::size_t a = 0; a < m.from; ++a) {
      const double at = from.node(k, static_cast<int>(a));
      for (std::size_t b = 0; b < m.to; ++b) {
        const double d = places[b] - at;
        m.value[a * m.to + b] = exp_minus(d * d);
        if (with_slopes) m.slope[a * m.to + b] = -2 * d * m.value[a * m.to + b];
      }
    }
  }
  return axes;
}

// The x axis first, by rows, so that its matrix is walked along the targets.
void contract(const double* in, const std::array<AxisMatrix, 3>& axes,
              const std::array<const std::vector<double>*, 3>& matrices, std::vector<double>& out, TensorRoom& room) {
  const AxisMatrix &x = axes[0], &y = axes[1], &z = axes[2];
  room.first.assign(z.from * y.from * x.to, 0.0);
  for (std::size_t row = 0; row < z.from * y.from; ++row)
    for (std::size_t a = 0; a < x.from; ++a) {
      const double f = in[row * x.from + a];
      const double* m = matrices[0]->data() + a * x.to;
      double* to = room.first.data() + row * x.to;
      for (std::size_t b = 0; b < x.to; ++b) to[b] += f * m[b];
    }
  contract_axis(room.first, room.second, z.from, x.to, y, *matrices[1]);
  contract_axis(room.second, out, 1, y.to * x.to, z, *matrices[2]);
}

void kernels(const Range& to, const Vector& at, double* kernel) {
  const double *x = to.points->at[0].data() + to.begin, *y = to.points->at[1].data() + to.begin,
               *z = to.points->at[2].data() + to.begin;
  for (std::size_t i = 0; i < to.size(); ++i) {
    const double dx = x[i] - at[0], dy = y[i] - at[1], dz = z[i] - at[2];
    kernel[i] = exp_minus(dx * dx + dy * dy + dz * dz);
  }
}

}  // namespace isopach::currents_parts
