#include "isopach/measure/uncertainty/noise_floor.hpp"

#include <algorithm>
#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/base/random.hpp"
#include "isopach/geom/coordinate_hash.hpp"
#include "isopach/measure/source.hpp"
#include "isopach/measure/uncertainty/shrinkage.hpp"
#include "isopach/measure/volume/totals.hpp"
#include "isopach/overlay/interpolate.hpp"
#include "isopach/overlay/stencils.hpp"

namespace isopach {

namespace {

constexpr std::uint64_t seed = 0x6e6f697365;  // fixed: the floor is a function of the two scans
constexpr std::size_t reach = 12;             // nodes to either side on the curve whose residuals are alike
constexpr std::size_t stretch = 64;           // nodes over which the chords are freed of noise
constexpr std::size_t enough_draws = 200000;  // numbers in all draws: the floor is a mean over them

// One number per node that depends on its coordinates alone.
std::uint64_t name_of(const Point2& p, double z) { return hash_of(z, hash_of(p)); }

// What one scan tells of itself.
struct Relief {
  LocalFits fits;
  Array<double> variance;  // of the noise at each node
};

Relief relief_of(const OverlayMesh& m, const Context& context) {
  const std::size_t n = m.xy.size();
  Array<double> unit(n);
  const RandomStream normal(seed, 0);
  for_each_index(n, [&](std::size_t i) { unit[i] = normal.normal(name_of(m.xy[i], m.z[i])); });
  Relief r{local_fits(m.t, m.xy, m.z, unit, context), Array<double>(n)};
  for_each_index(n, [&](std::size_t i) {
    const std::size_t begin = i - std::min(i, reach), end = std::min(n, i + reach + 1);
    double sum = 0;
    for (std::size_t k = begin; k < end; ++k) sum += r.fits.residual[k] * r.fits.residual[k];
    r.variance[i] = sum / static_cast<double>(end - begin);
  });
  return r;
}

Array<double> draw(const Relief& r, const OverlayMesh& m, std::uint64_t number) {
  const std::size_t n = m.xy.size();
  const RandomStream stream(seed, 1 + number);
  Array<double> noise(n);
  for_each_index(n, [&](std::size_t i) {
    const std::size_t begin = i - std::min(i, reach), end = std::min(n, i + reach + 1);
    const std::uint64_t bits = stream.bits(name_of(m.xy[i], m.z[i]));
    const double residual = r.fits.residual[begin + (bits >> 8) % (end - begin)];
    noise[i] = (bits & 1) != 0 ? residual : -residual;
  });
  return noise;
}

bool lies_in(const Location& at) { return at.kind != Location::Kind::outside && at.kind != Location::Kind::none; }

// f̂ − f at the points of `other`, which lie in the surface that `fits` are of.
Array<double> chords(const Relief& r, const OverlayMesh& m, const OverlayMesh& other, const Context& context) {
  const std::size_t n = other.xy.size();
  const Array<Stencil> stencil = stencils(other.in_other, other.xy, m.t, m.xy, context);
  Array<double> chord(n);
  for_blocks(n, stretch, [&](std::size_t begin, std::size_t end) {
    double all = 0, of_noise = 0;
    for (std::size_t i = begin; i < end; ++i) {
      double e = 0, echo = 0;
      if (lies_in(other.in_other[i])) {
        for (std::size_t k = 0; k < 3; ++k) {
          const Index node = stencil[i].node[k];
          const double weight = stencil[i].weight[k];
          const double dx = other.xy[i].x - m.xy[node].x, dy = other.xy[i].y - m.xy[node].y;
          e -= weight * LocalFits::value(r.fits.shape[node], dx, dy);
          echo -= weight * LocalFits::value(r.fits.echo[node], dx, dy);
        }
        of_noise += stencil[i].apply(r.variance) * echo * echo;
      }
      chord[i] = e;
      all += e * e;
    }
    const double kept = all > of_noise ? std::sqrt(1 - of_noise / all) : 0;
    for (std::size_t i = begin; i < end; ++i) chord[i] *= kept;
  });
  return chord;
}

// At the nodes of `own`. sign +1: own is the second scan.
NullDifference null_at(const Relief& own, const OverlayMesh& mesh, const Relief& other, const OverlayMesh& other_mesh,
                       double sign, std::size_t draws, const Context& context) {
  NullDifference d;
  const std::size_t n = mesh.xy.size();
  const auto interpolated = [&](std::span<const double> z) {
    return interpolate(mesh.in_other, mesh.xy, other_mesh.t, other_mesh.xy, z, context);
  };
  d.chord = chords(other, other_mesh, mesh, context);
  for_each_index(n, [&](std::size_t i) { d.chord[i] *= -sign; });
  d.variance = interpolated(other.variance);
  for_each_index(n, [&](std::size_t i) { d.variance[i] += own.variance[i]; });
  for (std::size_t k = 0; k < draws; ++k) {
    const Array<double> mine = draw(own, mesh, k);
    Array<double> theirs = interpolated(draw(other, other_mesh, k));
    for_each_index(n, [&](std::size_t i) { theirs[i] = sign * (mine[i] - theirs[i]); });
    d.random.push_back(std::move(theirs));
  }
  return d;
}

// A third of the measured area round each node, as whole multiples of 2⁻⁵⁰ of the size of the domain's box: sums of
// those are exact, so that the order of the triangles, which depends on how T was made, does not matter.
Array<double> areas_of_nodes(const CellView& cells) {
  Box2 box;
  for (const Point2& p : cells.xy) box.add(p);
  int exponent = 0;
  if (!box.empty()) (void)std::frexp((box.max.x - box.min.x) * (box.max.y - box.min.y), &exponent);
  const double quantum = std::ldexp(1.0, exponent - 50);
  Array<double> area(cells.xy.size());
  for_each_index(area.size(), [&](std::size_t i) { area[i] = 0; });
  for_common(cells, [&](const CommonCell& c) {
    const double size = c.convex().area();  // one rounding for all ways to write a triangle
    for (std::size_t k = 0; k < 3; ++k)
      c.for_nodes(k, [&](Index node, double share) { area[node] += std::round(size * share / (3 * quantum)); });
  });
  return area;
}

struct Biases {
  FixedSum area, floor_above, floor_below, with_null, without;

  Biases() = default;
  explicit Biases(const SumScales& scales)
      : area(scales.area),
        floor_above(scales.volume),
        floor_below(scales.volume),
        with_null(scales.volume),
        without(scales.volume) {}

  void add(const Biases& b) {
    area.add(b.area), floor_above.add(b.floor_above), floor_below.add(b.floor_below);
    with_null.add(b.with_null), without.add(b.without);
  }
};

double largest(std::span<const double> values) {
  double most = 0;
  for (const double v : values) most = std::max(most, std::fabs(v));  // what is no number is not larger
  return most;
}

// Of the differences below: what the model, the chords and the noise make together.
SumBounds bounds_of(const CellView& cells, const NullDifference& null, std::span<const double> model) {
  double random = 0;
  for (const Array<double>& draw : null.random) random = std::max(random, largest(draw));
  return {isopach::bounds_of(cells).area, largest(model) + largest(null.chord) + random};
}

Biases biases_of(const CellView& cells, const NullDifference& null, std::span<const double> model) {
  const double share = 1 / static_cast<double>(null.random.size());
  const SumScales scales(bounds_of(cells, null, model));
  return reduce_blocks<Biases>(
      items_of(cells), default_block,
      [&](std::size_t begin, std::size_t end) {
        Biases b(scales);
        for_common(cells, begin, end, [&](const CommonCell& cell, std::size_t) {
          const double area = cell.cell().area;
          b.area.add(area);
          const auto of_model = cell.at_corners(model), of_chord = cell.at_corners(null.chord);
          const Parts alone = split_volume({area, of_model});
          b.without.add(alone.above + alone.below);
          for (const Array<double>& random : null.random) {
            const auto of_random = cell.at_corners(random);
            Cell floor{area, {}}, with{area, {}};
            for (std::size_t k = 0; k < 3; ++k) {
              floor.d[k] = of_chord[k] + of_random[k];
              with.d[k] = of_model[k] + floor.d[k];
            }
            const Parts f = split_volume(floor), w = split_volume(with);
            b.floor_above.add(share * f.above);
            b.floor_below.add(share * f.below);
            b.with_null.add(share * (w.above + w.below));
          }
        });
        return b;
      },
      [](Biases& total, const Biases& part) { total.add(part); });
}

}  // namespace

NullDifferences null_differences(const OverlayMesh& m1, const OverlayMesh& m2, const Context& context) {
  Relief r1, r2;
  both([&] { r1 = relief_of(m1, context); }, [&] { r2 = relief_of(m2, context); });
  const std::size_t draws = std::clamp<std::size_t>(enough_draws / (m1.xy.size() + m2.xy.size()), 1, 16);
  NullDifferences d;
  both([&] { d.at_1 = null_at(r1, m1, r2, m2, -1, draws, context); },
       [&] { d.at_2 = null_at(r2, m2, r1, m1, +1, draws, context); });
  return d;
}

NullDifference unite(const NullDifferences& d, const UnitedNodes& nodes) {
  const auto united = [&](const Array<double>& at_1, const Array<double>& at_2) {
    Array<double> value(nodes.xy.size());
    for_each_index(value.size(), [&](std::size_t i) {
      value[i] = nodes.of_1[i] != no_index ? at_1[nodes.of_1[i]] : at_2[nodes.of_2[i]];
    });
    return value;
  };
  NullDifference u{united(d.at_1.chord, d.at_2.chord), united(d.at_1.variance, d.at_2.variance), {}};
  for (std::size_t k = 0; k < d.at_1.random.size(); ++k) u.random.push_back(united(d.at_1.random[k], d.at_2.random[k]));
  return u;
}

NoiseFloor noise_floor(const CellView& cells, const NullDifference& null, const Volume& measured,
                       const Context& context) {
  Array<double> without_chords(cells.xy.size());
  for_each_index(without_chords.size(),
                 [&](std::size_t i) { without_chords[i] = cells.d(static_cast<Index>(i)) - null.chord[i]; });
  const Array<double> model =
      shrink(without_chords, areas_of_nodes(cells), null.variance, null.random.front(), context);
  const Biases b = biases_of(cells, null, model);
  NoiseFloor f;
  const double area = b.area.value();
  if (!(area > 0)) return f;
  f.above = b.floor_above.value();
  f.below = b.floor_below.value();
  f.rho = total(b.floor_above, b.floor_below) / area;
  const double bias = difference(b.with_null, b.without);
  f.debiased.net = measured.net;
  f.debiased.absolute = std::max(std::fabs(measured.net), measured.absolute - bias);
  f.debiased.above = (f.debiased.absolute + measured.net) / 2;
  f.debiased.below = (f.debiased.absolute - measured.net) / 2;
  f.debiased_rho = f.debiased.absolute / area;
  return f;
}

}  // namespace isopach
