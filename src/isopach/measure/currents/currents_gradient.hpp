// Derivatives of the distance of two currents by a rigid motion of the first. With F(x) = Σ_j n_j k(x, c_j) over the
// triangles of b, the inner product ⟨a, b⟩ = Σ_i (n_i, F(c_i)) pulls at every triangle of a with the force
// g_i = ∇(n_i, F)(c_i) and the torque n_i × F(c_i) + (c_i − centre) × g_i; norms do not change under a rigid motion, so
// the derivatives of ρ are −2 times their sums. Cubes and grids as in currents.hpp: a grid's nodes are pulled in place
// of the triangles that they stand for.
#pragma once
#include <array>
#include <vector>

#include "isopach/measure/currents/currents.hpp"

namespace isopach {

struct CurrentsGradient {
  double inner = 0;               ///< ⟨a, b⟩, unit⁴
  std::array<double, 3> turn{};   ///< of ρ by a rotation vector (rad) of a about the centre, at no rotation, unit⁴
  std::array<double, 3> shift{};  ///< of ρ by a shift of a, unit³
};

/// Cost near-linear, as currents; no norm is summed. The error of `inner` is below options.error times the product of
/// the norms, that of `shift` below it over sigma (measured, not proven: the method `direct` is the oracle, and finite
/// differences are that of both, tests/measure/currents_gradient_test.cpp). Parallel; the same bits for any number of
/// threads. Errors as currents. Degenerate: an empty current gives zeros.
[[nodiscard]] CurrentsGradient currents_gradient(const Current& a, const Current& b, const Point3& centre,
                                                 const CurrentsOptions& options, const Context& context);

/// The same in parts that add up to it: one for every cube of side 2 sigma that holds triangles of `a`, in an order
/// that depends on a and sigma alone.
[[nodiscard]] std::vector<CurrentsGradient> currents_gradient_by_cube(const Current& a, const Current& b,
                                                                      const Point3& centre,
                                                                      const CurrentsOptions& options,
                                                                      const Context& context);

}  // namespace isopach
