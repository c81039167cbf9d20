// detection: the part of a difference that is larger than its noise. A level of detection L(x, y) ≥ 0, linear on each
// cell, parts the domain into where |d| > L (significant) and the rest.
#pragma once
#include <array>
#include <span>

#include "isopach/measure/parted_cells.hpp"
#include "isopach/measure/source.hpp"

namespace isopach {

/// k such that a normal variable lies within ±k standard deviations with probability `confidence`, 0 < confidence < 1:
/// 1.96 for 0.95. To the last digits (bisection on erfc). Oracle: tests/measure/detection_test.cpp.
[[nodiscard]] double normal_deviations(double confidence);

/// ∫ over the part of a triangle of area 1 where the linear function with values s at the corners is > 0, of each of
/// the three hat functions. Their sum is the share of the area; Σ shares[i] · f[i] is the integral of a linear f. In
/// closed form. Oracle: tests/measure/detection_test.cpp (clipping).
[[nodiscard]] std::array<double, 3> positive_shares(const std::array<double, 3>& s);

/// Gross volumes and area of the significant part alone. There is no net: leaving out small differences favours
/// the sign that has the larger ones, so a net of the rest is biased.
struct Detected {
  double above = 0;  ///< ∫ d where d > L
  double below = 0;  ///< ∫ −d where −d > L
  double area = 0;   ///< where |d| > L
};

/// Of one cell with levels `lod` at its corners, exactly.
[[nodiscard]] Detected detect(const Cell& cell, const std::array<double, 3>& lod);

/// Over the domain; `lod` per node of T. Exact sums. Cost O(cells).
[[nodiscard]] Detected detect(const CellView& cells, std::span<const double> lod, const Context& context);

/// The same with one level everywhere.
[[nodiscard]] Detected detect(const CellView& cells, double lod, const Context& context);
[[nodiscard]] Detected detect(const OverlayCells& cells, double lod, const Context& context);
[[nodiscard]] Detected detect(const PartedCells& cells, double lod, const Context& context);

/// A level that varies over the overlay: k √(Σ (s1² + s2²) + rest²), where s1, s2 run over overlays of the same meshes
/// whose heights are standard deviations, linear on every cell; rest is the same everywhere.
struct OverlayLevel {
  std::span<const Overlay> deviations;
  double rest = 0, k = 1;
};

/// … with that level at the corners of every cell, linear in the triangles that a cell is cut into from its first
/// corner. There it is a little too high in between, for the root bends downwards: nothing is called significant that
/// is not. Cost O(cells) for each overlay.
/// Oracle: tests/measure/overlay_detection_test.cpp (all pairs of triangles clipped; dense sampling).
[[nodiscard]] Detected detect(const OverlayCells& cells, const OverlayLevel& level, const Context& context);

/// That level at the vertices of surface_of(cells) within the domain. Cost and memory as there.
[[nodiscard]] Array<double> level_at_vertices(const OverlayLevel& level, const Domain& domain, const Context& context);

}  // namespace isopach
