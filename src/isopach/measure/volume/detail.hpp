// detail: ρ_dV, the measure for scans of different detail (docs/method/different-detail.md). What the finer scan shows
// between the points of the coarser one is averaged over each triangle of the coarser mesh before its size is taken, so
// that detail which the coarser scan cannot hold cancels out and a bias does not. T1, T2 and their mutual locations are
// all it needs: O(n) once these are known. Whether the whole, locations included, can be had in O(n) in the worst case,
// as the paper claims by its theorem 3, is open: docs/method/localisation.md shows that the theorem does not hold.
#pragma once
#include <optional>
#include <span>

#include "isopach/base/context.hpp"
#include "isopach/base/fixed_sum.hpp"
#include "isopach/measure/measures.hpp"
#include "isopach/overlay/overlay.hpp"

namespace isopach {

class Domain;

/// ρ_dV and what it stands on. Unit of heights; areas in the unit of x and y, squared.
struct DetailMeasure {
  bool coarser_is_b = false;
  double rho = 0;      ///< Σ A |δ| / area
  double mean = 0;     ///< Σ A δ / area, δ as B − A
  double area = 0;     ///< of the triangles of the coarser mesh that count
  Index averaged = 0;  ///< of those, the ones that hold nodes of the finer mesh
  Index bare = 0;      ///< … and those that hold none
};

/// Sums over triangles of the mesh that is taken for the coarser one: exact, so that parts of a scan go together.
struct DetailSums {
  FixedSum area, above, below;  ///< Σ A; Σ A |δ| where the finer scan lies above, and elsewhere
  Index averaged = 0, bare = 0;

  DetailSums() = default;  ///< takes its grid from the first that is added
  explicit DetailSums(const SumBounds& bounds);
  void add(double of_triangle, double delta);
  void add(const DetailSums& part);
};

/// Which triangles of the coarser mesh are added up, and how.
struct DetailRule {
  bool extrapolate = false;
  const Domain& domain;
  SumBounds bounds;
  std::span<const unsigned char> asked = {};  ///< by real triangle of the coarser mesh; empty: all
};
[[nodiscard]] DetailSums detail_sums(const OverlayMesh& coarse, const OverlayMesh& fine, const DetailRule& rule,
                                     const Context& context);

/// The area of the kept triangles, of those that are asked for.
[[nodiscard]] FixedSum kept_area(const OverlayMesh& m, const SumBounds& bounds, std::span<const unsigned char> asked);

/// One scan of two, whole or the sums of its parts.
struct DetailOfScan {
  DetailSums as_coarser;
  FixedSum area;  ///< kept_area
  std::size_t nodes = 0;
};
/// Nothing if no triangle counts.
[[nodiscard]] std::optional<DetailMeasure> detail_of(const DetailOfScan& a, const DetailOfScan& b);

/// The coarser mesh is the one with the greater area of kept triangles per node; A if they are equal. For each of its
/// kept triangles t whose three nodes lie in kept triangles of the finer mesh (borders included),
///     δ = Σ w_q (f_fine(q) − f̂_coarse(q)) / Σ w_q
/// over the nodes q of the finer mesh in t, w_q a third of the area of the kept triangles at q. A node on an edge or a
/// node of the coarser mesh is shared equally by the kept triangles that touch it. A triangle without nodes takes the
/// mean of f̂_fine − f_coarse at its three nodes. The sign of δ is that of B − A whichever is the coarser. With
/// `extrapolate` (domain `hull`) all heights that are given for nodes outside the finer mesh count as known. The
/// `domain` cuts the areas: a triangle counts with its part inside, δ stays that of the whole triangle. Nothing
/// if no triangle counts. Exchanging a and b exchanges the sign of `mean` and leaves `rho`, to the last bit, unless
/// both meshes have the same area per node. Same bits for any number of threads and any order of points. Cost O(n), the
/// locations given.
/// Oracle: tests/measure/detail_test.cpp.
[[nodiscard]] std::optional<DetailMeasure> detail_measure(const OverlayMesh& a, const OverlayMesh& b, bool extrapolate,
                                                          const Domain& domain, const Context& context,
                                                          const std::optional<SumBounds>& bounds = {});

}  // namespace isopach
