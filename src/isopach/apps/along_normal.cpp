#include "isopach/apps/along_normal.hpp"

#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/match/surface.hpp"
#include "isopach/overlay/common.hpp"

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

Array<double> cosines_of(const HeightField& field, const Triangulation& t, const Array<unsigned char>& kept) {
  const MatchSurface s = make_surface(field.xy, field.z, t, kept);
  const Array<double> slope = steepness(s);
  const Array<SlopeNoise> noise = slope_noise(s);
  const double sigma = roughness(s);
  Array<double> cosine(field.xy.size());
  for_each_index(cosine.size(), [&](std::size_t i) {
    const double square = slope[i] * slope[i] - sigma * sigma * (noise[i].xx + noise[i].yy);
    cosine[i] = square > 0 && std::isfinite(square) ? 1 / std::sqrt(1 + square) : 1;
  });
  return cosine;
}

}  // namespace

NormalCells::NormalCells(const Comparison& c, const ScanMeshes& m) : c_(c) {
  Array<double> cosine_a, cosine_b;
  both([&] { cosine_a = cosines_of(m.a, m.t1, single(m.kept_1, m.folded_1)); },
       [&] { cosine_b = cosines_of(m.b, m.t2, single(m.kept_2, m.folded_2)); });
  const UnitedNodes nodes = unite(m.a.xy, m.b.xy, c.frame.curve);
  zero_.assign(nodes.xy.size(), 0.0);
  d_.resize(nodes.xy.size());
  for_each_index(d_.size(), [&](std::size_t i) {
    const Index in_a = nodes.of_1[i], in_b = nodes.of_2[i];
    d_[i] = c.cells.d(static_cast<Index>(i)) * (in_a != no_index ? cosine_a[in_a] : cosine_b[in_b]);
  });
}

}  // namespace isopach
