// The cells of a comparison as one mesh of triangles with both surfaces at its corners, and what is asked of it: values
// at places, sections, integrals over pixels. Arrays alone, so that a result that was stored can be asked, too.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "isopach/base/array.hpp"
#include "isopach/base/context.hpp"
#include "isopach/compare/comparison.hpp"
#include "isopach/overlay/regions.hpp"

namespace isopach {

/// The measured cells: whole triangles of T and the pieces that the domain cuts; of --surface overlay the cells of the
/// overlay. Frame coordinates: u = axes · input = field + offset, with u, v, w along the rows of `axes`.
struct MeasuredCells {
  Array<Point2> xy;
  Array<double> z1, z2;
  Array<double> lod;  ///< level of detection at the corners of cells; empty if there is none
  Array<std::array<std::int32_t, 3>> triangles;
  std::array<double, 3> offset{};
  std::array<double, 9> axes{};
};
[[nodiscard]] MeasuredCells measured_cells(const Comparison& c);
[[nodiscard]] MeasuredCells measured_cells(const Cells& cells, const Frame& frame);

/// The same with triangles in the order of their corners, each from its first: what is added up over them then does not
/// depend on how T was made.
[[nodiscard]] MeasuredCells in_order(MeasuredCells cells);

struct MeshView {
  std::span<const Point2> xy;
  std::span<const double> z1, z2;
  std::span<const std::array<std::int32_t, 3>> triangles;
};
[[nodiscard]] inline MeshView view_of(const MeasuredCells& m) { return {m.xy, m.z1, m.z2, m.triangles}; }

/// Pixel (column, row) is [x + column · step, x + (column + 1) · step] × [y + row · step, …]: rows go up.
struct PixelGrid {
  double x = 0, y = 0, step = 1;
  std::size_t columns = 0, rows = 0;
};
/// By pixel, row by row: the area of the cells in it, and over it the integrals of the heights and of their difference.
struct PixelSums {
  Array<double> area, z1, z2, d;
};
/// Adds cells up over the pixels of a grid, as integers: the same bits in whatever order they come, and in whatever
/// parts. Cells are cut at the sides of pixels and integrated in closed form, so that the sum of `d` over all pixels is
/// the net volume, and that of `area` the area, up to rounding, whatever the grid. Cells beyond the grid are left out.
/// Memory: 64 bytes a pixel. Cost: O(cells + pixels they touch). Oracle: tests/compare/measured_cells_test.cpp,
/// tests/python/results_test.py.
class PixelAdder {
 public:
  /// `height`: no |z1|, |z2| or |z2 − z1| exceeds it. Sums are off by 2^−100 of what a pixel can hold, for each cell.
  PixelAdder(const PixelGrid& grid, double height);
  /// A triangle, counter-clockwise: the same bits if it begins with the same corner. InputError where a height is no
  /// finite number.
  void add(const std::array<Corner, 3>& triangle);
  [[nodiscard]] PixelSums sums() const;

 private:
  __extension__ using Int128 = __int128;
  struct Pixel {
    Int128 area = 0, z1 = 0, z2 = 0, d = 0;
  };
  void add(const Corner& a, const Corner& b, const Corner& c, Pixel& pixel) const;

  PixelGrid grid_;
  double per_step_, per_area_, per_volume_;  // the last two: steps of the integers in a unit: powers of two
  std::vector<Pixel> pixels_;
};

/// The sums of a mesh.
[[nodiscard]] PixelSums sum_over_pixels(const MeshView& mesh, const PixelGrid& grid, const Context& context);

/// Both heights at places; NaN where no cell is. On a side that cells share, those of the first one. Exact in which
/// cell holds a place. Cost: O(cells + places).
struct HeightsAt {
  Array<double> z1, z2;
};
[[nodiscard]] HeightsAt heights_at(const MeshView& mesh, std::span<const Point2> places, const Context& context);

/// The section along a chain of straight pieces: its corners where it enters and leaves cells, between which both
/// heights are linear. `s` is the way along the chain. A row of NaN heights stands where it leaves the cells.
struct Section {
  std::vector<double> s, x, y, z1, z2;
};
[[nodiscard]] Section section_along(const MeshView& mesh, std::span<const Point2> chain, const Context& context);

}  // namespace isopach
