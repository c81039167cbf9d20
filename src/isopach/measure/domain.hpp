// Domain: what of the plane is measured, cut exactly along regions (polygons, masks). A cell that lies in it as a whole
// stays as it is; of one that it holds a part of convex pieces are left, on which both surfaces stay linear, so that
// every measure stays exact.
#pragma once
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/delaunay/triangulation.hpp"
#include "isopach/overlay/regions.hpp"

namespace isopach {

/// Inside the union of each set that is kept, outside of all that are taken away; everything without one.
class Domain {
 public:
  void keep(Regions regions) { layers_.push_back({true, std::move(regions)}); }
  void take_away(Regions regions) { layers_.push_back({false, std::move(regions)}); }
  [[nodiscard]] bool is_everything() const { return layers_.empty(); }
  [[nodiscard]] static const Domain& everything();

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

/// Areas of the real triangles of a mesh inside the domain.
struct AreasInside {
  double all = 0, flagged = 0;  ///< of all, and of those whose flag is set (all, if there are no flags)
  double within = 0;            ///< of all, inside `within` too
};
/// `within`: null for none. Cost O(triangles).
[[nodiscard]] AreasInside areas_inside(const Domain& domain, const Triangulation& t, std::span<const Point2> xy,
                                       std::span<const unsigned char> flags, const Regions* within,
                                       const Context& context);

}  // namespace isopach
