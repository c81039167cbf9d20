// Measures: the numbers of one comparison, from cells with the difference at their corners (docs/method/method.md,
// section 2). d = f̂2 − f̂1, positive where the second scan lies above. All by area over the domain, on the piecewise
// linear d.
#pragma once
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/delaunay/first_corner.hpp"
#include "isopach/delaunay/triangulation.hpp"
#include "isopach/field/height_field.hpp"
#include "isopach/overlay/overlay.hpp"
#include "isopach/overlay/regions.hpp"

namespace isopach {

struct Volume {
  double above = 0;     ///< ∫ max(d, 0)
  double below = 0;     ///< ∫ max(−d, 0)
  double net = 0;       ///< above − below
  double absolute = 0;  ///< above + below
};

struct Histogram {
  std::vector<double> edges;  ///< k + 1 values of d, ascending, symmetric round 0
  std::vector<double> areas;  ///< k areas; d outside the edges is counted in the outermost bins
};

/// |d| is at most `value` on `level` percent of the area.
struct Percentile {
  double level = 0, value = 0;
};

/// UsageError unless every level lies between 0 and 100.
void check_percentiles(std::span<const double> levels);

struct DifferenceStatistics {
  double mean = 0, rms = 0, std = 0;
  double median = 0, nmad = 0;               ///< nmad = 1.4826 · median |d − median(d)|
  double max_above = 0, max_below = 0;       ///< largest d and largest −d, both ≥ 0
  std::array<double, 4> abs_percentiles{};   ///< of |d|, see percentile_levels
  std::vector<Percentile> more_percentiles;  ///< of |d|, those that were asked for beside them, in that order
  Histogram histogram;
};
inline constexpr std::array<int, 4> percentile_levels{50, 90, 95, 99};

struct Measures {
  double area = 0;            ///< of the domain
  double rho = 0;             ///< (7): ∫ |d| / area
  double error_estimate = 0;  ///< of rho, by the integration; 0 for closed forms, else see bend.hpp
  Volume volume;
  DifferenceStatistics difference;
};

/// Nodes at the ends of the side that a corner of a piece lies on; no_index where it lies on none.
using SideEnds = std::array<Index, 2>;

/// A part of a triangle of T that is clipped: a triangle with both surfaces at its corners.
struct CellPiece {
  Index cell;  ///< the triangle of T it was cut from
  std::array<Corner, 3> at;
  /// By scan and corner: the side of its border that its height there is of.
  std::array<std::array<SideEnds, 3>, 2> border{{{{{no_index, no_index}, {no_index, no_index}, {no_index, no_index}}},
                                                 {{{no_index, no_index}, {no_index, no_index}, {no_index, no_index}}}}};
};

/// What no sum over cells exceeds: the scale of exact sums is made of it (base/fixed_sum.hpp), so it may be far too
/// large, but not too small.
struct SumBounds {
  double area = 0;        ///< of the box of all nodes; of cells that do not overlap
  double difference = 0;  ///< |d|: z2 and z1 lie within the heights at the nodes
};

/// Of the box of all points of both scans; zeros where the frame knows none. A function of the pair, not of the nodes
/// that take part: sums over parts of the scans go together.
[[nodiscard]] SumBounds bounds_of(const Frame& frame);

/// The cells that are measured: real triangles of T whose flag is set, d = z2 − z1 linear on each, and the pieces of
/// those that the domain holds a part of (see source.hpp).
struct CellView {
  const Triangulation& t;
  std::span<const Point2> xy;
  std::span<const double> z1, z2;
  std::span<const unsigned char> in_domain;  ///< one per real triangle: measured as a whole
  std::span<const CellPiece> pieces = {};
  std::optional<SumBounds> bounds = {};  ///< what bounds_of says, where that is known

  [[nodiscard]] double d(Index node) const { return z2[node] - z1[node]; }
  /// Of a triangle of T, counter-clockwise, the first on the curve first: however T was made.
  [[nodiscard]] std::array<Index, 3> corners(std::size_t triangle) const {
    return from_first_corner(t.triangles[triangle].v);
  }
};

/// From the box and the heights of all nodes, in the domain or not. Heights that are no number do not count. Cost
/// O(nodes), nothing where the view has them.
[[nodiscard]] SumBounds bounds_of(const CellView& cells);

/// One cell: area and the three differences.
struct Cell {
  double area;
  std::array<double, 3> d;
};
[[nodiscard]] inline Cell cell_at(const CellView& cells, std::size_t i) {
  const std::array<Index, 3> v = cells.corners(i);
  return {triangle_area(cells.xy[v[0]], cells.xy[v[1]], cells.xy[v[2]]), {cells.d(v[0]), cells.d(v[1]), cells.d(v[2])}};
}

[[nodiscard]] inline Cell cell_of(const CellPiece& p) {
  const auto& [a, b, c] = p.at;
  return {triangle_area({a.x, a.y}, {b.x, b.y}, {c.x, c.y}), {a.d(), b.d(), c.d()}};
}

/// ∫ max(d, 0) and ∫ max(−d, 0) over one cell, in closed form: sums of products of one sign, no cancellation. Exactly
/// mirrored by d → −d. (docs/method/method.md, section 1.)
struct Parts {
  double above, below;
};
[[nodiscard]] Parts split_volume(const Cell& cell);

/// All measures over the domain. Area 0 (no cell) gives zeros. Sums are exact (base/fixed_sum.hpp): the same bits for
/// any number of threads and any numbering of the triangles; swapping the surfaces swaps above and below to the last
/// bit. InputError if an area or an integral is no finite number. Cost O(cells). Oracle: tests/measure (subdivision,
/// closed forms, sampling; rational numbers for the sums). `percentiles`: levels of more_percentiles, see
/// check_percentiles.
[[nodiscard]] Measures measure(const CellView& cells, const Context& context, std::span<const double> percentiles = {});

struct OverlayCells;

/// The same over the cells of the exact overlay of both meshes: the exact integrals between the two piecewise linear
/// surfaces. The cells are not kept but made as they are asked for: in one pass, and again where a first guess of a
/// quantile was not near enough. Oracle: tests/overlay/overlay_test.cpp.
[[nodiscard]] Measures measure(const OverlayCells& cells, const Context& context,
                               std::span<const double> percentiles = {});

/// … in one pass, without median, nmad, percentiles and histogram (which stay 0 and empty).
[[nodiscard]] Measures sum_up(const OverlayCells& cells, const Context& context);

}  // namespace isopach
