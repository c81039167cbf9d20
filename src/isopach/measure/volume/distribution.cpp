#include "isopach/measure/volume/distribution.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>

#include "isopach/base/parallel.hpp"
#include "isopach/base/random.hpp"
#include "isopach/measure/volume/cumulative_area.hpp"
#include "isopach/measure/volume/steps.hpp"

namespace isopach {

namespace {

constexpr std::size_t block = 1 << 14;

// One of the cells of an item, and the area that it stands for. `draw` is in [0, 1).
std::pair<Cell, double> one_by_chance(std::span<const Cell> cells, double draw) {
  double area = 0;
  for (const Cell& cell : cells) area += cell.area;
  double left = draw * area;
  std::size_t k = 0;
  while (k + 1 < cells.size() && (left -= cells[k].area) >= 0) ++k;
  return {cells[k], area};
}

// Of what can be told without making cells.
double quick_largest(const CellView& cells, std::size_t item) {
  double largest = 0;
  const auto look_at = [&](double d) { largest = std::max(largest, std::fabs(d)); };
  if (item < cells.t.real)
    for (const Index v : cells.t.triangles[item].v) look_at(cells.d(v));
  else
    for (const Corner& c : cells.pieces[item - cells.t.real].at) look_at(c.d());
  return largest;
}
double quick_largest(const OverlayCells&, std::size_t) { return 0; }
double quick_largest(const CellPart& part, std::size_t item) {
  double largest = 0;
  for (const Index v : part.triangles[item]) largest = std::max(largest, std::fabs(part.d(v)));
  return largest;
}

// How many items there are, of which a source may hand out a part: the size of a sample goes by all.
template <class Source>
std::size_t population_of(const Source& cells) {
  return items_of(cells);
}
std::size_t population_of(const PartedCells& cells) { return cells.population(); }

// Which items are in a sample, by their names: about `share` of them, all if that is 1.
class Choice {
 public:
  explicit Choice(double share) : below_(static_cast<std::uint64_t>(std::ceil(share * 0x1p53))) {}
  [[nodiscard]] bool holds(std::uint64_t name) const { return RandomStream(0, 0).bits(name) >> 11 < below_; }

 private:
  std::uint64_t below_;
};

// Points strewn over a sample of the items: an estimate of the distribution, to know where to look for a quantile.
// Which items are in it, and where on them the points lie, follows from the items' names, so from coordinates alone.
class Estimate {
 public:
  template <class Source>
  Estimate(const Source& source, const Context& context) {
    const std::size_t n = items_of(source);
    const auto of_all = static_cast<double>(population_of(source));
    // Cells that a bracket cuts are kept: the more there are, the narrower it must be.
    const double enough = std::max(0x1p16, of_all / 32);
    complete_ = of_all <= enough;
    const Choice sample(complete_ ? 1 : enough / of_all);
    struct Part {
      Points points;
      double largest = 0;
    };
    Part all = reduce_blocks<Part>(
        n, block,
        [&](std::size_t begin, std::size_t end) {
          context.check();
          Part part;
          std::vector<Cell> cells;
          double largest = 0;  // in a register
          for_views(source, begin, end, [&](const auto& view, std::size_t from, std::size_t to) {
            for (std::size_t i = from; i < to; ++i) {
              if (!may_have_cells(view, i)) continue;
              const std::uint64_t name = name_of(view, i);
              if (!sample.holds(name)) {
                largest = std::max(largest, quick_largest(view, i));
                continue;
              }
              cells.clear();
              for_cells(view, i, i + 1, [&](const Cell& cell) { cells.push_back(cell); });
              for (const Cell& cell : cells)
                for (const double d : cell.d) part.largest = std::max(part.largest, std::fabs(d));
              if (!cells.empty()) part.points.push_back(point_on(cells, name));
            }
          });
          part.largest = std::max(part.largest, largest);
          return part;
        },
        [](Part& total, const Part& part) {
          total.points.insert(total.points.end(), part.points.begin(), part.points.end());
          total.largest = std::max(total.largest, part.largest);
        });
    points_ = std::move(all.points);
    largest_ = all.largest;
    std::sort(points_.begin(), points_.end());
    mirrored_ = leans_below();
    if (mirrored_) {
      for (auto& [d, area] : points_) d = -d;
      std::sort(points_.begin(), points_.end());
    }
    sizes_ = folded(0);
    double squares = 0;
    for (const auto& [d, area] : points_) area_ += area, squares += area * area;
    deviation_ = area_ > 0 ? std::sqrt(squares) / area_ : 1;
  }

  /// Whether all is told of −d: of the two ways to look at a pair of surfaces the one in which the sample reaches
  /// higher. Areas up to v round differently from both ends, so that both orders of the surfaces must look from the
  /// same one.
  [[nodiscard]] bool mirrored() const { return mirrored_; }
  /// The largest |d| of the cells looked at: of all cells of T, and of all of the overlay if `complete()`.
  [[nodiscard]] double largest() const { return largest_; }
  [[nodiscard]] bool complete() const { return complete_; }

  /// About the value that |d| exceeds on 1 − share of the area.
  [[nodiscard]] double absolute_quantile(double share) const {
    double sum = 0;
    for (const auto& [x, area] : sizes_)
      if ((sum += area) >= share * area_) return x;
    return largest_;
  }

  /// Where the quantile lies with all likelihood.
  [[nodiscard]] Interval bracket(const Quantile& q, double limit) const {
    constexpr double deviations = 3;
    const double slack = deviations * deviation_ * std::sqrt(q.share * (1 - q.share));
    const Points about_centre = q.absolute && q.centre != 0 ? folded(q.centre) : Points{};
    const Points& points = !q.absolute ? points_ : q.centre != 0 ? about_centre : sizes_;
    Interval result{q.absolute ? 0 : -limit, q.absolute ? limit + std::fabs(q.centre) : limit};
    double sum = 0;
    for (const auto& [x, area] : points) {
      sum += area;
      if (sum <= (q.share - slack) * area_) result.low = x;
      if (sum >= (q.share + slack) * area_) {
        result.high = x;
        break;
      }
    }
    return result;
  }

 private:
  using Points = std::vector<std::pair<double, double>>;  // value, area that it stands for; ascending

  [[nodiscard]] bool leans_below() const {  // points ascending
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const double above = points_[points_.size() - 1 - i].first, below = -points_[i].first;
      if (above != below) return above < below;
    }
    return false;
  }

  static std::pair<double, double> point_on(std::span<const Cell> cells, std::uint64_t name) {
    const auto [cell, area] = one_by_chance(cells, RandomStream(0, 1).uniform(name));
    double s = RandomStream(0, 2).uniform(name), t = RandomStream(0, 3).uniform(name);
    if (s + t > 1) s = 1 - s, t = 1 - t;
    return {cell.d[0] + s * (cell.d[1] - cell.d[0]) + t * (cell.d[2] - cell.d[0]), area};
  }

  [[nodiscard]] Points folded(double centre) const {
    Points below, above, all;
    for (Points* p : {&below, &above, &all}) p->reserve(points_.size());
    for (const auto& [d, area] : points_) (d < centre ? below : above).emplace_back(std::fabs(d - centre), area);
    std::merge(below.rbegin(), below.rend(), above.begin(), above.end(), std::back_inserter(all));
    return all;
  }

  Points points_, sizes_;  // of d, of |d|
  double area_ = 0, deviation_ = 1, largest_ = 0;
  bool complete_ = false, mirrored_ = false;
};

// A quantile on the way: its bracket, and that of its centre where this is a quantile itself.
struct Search {
  Quantile wanted;
  Interval bracket, centre;
  std::optional<double> found;

  // The values of d that the bracket speaks of, with room for rounding.
  void add_intervals(std::vector<Interval>& intervals) const {
    const auto add = [&](double low, double high) {
      const double room =
          std::max(8 * std::numeric_limits<double>::epsilon() * std::max(std::fabs(low), std::fabs(high)),
                   std::numeric_limits<double>::min());
      intervals.push_back({low - room, high + room});
    };
    if (wanted.absolute) {
      add(centre.low - bracket.high, centre.high - bracket.low);
      add(centre.low + bracket.low, centre.high + bracket.high);
    } else {
      add(bracket.low, bracket.high);
    }
  }

  [[nodiscard]] Growth at(const AreaUpTo& area, double v) const {
    if (!wanted.absolute) return area(v, [&](double d) { return d <= v; });
    const double c = wanted.centre;
    const Growth upper = area(c + v, [&](double d) { return d - c <= v; });
    const Growth lower = area(c - v, [&](double d) { return d - c < -v; });
    return {upper.area - lower.area, upper.density + lower.density};
  }

  // The v in the bracket where the area reaches the target: Newton's method inside a bracket that bisection keeps
  // closing. Nothing if it lies outside; the bracket then moves there.
  void solve(const AreaUpTo& area, double target, double limit) {
    double low = std::nextafter(bracket.low, -HUGE_VAL), high = bracket.high;
    const double least = wanted.absolute ? 0 : -limit,
                 most = wanted.absolute ? limit + std::fabs(wanted.centre) : limit;
    const double below = bracket.low > least ? at(area, low).area - target : -target;
    const double above = bracket.high < most ? at(area, high).area - target : 0;
    const double far = 8 * (high - low);
    if (below >= 0) {
      bracket = {std::max(least, low - far), low};
      return;
    }
    if (above < 0) {
      bracket = {high, std::min(most, high + far)};
      return;
    }
    const double rounding = 1e-15 * target;
    double v = low + (high - low) * (above > 0 ? below / (below - above) : 0.5);
    for (int i = 0; !found; ++i) {
      if (v <= low || v >= high) {
        found = high;
        return;
      }
      const Growth g = at(area, v);
      const double over = g.area - target;
      if (std::fabs(over) <= rounding && g.density > 0) {
        found = v;
        return;
      }
      (over >= 0 ? high : low) = v;
      const double middle = low + (high - low) / 2, aimed = v - over / g.density;
      // A step may leave the bracket, or crawl where the distribution jumps: then halve.
      v = i % 4 != 3 && aimed > low && aimed < high ? aimed : middle;
    }
  }
};

// What the pass over the cells looks for. Slot k holds the values of d between the edges k − 1 and k of the histogram.
// The intervals of quantiles that reach into it cut it into bins, one more than there are; into most slots none does.
class Plan {
 public:
  Plan(std::vector<Interval> of_quantiles, double half, std::size_t bins, const SumScales& for_sums, bool is_mirrored)
      : intervals(std::move(of_quantiles)),
        scales(for_sums),
        mirrored(is_mirrored),
        no_edges(-half, half, bins, for_sums.area),
        slots_(bins + 2) {
    for (const Interval& i : intervals) {
      for (std::size_t k = slot_of(i.high) + 1; k < slots_.size(); ++k) ++slots_[k].near.first;
      for (std::size_t k = slot_of(i.low); k < slots_.size(); ++k) ++slots_[k].near.last;
    }
    for (Slot& s : slots_) s.first_bin = std::exchange(bins_, bins_ + s.near.last - s.near.first + 1);
  }

  [[nodiscard]] std::size_t slot_of(double d) const { return no_edges.edges_below(d); }
  [[nodiscard]] std::size_t slots() const { return slots_.size(); }
  [[nodiscard]] std::size_t bins() const { return bins_; }
  /// Of cells whose least and largest value lie in these slots: the intervals that they may reach into.
  [[nodiscard]] Shares::Range near(std::size_t low, std::size_t high) const {
    return {slots_[low].near.first, slots_[high].near.last};
  }
  /// Of cells that lie in a slot and end before an interval.
  [[nodiscard]] std::size_t bin(std::size_t slot, std::size_t before) const {
    return slots_[slot].first_bin + (before - slots_[slot].near.first);
  }

  const std::vector<Interval> intervals;
  const SumScales scales;
  const bool mirrored;  // all is told of −d
  const EdgeSums no_edges;

 private:
  struct Slot {
    Shares::Range near{0, 0};
    std::size_t first_bin = 0;
  };
  std::vector<Slot> slots_;
  std::size_t bins_ = 0;
};

// All that a block of cells adds. The area of a cell is added once, to the sum that most of the others are made of.
struct Tally {
  const Plan& plan;
  Totals totals{plan.scales};
  EdgeSums edges = plan.no_edges;
  Shares shares{plan.intervals, plan.scales.area};
  std::vector<FixedSum> within = std::vector<FixedSum>(plan.bins(), FixedSum(plan.scales.area));  // cells in one slot

  void add(const Cell& unsorted) {
    Cell cell = sorted(unsorted);
    if (plan.mirrored) cell.d = {-cell.d[2], -cell.d[1], -cell.d[0]};
    totals.add_heights(cell);
    const std::size_t low = plan.slot_of(cell.d[0]), high = plan.slot_of(cell.d[2]);
    const std::size_t before = shares.add_inside(cell, plan.near(low, high));
    if (low == high) {
      within[plan.bin(low, before)].add(cell.area);
    } else {
      totals.of.area.add(cell.area);
      edges.add(cell);
      shares.add_before(before, cell.area);
    }
  }
  void close() {
    for (std::size_t slot = 0; slot < plan.slots(); ++slot) {
      const Shares::Range near = plan.near(slot, slot);
      for (std::size_t before = near.first; before <= near.last; ++before) {
        const FixedSum& area = within[plan.bin(slot, before)];
        totals.of.area.add(area);
        edges.add_between(slot, area);
        shares.add_before(before, area);
      }
    }
  }
};

// What one pass over all cells gives.
struct Pass {
  Totals totals;
  std::vector<double> area_up_to_edges;
  std::vector<Shares> shares;  // of each block
};

template <class Source>
Pass pass_over(const Source& cells, const Plan& plan, const Context& context) {
  struct Sums {
    Totals totals;
    EdgeSums edges;
  };
  Pass pass;
  pass.shares.assign((items_of(cells) + block - 1) / block, Shares(plan.intervals, plan.scales.area));
  const Sums sums = reduce_blocks<Sums>(
      items_of(cells), block,
      [&](std::size_t begin, std::size_t end) {
        Tally tally{plan};
        for_cells_in_steps(cells, begin, end, context, [&](const Cell& cell) { tally.add(cell); });
        tally.close();
        pass.shares[begin / block] = std::move(tally.shares);
        return Sums{tally.totals, std::move(tally.edges)};
      },
      [](Sums& total, const Sums& part) {
        total.totals.add(part.totals);
        total.edges.add(part.edges);
      });
  pass.totals = sums.totals;
  pass.area_up_to_edges = sums.edges.values();
  return pass;
}

std::vector<Search> searches_for(const std::vector<Quantile>& wanted, const Estimate& estimate, double limit) {
  std::vector<Search> searches;
  for (Quantile q : wanted) {
    Interval centre{q.centre, q.centre};
    if (q.about != Quantile::nothing) {
      centre = searches[q.about].bracket;
      q.centre = centre.low + (centre.high - centre.low) / 2;
    }
    searches.push_back({q, estimate.bracket(q, limit), centre, {}});
  }
  return searches;
}

// Empty if all are found.
std::vector<Interval> intervals_of(const std::vector<Search>& searches) {
  std::vector<Interval> intervals;
  for (const Search& s : searches)
    if (!s.found) s.add_intervals(intervals);
  return merged(std::move(intervals));
}

void solve(std::vector<Search>& searches, const AreaUpTo& area, double whole, double limit) {
  for (Search& s : searches) {
    if (s.found) continue;
    if (s.wanted.about != Quantile::nothing) {
      const Search& centre = searches[s.wanted.about];
      s.centre = centre.found ? Interval{*centre.found, *centre.found} : centre.bracket;
      s.wanted.centre = s.centre.low;
      if (!centre.found) continue;
    }
    s.solve(area, s.wanted.share * whole, limit);
  }
}

// The same of d where it was of −d.
void mirror(Totals& t) {
  std::swap(t.of.above, t.of.below);
  std::swap(t.max_above, t.max_below);
}
Quantile mirrored(Quantile q) {
  q.centre = -q.centre;
  if (!q.absolute) q.share = 1 - q.share;
  return q;
}

Histogram histogram_of(double half, std::vector<double> area_up_to_edges, double area) {
  const std::size_t bins = area_up_to_edges.size() - 1;
  const auto count = static_cast<double>(bins);
  area_up_to_edges.front() = 0;
  area_up_to_edges.back() = area;
  Histogram h;
  for (std::size_t k = 0; k <= bins; ++k) h.edges.push_back(half * (2.0 * static_cast<double>(k) - count) / count);
  for (std::size_t k = 0; k < bins; ++k)
    h.areas.push_back(std::max(0.0, area_up_to_edges[k + 1] - area_up_to_edges[k]));
  return h;
}

}  // namespace

double area_below(const Cell& cell, double v) {
  const auto [d0, d1, d2] = sorted(cell).d;
  if (v < d0) return 0;
  if (v >= d2) return cell.area;
  if (v < d1) return cell.area * ((v - d0) / (d1 - d0)) * ((v - d0) / (d2 - d0));
  return cell.area - cell.area * ((d2 - v) / (d2 - d0)) * ((d2 - v) / (d2 - d1));
}

template <class Source>
Described describe(const Source& cells, const std::vector<Quantile>& wanted, std::size_t bins, const Context& context) {
  context.check();
  SumBounds bounds = bounds_of(cells);
  const Estimate estimate(cells, context);
  if (estimate.complete() || !std::is_same_v<Source, OverlayCells>) bounds.difference = estimate.largest();
  const double limit = bounds.difference;
  const SumScales scales(bounds, times_its_area);
  // Wide enough for most of the area, not for the last outlier.
  double half = std::min(estimate.largest(), 1.5 * estimate.absolute_quantile(0.99));
  if (!(half > 0)) half = estimate.largest() > 0 ? estimate.largest() : (limit > 0 ? limit : 1);
  std::vector<Quantile> sought = wanted;
  if (estimate.mirrored()) std::transform(wanted.begin(), wanted.end(), sought.begin(), mirrored);
  std::vector<Search> searches = searches_for(sought, estimate, limit);
  const Plan plan(intervals_of(searches), half, bins, scales, estimate.mirrored());
  Pass pass = pass_over(cells, plan, context);
  Described result{pass.totals, {}, {}};
  const double area = pass.totals.of.area.value();
  if (!(area > 0)) return result;
  result.histogram = pass.totals.largest() > 0 ? histogram_of(half, std::move(pass.area_up_to_edges), area)
                                               : Histogram{{-1, 1}, {area}};
  solve(searches, AreaUpTo(plan.intervals, std::move(pass.shares), scales.area, area), area, limit);
  for (auto intervals = intervals_of(searches); !intervals.empty(); intervals = intervals_of(searches)) {
    context.check();
    const Plan again(std::move(intervals), half, bins, scales, estimate.mirrored());
    solve(searches, AreaUpTo(again.intervals, pass_over(cells, again, context).shares, scales.area, area), area, limit);
  }
  for (const Search& s : searches)
    result.quantiles.push_back(estimate.mirrored() && !s.wanted.absolute ? 0.0 - *s.found : *s.found);
  if (estimate.mirrored()) {
    mirror(result.totals);
    std::reverse(result.histogram.areas.begin(), result.histogram.areas.end());
  }
  return result;
}

template Described describe(const CellView&, const std::vector<Quantile>&, std::size_t, const Context&);
template Described describe(const OverlayCells&, const std::vector<Quantile>&, std::size_t, const Context&);
template Described describe(const PartedCells&, const std::vector<Quantile>&, std::size_t, const Context&);

}  // namespace isopach
