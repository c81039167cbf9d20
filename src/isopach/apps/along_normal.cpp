#include "isopach/apps/along_normal.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

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

Cosines cosines(const ScanMeshes& m) {
  Cosines c;
  both([&] { c.a = cosines_of(m.a, m.t1, single(m.kept_1, m.folded_1)); },
       [&] { c.b = cosines_of(m.b, m.t2, single(m.kept_2, m.folded_2)); });
  return c;
}

NormalCells::NormalCells(const Comparison& c, const ScanMeshes& meshes, const Cosines& cosine) : c_(c) {
  const UnitedNodes nodes = unite(meshes.a.xy, meshes.b.xy, c.frame.curve);
  zero_.assign(nodes.xy.size(), 0.0);
  d_.resize(nodes.xy.size());
  for_each_index(d_.size(), [&](std::size_t i) {
    const Index in_a = nodes.of_1[i], in_b = nodes.of_2[i];
    d_[i] = c.cells.d(static_cast<Index>(i)) * (in_a != no_index ? cosine.a[in_a] : cosine.b[in_b]);
  });
}

Array<double> along_normal(std::span<const double> dz_signed, std::span<const Index> node_of_point,
                           std::span<const double> cosine) {
  Array<double> d(dz_signed.size());
  for_each_index(d.size(), [&](std::size_t i) {
    const Index node = node_of_point[i];
    d[i] = node == no_index ? std::numeric_limits<double>::quiet_NaN() : dz_signed[i] * cosine[node];
  });
  return d;
}

}  // namespace isopach
