// Sums over cells that make the area where d ≤ v exact as a function of v: in a few intervals (AreaUpTo, for quantiles)
// and at even edges (EdgeSums, for histograms). Used by distribution.cpp alone; the formulas are in distribution.hpp.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "isopach/base/fixed_sum.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/measure/source.hpp"

namespace isopach {

// Area where the variable is ≤ v, and how fast it grows with v.
struct Growth {
  double area = 0, density = 0;
};
[[nodiscard]] inline Growth growth_of_d(const Cell& cell, double v) {  // values sorted, not all equal
  const auto [d0, d1, d2] = cell.d;
  if (v <= d0) return {};
  if (v >= d2) return {cell.area, 0};
  // Ratios first: the product of two tiny differences may be no number.
  if (v < d1) {
    const double ratio = cell.area * ((v - d0) / (d1 - d0));
    return {ratio * ((v - d0) / (d2 - d0)), 2 * ratio / (d2 - d0)};
  }
  const double ratio = cell.area * ((d2 - v) / (d2 - d1));
  return {cell.area - ratio * ((d2 - v) / (d2 - d0)), 2 * ratio / (d2 - d0)};
}

struct Interval {
  double low, high;
};

// Ascending and disjoint; those that overlap become one.
[[nodiscard]] inline std::vector<Interval> merged(std::vector<Interval> intervals) {
  std::sort(intervals.begin(), intervals.end(), [](const Interval& a, const Interval& b) { return a.low < b.low; });
  std::vector<Interval> result;
  for (const Interval& i : intervals) {
    if (!result.empty() && i.low <= result.back().high)
      result.back().high = std::max(result.back().high, i.high);
    else
      result.push_back(i);
  }
  return result;
}

// Sums of areas that are put together must lie on one grid. A cell adds at most, in absolute value: in an interval 5
// times its area to a coefficient; in a histogram its area 34 times to one edge or another, if its pieces are short,
// and (1 + 15²) times at either end of each of its two pieces, if they are long (roots lie at most 103 edges away from
// the edges that count, or on the far side, and a long piece is over 8 wide, so that ratios stay below 15).
constexpr double times_its_area = 1024;

// Densities steer a search and decide nothing, so that those of cells far flatter than the interval are cut short:
// their sum has a bound then.
[[nodiscard]] inline double most_density(double area, const Interval& v) {
  constexpr double steepest = 0x1p30, largest = 0x1p800;
  return std::min(steepest * (area / (v.high - v.low)), largest);
}
[[nodiscard]] inline FixedScale density_scale(double most) { return FixedScale{0x1p40, most}; }  // as many cells

// What a block of cells adds to the area where d ≤ v, for v in one interval.
struct Share {
  FixedSum before;                                // cells that end below the interval and not below the one before it
  std::array<FixedSum, 3> quadratic;              // cells without a corner inside, in u = (v − low) / (high − low)
  std::vector<Cell> cut;                          // cells with one
  std::vector<std::pair<double, FixedSum>> flat;  // constant cells: value, area

  explicit Share(const FixedScale& scale)
      : before(scale), quadratic{FixedSum(scale), FixedSum(scale), FixedSum(scale)}, scale_(scale) {}

  void add_flat(double d, double area) {
    if (flat.empty() || flat.back().first != d) flat.emplace_back(d, FixedSum(scale_));
    flat.back().second.add(area);
  }
  void add(const Cell& cell, const Interval& v) {
    const auto [d0, d1, d2] = cell.d;
    const double width = v.high - v.low;
    // area · (v − root)² / (e · f) with e, f not below the width: all ratios are at most 1.
    const auto add_square = [&](double sign, double root, double e, double f) {
      const double p = (v.low - root) / e, q = (v.low - root) / f, b = width / f;
      quadratic[0].add(sign * cell.area * p * q);
      quadratic[1].add(sign * 2 * cell.area * p * b);
      quadratic[2].add(sign * cell.area * (width / e) * b);
    };
    if (d0 == d2) {
      add_flat(d0, cell.area);
    } else if (d0 <= v.low && v.high <= d1) {
      add_square(1, d0, d1 - d0, d2 - d0);
    } else if (d1 <= v.low && v.high <= d2) {
      quadratic[0].add(cell.area);
      add_square(-1, d2, d1 - d2, d0 - d2);
    } else {
      cut.push_back(cell);
    }
  }

 private:
  FixedScale scale_;
};

// What a block of cells adds, interval by interval; one more, for what ends behind all.
class Shares {
 public:
  Shares(const std::vector<Interval>& intervals, const FixedScale& scale)
      : intervals_(&intervals), shares_(intervals.size() + 1, Share(scale)) {}

  /// Numbers of intervals.
  struct Range {
    std::size_t first, last;
  };
  /// Adds a cell, its values sorted, to the intervals that it reaches into, and gives the one that it ends before, to
  /// which its area is still to be added. `near`: those before it lie below the cell, those from its end on above.
  std::size_t add_inside(const Cell& cell, const Range& near) {
    std::size_t first = near.first, last = near.first;
    for (std::size_t k = near.first; k < near.last; ++k) {
      first += (*intervals_)[k].high < cell.d[0] ? 1 : 0;
      last += (*intervals_)[k].low <= cell.d[2] ? 1 : 0;
    }
    for (std::size_t k = first; k < last; ++k) shares_[k].add(cell, (*intervals_)[k]);
    return last;
  }
  /// Of cells that end before interval k and not before the one before it.
  void add_before(std::size_t k, double area) { shares_[k].before.add(area); }
  void add_before(std::size_t k, const FixedSum& area) { shares_[k].before.add(area); }

  [[nodiscard]] const Share& operator[](std::size_t k) const { return shares_[k]; }

 private:
  const std::vector<Interval>* intervals_;
  std::vector<Share> shares_;
};

// Area where d ≤ v, exactly, for v in given intervals: from the shares of all blocks.
class AreaUpTo {
 public:
  /// `area`: of all cells.
  AreaUpTo(const std::vector<Interval>& intervals, std::vector<Shares> of_blocks, const FixedScale& scale, double area)
      : intervals_(intervals),
        shares_(std::move(of_blocks)),
        total_(intervals.size(), Share(scale)),
        scale_(scale),
        area_(area) {
    for (const Shares& shares : shares_)
      for (std::size_t k = 0; k < intervals.size(); ++k) {
        for (std::size_t j = k; j < intervals.size(); ++j) total_[j].before.add(shares[k].before);
        for (std::size_t i = 0; i < 3; ++i) total_[k].quadratic[i].add(shares[k].quadratic[i]);
      }
  }

  /// v must lie in an interval. `holds(d)`: is the variable of a constant cell small enough?
  template <class Holds>
  [[nodiscard]] Growth operator()(double v, Holds&& holds) const {
    std::size_t k = 0;
    while (k + 1 < intervals_.size() && intervals_[k].high < v) ++k;
    const auto& [low, high] = intervals_[k];
    struct Sums {
      FixedSum area, density;
    };
    const double most = most_density(area_, intervals_[k]);
    const Sums none{FixedSum(scale_), FixedSum(density_scale(most))};
    const Sums sums = reduce_blocks<Sums>(
        shares_.size(), 1,
        [&](std::size_t b, std::size_t) {
          Sums part = none;
          for (const auto& [d, area] : shares_[b][k].flat)
            if (holds(d)) part.area.add(area);
          for (const Cell& cell : shares_[b][k].cut) {
            const Growth g = growth_of_d(cell, v);
            if (g.area != 0) part.area.add(g.area);
            if (g.density != 0) part.density.add(std::min(g.density, most));
          }
          return part;
        },
        [](Sums& total, const Sums& part) {
          total.area.add(part.area);
          total.density.add(part.density);
        });
    const double u = (v - low) / (high - low);
    const auto c = [&](std::size_t i) { return total_[k].quadratic[i].value(); };
    return {total_[k].before.value() + (c(0) + u * (c(1) + u * c(2))) + sums.area.value(),
            (c(1) + 2 * u * c(2)) / (high - low) + sums.density.value()};
  }

 private:
  const std::vector<Interval>& intervals_;
  std::vector<Shares> shares_;
  std::vector<Share> total_;
  FixedScale scale_;
  double area_;
};

// Area up to each edge of even bins, as running sums of quadratics in the number of the edge.
class EdgeSums {
 public:
  EdgeSums() = default;
  EdgeSums(double low, double high, std::size_t count, const FixedScale& scale)
      : low_(low),
        unit_(high - low < smallest ? 1 / smallest : 1),
        per_unit_(static_cast<double>(count) / ((high - low) * unit_)),
        edges_(count + 1) {
    const FixedSum none(scale);
    c_.assign(count + 2, {none, none, none});
  }

  /// The number of edges below d: grows with d.
  [[nodiscard]] std::size_t edges_below(double d) const { return first_edge((d - low_) * unit_ * per_unit_); }
  [[nodiscard]] std::size_t edges() const { return edges_; }

  void add(const Cell& cell) {  // values sorted
    std::array<double, 3> u = cell.d;
    constexpr double far = 1e100;  // far beyond all edges; squares of it are numbers still
    for (double& x : u) x = std::clamp((x - low_) * unit_ * per_unit_, -far, far);
    const std::size_t k0 = first_edge(u[0]), k1 = first_edge(u[1]), k2 = first_edge(u[2]);
    if (k1 > k0) piece(k0, k1, 0, cell.area / ((u[1] - u[0]) * (u[2] - u[0])), u[0]);
    if (k2 > k1) piece(k1, k2, cell.area, -cell.area / ((u[2] - u[0]) * (u[2] - u[1])), u[2]);
    c_[k2][0].add(cell.area);
  }
  /// Cells that lie between edge k − 1 and edge k.
  void add_between(std::size_t k, const FixedSum& area) { c_[k][0].add(area); }

  void add(const EdgeSums& other) {
    if (c_.empty()) {
      *this = other;
      return;
    }
    for (std::size_t k = 0; k < c_.size(); ++k)
      for (std::size_t i = 0; i < 3; ++i) c_[k][i].add(other.c_[k][i]);
  }
  [[nodiscard]] std::vector<double> values() const {
    std::vector<double> f(edges_);
    std::array<FixedSum, 3> sum;
    for (std::size_t k = 0; k < edges_; ++k) {
      for (std::size_t i = 0; i < 3; ++i) sum[i].add(c_[k][i]);
      const auto x = static_cast<double>(k);
      f[k] = sum[0].value() + x * (sum[1].value() + x * sum[2].value());
    }
    return f;
  }

 private:
  // A piece over few edges may be steep: its coefficients would cancel. It is added edge by edge.
  static constexpr std::size_t few_edges = 8;
  // Below it the number of bins in a unit of d would be infinite: d is then counted in larger units.
  static constexpr double smallest = 0x1p-900;

  [[nodiscard]] std::size_t first_edge(double u) const {
    if (!(u > 0)) return 0;
    if (u >= static_cast<double>(edges_)) return edges_;
    const auto whole = static_cast<std::int32_t>(u);  // rounded up without std::ceil, which is a call on older machines
    return static_cast<std::size_t>(whole + (static_cast<double>(whole) < u ? 1 : 0));
  }
  // constant + factor · (k − root)² at the edges [from, to).
  void piece(std::size_t from, std::size_t to, double constant, double factor, double root) {
    if (to - from <= few_edges) {
      for (std::size_t k = from; k < to; ++k) {
        const double x = static_cast<double>(k) - root;
        const double value = constant + factor * x * x;
        c_[k][0].add(value);
        c_[k + 1][0].add(-value);
      }
      return;
    }
    const std::array<double, 3> coefficients{constant + factor * root * root, -2 * factor * root, factor};
    for (std::size_t i = 0; i < 3; ++i) {
      c_[from][i].add(coefficients[i]);
      c_[to][i].add(-coefficients[i]);
    }
  }

  double low_ = 0, unit_ = 1, per_unit_ = 0;
  std::size_t edges_ = 0;
  std::vector<std::array<FixedSum, 3>> c_;
};

}  // namespace isopach
