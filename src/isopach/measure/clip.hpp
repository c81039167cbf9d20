// clip: the domain cut to regions (polygons, masks). Cells that lie in it as a whole stay as they are, those it holds
// a part of are replaced by pieces: triangles on which both surfaces are linear, so that every measure stays exact.
#pragma once
#include <array>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/measure/cells.hpp"
#include "isopach/overlay/regions.hpp"

namespace isopach {

/// What of the plane is measured: inside the union of each set that is kept, outside of all that are taken away.
class Clip {
 public:
  void keep(Regions regions) { layers_.push_back({true, std::move(regions)}); }
  void take_away(Regions regions) { layers_.push_back({false, std::move(regions)}); }
  [[nodiscard]] bool is_everything() const { return layers_.empty(); }

  struct Scratch {
    Regions::Scratch regions;
    std::vector<ConvexCell> pieces, inside, outside;
  };
  /// `some`: what is left of the cell is in scratch.pieces, until it is used again.
  [[nodiscard]] Regions::Answer split(const ConvexCell& cell, Scratch& scratch) const;

  /// f(piece) for what is left of a cell, the cell itself if that is all of it.
  template <class F>
  void for_pieces(const ConvexCell& cell, Scratch& scratch, F&& f) const {
    const Regions::Answer answer = split(cell, scratch);
    if (answer == Regions::Answer::all) f(cell);
    if (answer != Regions::Answer::some) return;
    for (const ConvexCell& piece : scratch.pieces) f(piece);
  }

 private:
  struct Layer {
    bool keeps;
    Regions regions;
  };
  std::vector<Layer> layers_;
};

[[nodiscard]] ConvexCell convex(const CellView& cells, std::size_t triangle);
[[nodiscard]] ConvexCell convex(const CellPiece& piece);
[[nodiscard]] ConvexCell convex(const OverlayCell& cell);

/// Shares of the three nodes of a piece's triangle in the height at its corner k: barycentric.
[[nodiscard]] std::array<double, 3> shares_of_nodes(const CellView& cells, const CellPiece& piece, std::size_t k);
/// Values given at the nodes of T, at the corners of a piece.
[[nodiscard]] std::array<double, 3> at_corners(const CellView& cells, const CellPiece& piece,
                                               std::span<const double> of_node);

/// Cuts the cells whose flag is set: those not left whole lose it, and their pieces are returned, in the order of the
/// cells. Cost O(cells), little more than one look at each where regions are large against cells. Oracle:
/// tests/measure/clip_test.cpp.
[[nodiscard]] std::vector<CellPiece> clip_cells(const CellView& cells, std::span<unsigned char> in_domain,
                                                const Clip& clip, const Context& context);

/// The cells of the exact overlay, clipped as they are asked for.
struct ClippedOverlay {
  const Overlay& overlay;
  const Clip& clip;
};
[[nodiscard]] inline std::size_t items_of(const ClippedOverlay& cells) { return cells.overlay.items(); }

/// f(convex cell) for what is left of the cells of a block of items.
template <class F>
void for_convex(const ClippedOverlay& cells, std::size_t begin, std::size_t end, F&& f) {
  Overlay::Scratch overlay_scratch;
  Clip::Scratch scratch;
  for (std::size_t i = begin; i < end; ++i)
    for (const OverlayCell& c : cells.overlay.cells(i, overlay_scratch)) cells.clip.for_pieces(convex(c), scratch, f);
}
template <class F>
void for_convex(const CellView& cells, std::size_t begin, std::size_t end, F&& f) {
  const std::size_t whole = cells.t.real;
  for (std::size_t i = begin; i < std::min(end, whole); ++i)
    if (cells.in_domain[i] != 0) f(convex(cells, i));
  for (std::size_t i = std::max(begin, whole); i < end; ++i) f(convex(cells.pieces[i - whole]));
}

template <class F>
void for_cells(const ClippedOverlay& cells, std::size_t begin, std::size_t end, F&& f) {
  for_convex(cells, begin, end, [&](const ConvexCell& piece) {
    for_triangles(piece, [&](double area, const Corner& a, const Corner& b, const Corner& c) {
      f(Cell{area, {a.d(), b.d(), c.d()}});
    });
  });
}

/// f(overlay cell) for what is left of one, in triangles if it is cut.
template <class F>
void for_clipped(const OverlayCell& cell, const Clip& clip, Clip::Scratch& scratch, F&& f) {
  const Regions::Answer answer = clip.split(convex(cell), scratch);
  if (answer == Regions::Answer::all) f(cell);
  if (answer != Regions::Answer::some) return;
  for (const ConvexCell& piece : scratch.pieces)
    for_triangles(piece, [&](double, const Corner& a, const Corner& b, const Corner& c) {
      OverlayCell part = cell;
      part.corners = 3;
      part.sides = 0;
      const std::array<Corner, 3> corners{a, b, c};
      for (std::size_t k = 0; k < 3; ++k) {
        part.x[k] = corners[k].x - cell.origin.x, part.y[k] = corners[k].y - cell.origin.y;
        part.z1[k] = corners[k].z1, part.z2[k] = corners[k].z2;
      }
      f(part);
    });
}

/// As of an Overlay.
[[nodiscard]] Measures measure(const ClippedOverlay& overlay, const Context& context,
                               std::span<const double> percentiles = {});
[[nodiscard]] Measures sum_up(const ClippedOverlay& overlay, const Context& context);

/// All cells as one mesh; each piece has corners of its own.
[[nodiscard]] OverlaySurface surface_of(const ClippedOverlay& cells, const Context& context);

/// Areas of the real triangles of a mesh inside the clip.
struct ClippedAreas {
  double all = 0, flagged = 0;  ///< of all, and of those whose flag is set (all, if there are no flags)
  double within = 0;            ///< of all, inside `within` too
};
[[nodiscard]] ClippedAreas clipped_areas(const Triangulation& t, std::span<const Point2> xy,
                                         std::span<const unsigned char> flags, const Clip& clip, const Regions* within,
                                         const Context& context);

}  // namespace isopach
