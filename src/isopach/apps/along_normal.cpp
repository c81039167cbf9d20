#include "isopach/apps/along_normal.hpp"

#include <algorithm>
#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/match/surface/surface.hpp"
#include "isopach/overlay/common.hpp"
#include "isopach/overlay/localise.hpp"

namespace isopach {
namespace {

/// What is kept and not folded.
Array<unsigned char> single(const Array<unsigned char>& kept, const Array<unsigned char>& folded) {
  Array<unsigned char> flags = kept;
  if (folded.empty()) return flags;
  if (flags.empty()) flags.assign(folded.size(), 1);
  for_each_index(flags.size(), [&](std::size_t i) { flags[i] = flags[i] != 0 && folded[i] == 0 ? 1 : 0; });
  return flags;
}

/// By node the square of the slope around it, less what the noise of the heights adds to it; it may be below 0.
Array<double> squared_slopes(const Scan& scan) {
  const HeightField& field = scan.field;
  const MatchSurface s = make_surface(field.xy, field.z, scan.t, single(scan.kept, scan.folded));
  const Array<double> slope = steepness(s);
  const Array<SlopeNoise> noise = slope_noise(s);
  const double sigma = roughness(s);
  Array<double> square(field.xy.size());
  for_each_index(square.size(), [&](std::size_t i) {
    square[i] = slope[i] * slope[i] - sigma * sigma * (noise[i].xx + noise[i].yy);
    if (!std::isfinite(square[i])) square[i] = 0;
  });
  return square;
}

/// The same of the other scan at the places of one: the mean over the corners of the triangle there; 0 where it has
/// none.
Array<double> at_places(const Array<double>& square, const Triangulation& t, std::span<const Point2> xy,
                        std::span<const Point2> places, const Context& context) {
  const Locations where = localise_in_order(places, t, xy, context);
  Array<double> there(places.size());
  for_each_index(there.size(), [&](std::size_t i) {
    using Kind = Location::Kind;
    const Location at = where[i];
    there[i] = 0;
    if (at.kind == Kind::node) there[i] = square[at.id];
    if (at.kind != Kind::triangle && at.kind != Kind::edge) return;
    const Index triangle = at.kind == Kind::triangle ? at.id : triangle_of(at.id);
    if (t.is_ghost(triangle)) return;
    const auto& v = t.triangles[triangle].v;
    there[i] = (square[v[0]] + square[v[1]] + square[v[2]]) / 3;
  });
  return there;
}

}  // namespace

NormalCells::NormalCells(const Comparison& c, const Pair& scans, const Context& context) : c_(c) {
  std::array<Array<double>, 2> own, other;
  for_both([&](std::size_t k) { own[k] = squared_slopes(scans.scan[k]); });
  for_both([&](std::size_t k) {
    const Scan& there = scans.scan[1 - k];
    other[k] = at_places(own[1 - k], there.t, there.field.xy, scans.scan[k].field.xy, context);
  });
  const UnitedNodes nodes = unite(scans.scan[0].field.xy, scans.scan[1].field.xy, c.frame.curve);
  zero_.assign(nodes.xy.size(), 0.0);
  d_.resize(nodes.xy.size());
  Array<double> cosine(nodes.xy.size());
  for_each_index(d_.size(), [&](std::size_t i) {
    const Index in_a = nodes.of_1[i], in_b = nodes.of_2[i];
    const double square =
        in_a != no_index ? std::max(own[0][in_a], other[0][in_a]) : std::max(own[1][in_b], other[1][in_b]);
    cosine[i] = 1 / std::sqrt(1 + std::max(0.0, square));
    d_[i] = c.cells.d(static_cast<Index>(i)) * cosine[i];
  });
  const CellView cells = c.cells.view();
  for (const CellPiece& piece : c.cells.pieces) {
    const std::array<double, 3> at = of_piece(cells, piece).at_corners(cosine);
    CellPiece& turned = pieces_.emplace_back(piece);
    for (std::size_t k = 0; k < 3; ++k) turned.at[k].z1 = 0, turned.at[k].z2 = piece.at[k].d() * at[k];
  }
}

}  // namespace isopach
