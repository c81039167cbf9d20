#include "isopach/measure/domain.hpp"

#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"

namespace isopach {

const Domain& Domain::everything() {
  static const Domain all;
  return all;
}

Regions::Answer Domain::split(const ConvexCell& cell, Scratch& s) const {
  bool whole = true;  // so far nothing was cut: s.pieces is not in use
  for (const Layer& layer : layers_) {
    if (whole) {
      s.inside.clear();
      s.outside.clear();
      const Regions::Answer answer = layer.regions.split(cell, s.regions, s.inside, s.outside);
      if (answer == (layer.keeps ? Regions::Answer::none : Regions::Answer::all)) return Regions::Answer::none;
      if (answer != Regions::Answer::some) continue;
      whole = false;
      std::swap(s.pieces, layer.keeps ? s.inside : s.outside);
      continue;
    }
    s.inside.clear();
    s.outside.clear();
    for (const ConvexCell& piece : s.pieces) {
      const Regions::Answer answer = layer.regions.split(piece, s.regions, s.inside, s.outside);
      if (answer == Regions::Answer::all) s.inside.push_back(piece);
      if (answer == Regions::Answer::none) s.outside.push_back(piece);
    }
    std::swap(s.pieces, layer.keeps ? s.inside : s.outside);
    if (s.pieces.empty()) return Regions::Answer::none;
  }
  if (whole) return Regions::Answer::all;
  return s.pieces.empty() ? Regions::Answer::none : Regions::Answer::some;
}

namespace {

struct AreaSums {
  Sum all, flagged, within;
};

double area_within(const ConvexCell& piece, const Regions& within, Domain::Scratch& s) {
  s.inside.clear();
  s.outside.clear();
  const Regions::Answer answer = within.split(piece, s.regions, s.inside, s.outside);
  if (answer == Regions::Answer::none) return 0;
  if (answer == Regions::Answer::all) return piece.area();
  double area = 0;
  for (const ConvexCell& c : s.inside) area += c.area();
  return area;
}

}  // namespace

AreasInside areas_inside(const Domain& domain, const Triangulation& t, std::span<const Point2> xy,
                         std::span<const unsigned char> flags, const Regions* within, const Context& context) {
  context.check();
  const AreaSums sums = reduce_blocks<AreaSums>(
      t.real, default_block,
      [&](std::size_t begin, std::size_t end) {
        AreaSums part;
        Domain::Scratch scratch, scratch_within;
        for (std::size_t i = begin; i < end; ++i) {
          ConvexCell cell;
          for (const Index v : t.triangles[i].v) cell.add({xy[v].x, xy[v].y, 0, 0});
          domain.for_pieces(cell, scratch, [&](const ConvexCell& piece) {
            const double area = piece.area();
            part.all.add(area);
            if (flags.empty() || flags[i] != 0) part.flagged.add(area);
            if (within != nullptr) part.within.add(area_within(piece, *within, scratch_within));
          });
        }
        return part;
      },
      [](AreaSums& total, const AreaSums& part) {
        total.all.add(part.all);
        total.flagged.add(part.flagged);
        total.within.add(part.within);
      });
  return {sums.all.value(), sums.flagged.value(), sums.within.value()};
}

}  // namespace isopach
