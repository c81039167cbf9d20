// currents: two triangulated surfaces as currents, [Dyshkant2013], equations (4) and (5). With c the centroid
// and n the area-weighted normal of a triangle,
//   ⟨X, Y⟩ = Σ_i Σ_j (n_i, n_j) exp(−|c_i − c_j|² / σ²),   ρ(S1, S2) = ‖S1‖² + ‖S2‖² − 2 ⟨S1, S2⟩.
//
// Method `fast`: triangles are sorted into cubes of side 2 σ. Pairs of cubes too far apart are left out; near pairs are
// summed directly, or, where cubes are full, between the nodes of tensor Chebyshev grids on the box of what each cube
// holds ([Fong2009]; here on one level, since a Gaussian has no far field). A thin box
// has few nodes across, so a surface costs what a surface must.
//
// Error: in one dimension p Chebyshev nodes on a half-length τ (in σ) leave at most
//   2 (τ/2)^p max |f^(p)| / p!,  |f^(p)(x)| ≤ 1.09 √(2^p p!) exp(−x²/2)  (Cramér's inequality),
// and the product over three dimensions follows. What all pairs can miss is summed beside the sums themselves; while
// that bound is above what was asked for, the sums are taken again with a smaller share a pair.
#pragma once
#include <span>

#include "isopach/base/context.hpp"
#include "isopach/geom/vec.hpp"

namespace isopach {

/// A triangulated surface as a current: one centroid and one area-weighted normal a triangle. Finite numbers, one unit.
struct Current {
  std::span<const Point3> centroids, normals;
};

/// direct: the double sum over all pairs, the oracle of `fast`.
enum class CurrentsMethod { fast, direct };

struct CurrentsOptions {
  double sigma = 0;     ///< width of the kernel, unit of the centroids, > 0
  double error = 1e-6;  ///< of each norm relative to itself, of the inner product to the product of the norms
  CurrentsMethod method = CurrentsMethod::fast;
};

/// Squared norms, inner product and ρ in unit⁴, each with a bound of its absolute error.
struct Currents {
  double sigma = 0;
  double norm_a2 = 0, norm_b2 = 0, inner = 0;
  double rho = 0;  ///< summed from differences, not from the three numbers above
  double norm_a2_bound = 0, norm_b2_bound = 0, inner_bound = 0;
  double error_bound = 0;  ///< of rho
  bool reached = true;     ///< false: normals cancel so far that rounding alone exceeds options.error
};

/// UsageError, naming --sigma or --currents-error, if sigma or error is no number in its range.
void check(const CurrentsOptions& options);

/// Cost: near-linear for `fast` (linear in triangles that lie in as many cubes each), quadratic for `direct`, which is
/// its oracle (tests/measure/currents_test.cpp); memory near 100 bytes a triangle, to 400 where every cube has a grid.
/// Parallel; the same bits for any number of threads. Errors: as check, and UsageError where coordinates are 10^13
/// times sigma. An empty current has norm 0.
[[nodiscard]] Currents currents(const Current& a, const Current& b, const CurrentsOptions& options,
                                const Context& context);

}  // namespace isopach
