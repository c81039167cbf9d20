#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "isopach/base/error.hpp"
#include "isopach/base/median.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/measure/measures.hpp"
#include "isopach/measure/volume/distribution.hpp"
#include "isopach/measure/volume/steps.hpp"

namespace isopach {

namespace {

constexpr std::size_t block = 1 << 14;

// One corner of value c > 0, the others at −a ≤ −b < 0: the part above is a pyramid over the corner, the part below the
// rest, both written as sums of positive terms.
Parts corner_above(double area, double c, double a, double b) {
  constexpr double least_cubed = 1e-90, least_product = 1e-180;
  if (c < least_cubed || (c + a) * (c + b) < least_product) {  // the same by shares of sides: products would be lost
    const double first = a / (c + a), second = b / (c + b);
    return {area / 3 * c * (c / (c + a)) * (c / (c + b)), area / 3 * (first * (a + b) + c / (c + a) * second * b)};
  }
  const double scale = area / (3 * (c + a) * (c + b));
  return {scale * c * c * c, scale * (c * (a * a + a * b + b * b) + a * b * (a + b))};
}

// All but the distribution.
Measures measures_of(const Totals& t) {
  Measures m;
  m.area = t.of.area.value();
  if (!(m.area > 0)) return m;
  m.volume = t.of.volume();
  m.rho = m.volume.absolute / m.area;
  DifferenceStatistics& d = m.difference;
  d.mean = m.volume.net / m.area;
  const double mean_square = t.squares.value() / m.area;
  d.rms = std::sqrt(mean_square);
  d.std = std::sqrt(std::max(0.0, mean_square - d.mean * d.mean));
  d.max_above = t.max_above;
  d.max_below = t.max_below;
  return m;
}

template <class Source>
Measures sums_over(const Source& cells, const Context& context) {
  context.check();
  const SumScales scales(bounds_of(cells));
  return measures_of(reduce_blocks<Totals>(
      items_of(cells), block,
      [&](std::size_t begin, std::size_t end) {
        Totals part(scales);
        for_cells_in_steps(cells, begin, end, context, [&](const Cell& cell) { part.add(sorted(cell)); });
        return part;
      },
      [](Totals& total, const Totals& part) { total.add(part); }));
}

template <class Source>
Measures measure_all(const Source& cells, const Context& context, std::span<const double> percentiles) {
  check_percentiles(percentiles);
  constexpr std::size_t bins = 101;
  std::vector<Quantile> wanted{{0.5, false, 0}};
  for (const int level : percentile_levels) wanted.push_back({level / 100.0, true, 0});
  for (const double level : percentiles) wanted.push_back({level / 100, true, 0});
  wanted.push_back({0.5, true, 0, 0});  // about the median
  Described found = describe(cells, wanted, bins, context);
  Measures m = measures_of(found.totals);
  if (!(m.area > 0)) return m;
  DifferenceStatistics& d = m.difference;
  d.median = found.quantiles[0];
  std::copy_n(found.quantiles.begin() + 1, percentile_levels.size(), d.abs_percentiles.begin());
  for (std::size_t i = 0; i < percentiles.size(); ++i)
    d.more_percentiles.push_back({percentiles[i], found.quantiles[1 + percentile_levels.size() + i]});
  d.nmad = mad_to_sigma * found.quantiles.back();
  d.histogram = std::move(found.histogram);
  return m;
}

}  // namespace

void check_percentiles(std::span<const double> levels) {
  for (const double level : levels)
    if (!(level > 0 && level < 100))
      throw UsageError(fmt::format("percentile {}: give one above 0 and below 100, e.g. 95", level));
}

Parts split_volume(const Cell& cell) {
  double d0 = cell.d[0], d1 = cell.d[1], d2 = cell.d[2];
  if (d0 > d1) std::swap(d0, d1);
  if (d1 > d2) std::swap(d1, d2);
  if (d0 > d1) std::swap(d0, d1);
  // d1 + (d0 + d2) and not from left to right: the same bits when all signs change and the order turns round.
  if (d0 >= 0) return {cell.area * (d1 + (d0 + d2)) / 3, 0};
  if (d2 <= 0) return {0, cell.area * -(d1 + (d0 + d2)) / 3};
  if (d1 == 0) return {cell.area * d2 * (d2 / (d2 - d0)) / 3, cell.area * -d0 * (-d0 / (d2 - d0)) / 3};
  if (d1 < 0) return corner_above(cell.area, d2, -d0, -d1);
  const Parts mirrored = corner_above(cell.area, -d0, d2, d1);
  return {mirrored.below, mirrored.above};
}

Measures measure(const CellView& cells, const Context& context, std::span<const double> percentiles) {
  return measure_all(cells, context, percentiles);
}
Measures measure(const OverlayCells& cells, const Context& context, std::span<const double> percentiles) {
  return measure_all(cells, context, percentiles);
}
Measures measure(const PartedCells& cells, const Context& context, std::span<const double> percentiles) {
  return measure_all(cells, context, percentiles);
}
Measures sum_up(const OverlayCells& cells, const Context& context) { return sums_over(cells, context); }

}  // namespace isopach
