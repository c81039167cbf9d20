#include "isopach/measure/uncertainty/detection.hpp"

#include <cmath>
#include <numbers>

#include "isopach/base/parallel.hpp"
#include "isopach/measure/volume/totals.hpp"

namespace isopach {

namespace {

constexpr std::size_t block = 1 << 13;

void add(VolumeSums& sums, const Detected& d) { sums.area.add(d.area), sums.add_volume({d.above, d.below}); }

// `for_block(begin, end, sums)` on fixed blocks of n items.
template <class F>
Detected over_blocks(std::size_t n, const SumBounds& bounds, F&& for_block) {
  const SumScales scales(bounds);
  const VolumeSums total = reduce_blocks<VolumeSums>(
      n, block,
      [&](std::size_t begin, std::size_t end) {
        VolumeSums part(scales);
        for_block(begin, end, part);
        return part;
      },
      [](VolumeSums& left, const VolumeSums& right) { left.add(right); });
  return {total.above.value(), total.below.value(), total.area.value()};
}

template <class Source>
Detected detect_constant(const Source& cells, double lod, const Context& context) {
  context.check();
  return over_blocks(items_of(cells), bounds_of(cells), [&](std::size_t begin, std::size_t end, VolumeSums& part) {
    for_cells(cells, begin, end, [&](const Cell& cell) { add(part, detect(cell, {lod, lod, lod})); });
  });
}

// The cells of one item after the other within the domain; which there are and in which order depends on the places of
// the nodes alone.
struct ItemCells {
  std::vector<OverlayCell> parts;
  void take(const OverlayCells& cells, std::size_t item) {
    parts.clear();
    for_overlay(cells, item, item + 1, [&](const OverlayCell& c, std::size_t) { parts.push_back(c); });
  }
};

double sum_of_squares(double x, double y) { return x * x + y * y; }

// The corner triangle that the zero line cuts off at the corner c, whose sign the other two do not share.
std::array<double, 3> corner_shares(const std::array<double, 3>& s, std::size_t c) {
  const std::size_t a = (c + 1) % 3, b = (c + 2) % 3;
  const double to_a = s[c] / (s[c] - s[a]), to_b = s[c] / (s[c] - s[b]);  // in (0, 1]: how far along either side
  const double share = to_a * to_b;
  std::array<double, 3> shares{};
  shares[a] = share * to_a / 3;
  shares[b] = share * to_b / 3;
  shares[c] = share * ((1 - to_a) + (1 - to_b) + 1) / 3;
  return shares;
}

}  // namespace

double normal_deviations(double confidence) {
  double low = 0, high = 9;  // beyond 8.3 the probability of more is below the spacing of doubles next to 1
  for (;;) {
    const double middle = low + (high - low) / 2;
    if (middle <= low || middle >= high) return high;
    (std::erfc(middle / std::numbers::sqrt2) > 1 - confidence ? low : high) = middle;
  }
}

std::array<double, 3> positive_shares(const std::array<double, 3>& s) {
  std::size_t positive = 0, last_positive = 0, last_other = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    positive += s[i] > 0 ? 1 : 0;
    (s[i] > 0 ? last_positive : last_other) = i;
  }
  if (positive == 0) return {0, 0, 0};
  if (positive == 3) return {1. / 3, 1. / 3, 1. / 3};
  if (positive == 1) return corner_shares(s, last_positive);
  if (s[last_other] == 0) return {1. / 3, 1. / 3, 1. / 3};
  std::array<double, 3> shares = corner_shares(s, last_other);
  for (double& share : shares) share = 1. / 3 - share;
  return shares;
}

Detected detect(const Cell& cell, const std::array<double, 3>& lod) {
  const auto& d = cell.d;
  Detected result;
  for (const int sign : {1, -1}) {
    const auto shares = positive_shares({sign * d[0] - lod[0], sign * d[1] - lod[1], sign * d[2] - lod[2]});
    (sign > 0 ? result.above : result.below) =
        cell.area * sign * (shares[0] * d[0] + shares[1] * d[1] + shares[2] * d[2]);
    result.area += cell.area * (shares[0] + shares[1] + shares[2]);
  }
  return result;
}

Detected detect(const CellView& cells, std::span<const double> lod, const Context& context) {
  context.check();
  return over_blocks(items_of(cells), bounds_of(cells), [&](std::size_t begin, std::size_t end, VolumeSums& part) {
    for_common(cells, begin, end,
               [&](const CommonCell& c, std::size_t) { add(part, detect(c.cell(), c.at_corners(lod))); });
  });
}

Detected detect(const CellView& cells, double lod, const Context& context) {
  return detect_constant(cells, lod, context);
}
Detected detect(const OverlayCells& cells, double lod, const Context& context) {
  return detect_constant(cells, lod, context);
}
Detected detect(const PartedCells& cells, double lod, const Context& context) {
  return detect_constant(cells, lod, context);
}

Detected detect(const OverlayCells& cells, const OverlayLevel& level, const Context& context) {
  context.check();
  return over_blocks(items_of(cells), bounds_of(cells), [&](std::size_t begin, std::size_t end, VolumeSums& part) {
    ItemCells heights;
    std::vector<ItemCells> deviations(level.deviations.size());
    for (std::size_t i = begin; i < end; ++i) {
      heights.take(cells, i);
      for (std::size_t k = 0; k < deviations.size(); ++k) deviations[k].take({level.deviations[k], cells.domain}, i);
      for (std::size_t cell = 0; cell < heights.parts.size(); ++cell) {
        const OverlayCell& c = heights.parts[cell];
        const auto lod = [&](unsigned corner) {
          double square = level.rest * level.rest;
          for (const ItemCells& d : deviations)
            square += sum_of_squares(d.parts[cell].z1[corner], d.parts[cell].z2[corner]);
          return level.k * std::sqrt(square);
        };
        for_triangles(c, [&](unsigned a, unsigned b, double area) {
          add(part, detect(Cell{area, {c.d(0), c.d(a), c.d(b)}}, {lod(0), lod(a), lod(b)}));
        });
      }
    }
  });
}

Array<double> level_at_vertices(const OverlayLevel& level, const Domain& domain, const Context& context) {
  Array<double> lod;
  for (const Overlay& overlay : level.deviations) {
    const OverlaySurface s = surface_of({overlay, domain}, context);
    if (lod.empty()) lod.assign(s.xy.size(), level.rest * level.rest);
    for_each_index(lod.size(), [&](std::size_t i) { lod[i] += sum_of_squares(s.z1[i], s.z2[i]); });
  }
  for_each_index(lod.size(), [&](std::size_t i) { lod[i] = level.k * std::sqrt(lod[i]); });
  return lod;
}

}  // namespace isopach
