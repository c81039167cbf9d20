#include "isopach/measure/distribution.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "isopach/base/parallel.hpp"
#include "isopach/base/random.hpp"
#include "isopach/base/sum.hpp"

namespace isopach {

namespace {

constexpr std::size_t block = 1 << 15;

Cell sorted(Cell cell) {
  auto& d = cell.d;
  const double low = std::min(d[0], d[1]), high = std::max(d[0], d[1]);
  cell.d = {std::min(low, d[2]), std::max(low, std::min(high, d[2])), std::max(high, d[2])};
  return cell;
}

// Area where the variable is ≤ v, and how fast it grows with v.
struct Growth {
  double area = 0, density = 0;
};
Growth growth_of_d(const Cell& cell, double v) {  // values sorted, not all equal
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
std::vector<Interval> merged(std::vector<Interval> intervals) {
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

// What a block of cells adds to the area where d ≤ v, for v in one interval.
struct Share {
  Sum before;                                   // cells that end below the interval and not below the one before it
  std::array<Sum, 3> quadratic;                 // cells without a corner inside, in u = (v − low) / (high − low)
  std::vector<Cell> cut;                        // cells with one
  std::vector<std::pair<double, double>> flat;  // constant cells: value, area

  void add_flat(double d, double area) {
    if (!flat.empty() && flat.back().first == d)
      flat.back().second += area;
    else
      flat.emplace_back(d, area);
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
};

// Area where d ≤ v, exactly, for v in given intervals. One pass over the cells.
class AreaUpTo {
 public:
  template <class Source>
  AreaUpTo(const Source& cells, const std::vector<Interval>& intervals) : intervals_(intervals) {
    const std::size_t blocks = (items_of(cells) + block - 1) / block;
    shares_.resize(blocks);
    for_blocks(items_of(cells), block,
               [&](std::size_t begin, std::size_t end) { shares_[begin / block] = shares_of(cells, begin, end); });
    total_.resize(intervals.size());
    for (const auto& shares : shares_)
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
    struct Sums {
      Sum area, density;
    };
    const Sums sums = reduce_blocks<Sums>(
        shares_.size(), 1,
        [&](std::size_t b, std::size_t) {
          Sums part;
          for (const auto& [d, area] : shares_[b][k].flat)
            if (holds(d)) part.area.add(area);
          for (const Cell& cell : shares_[b][k].cut) {
            const Growth g = growth_of_d(cell, v);
            part.area.add(g.area);
            part.density.add(g.density);
          }
          return part;
        },
        [](Sums& total, const Sums& part) {
          total.area.add(part.area);
          total.density.add(part.density);
        });
    const auto& [low, high] = intervals_[k];
    const double u = (v - low) / (high - low);
    const auto c = [&](std::size_t i) { return total_[k].quadratic[i].value(); };
    return {total_[k].before.value() + (c(0) + u * (c(1) + u * c(2))) + sums.area.value(),
            (c(1) + 2 * u * c(2)) / (high - low) + sums.density.value()};
  }

 private:
  template <class Source>
  [[nodiscard]] std::vector<Share> shares_of(const Source& cells, std::size_t begin, std::size_t end) const {
    std::vector<double> low, high;
    for (const Interval& i : intervals_) low.push_back(i.low), high.push_back(i.high);
    std::vector<Share> shares(low.size() + 1);
    for_cells(cells, begin, end, [&](const Cell& unsorted) {
      const Cell cell = sorted(unsorted);
      std::size_t first = 0, last = 0;  // intervals that the cell reaches into
      for (const double x : high) first += x < cell.d[0] ? 1 : 0;
      for (const double x : low) last += x <= cell.d[2] ? 1 : 0;
      for (std::size_t k = first; k < last; ++k) shares[k].add(cell, intervals_[k]);
      shares[last].before.add(cell.area);
    });
    return shares;
  }

  const std::vector<Interval>& intervals_;
  std::vector<std::vector<Share>> shares_;  // of each block; one interval more, for what ends behind all
  std::vector<Share> total_;
};

// One of the cells of an item, and the area that it stands for.
std::pair<Cell, double> cell_by_chance(const CellView& cells, std::size_t item, std::size_t) {
  if (cells.in_domain[item] == 0) return {};
  const Cell cell = cell_at(cells, item);
  return {cell, cell.area};
}
std::pair<Cell, double> cell_by_chance(const Overlay& overlay, std::size_t item, std::size_t draw) {
  std::pair<Cell, double> result{};
  for_cells(overlay, item, item + 1, [&](const Cell& cell) { result.second += cell.area; });
  double left = RandomStream(0, 1).uniform(draw) * result.second;
  for_cells(overlay, item, item + 1, [&](const Cell& cell) {
    if (left >= 0) result.first = cell;
    left -= cell.area;
  });
  return result;
}

// Points strewn over a sample of the items: an estimate of the distribution, to know where to look for a quantile.
class Estimate {
 public:
  template <class Source>
  explicit Estimate(const Source& cells) {
    constexpr std::size_t enough = 1 << 16;
    const std::size_t n = items_of(cells), step = n / enough + 1;
    const RandomStream random(0, 0);
    for (std::size_t i = 0; i < n; i += step) {
      const std::size_t k =
          std::min(n - 1, i + static_cast<std::size_t>(random.uniform(3 * i) * static_cast<double>(step)));
      const auto [cell, area] = cell_by_chance(cells, k, i);
      if (!(area > 0)) continue;
      double s = random.uniform(3 * i + 1), t = random.uniform(3 * i + 2);
      if (s + t > 1) s = 1 - s, t = 1 - t;
      points_.emplace_back(cell.d[0] + s * (cell.d[1] - cell.d[0]) + t * (cell.d[2] - cell.d[0]), area);
    }
    std::sort(points_.begin(), points_.end());
    double squares = 0;
    for (const auto& [d, area] : points_) area_ += area, squares += area * area;
    deviation_ = area_ > 0 ? std::sqrt(squares) / area_ : 1;
  }

  /// Where the quantile lies with all likelihood.
  [[nodiscard]] Interval bracket(const Quantile& q, double limit) const {
    constexpr double deviations = 3;
    const double slack = deviations * deviation_ * std::sqrt(q.share * (1 - q.share));
    const auto points = q.absolute ? folded(q.centre) : points_;
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

  [[nodiscard]] Points folded(double centre) const {
    Points below, above, all;
    for (const auto& [d, area] : points_) (d < centre ? below : above).emplace_back(std::fabs(d - centre), area);
    std::merge(below.rbegin(), below.rend(), above.begin(), above.end(), std::back_inserter(all));
    return all;
  }

  Points points_;
  double area_ = 0, deviation_ = 1;
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

// Area up to each edge of even bins, as running sums of quadratics in the number of the edge.
class EdgeSums {
 public:
  EdgeSums() = default;
  EdgeSums(double low, double high, std::size_t count)
      : low_(low), per_unit_(static_cast<double>(count) / (high - low)), edges_(count + 1), c_(count + 2) {}

  void add(const Cell& cell) {
    std::array<double, 3> u = sorted(cell).d;
    for (double& x : u) x = (x - low_) * per_unit_;
    const std::size_t k0 = first_edge(u[0]), k1 = first_edge(u[1]), k2 = first_edge(u[2]);
    if (k1 > k0) piece(k0, k1, 0, cell.area / ((u[1] - u[0]) * (u[2] - u[0])), u[0]);
    if (k2 > k1) piece(k1, k2, cell.area, -cell.area / ((u[2] - u[0]) * (u[2] - u[1])), u[2]);
    c_[k2][0] += cell.area;
  }
  void add(const EdgeSums& other) {
    if (c_.empty()) {
      *this = other;
      return;
    }
    for (std::size_t k = 0; k < c_.size(); ++k)
      for (std::size_t i = 0; i < 3; ++i) c_[k][i] += other.c_[k][i];
  }
  [[nodiscard]] std::vector<double> values() const {
    std::vector<double> f(edges_);
    std::array<Sum, 3> sum;
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

  [[nodiscard]] std::size_t first_edge(double u) const {
    return u <= 0 ? 0 : (u >= static_cast<double>(edges_) ? edges_ : static_cast<std::size_t>(std::ceil(u)));
  }
  // constant + factor · (k − root)² at the edges [from, to).
  void piece(std::size_t from, std::size_t to, double constant, double factor, double root) {
    if (to - from <= few_edges) {
      for (std::size_t k = from; k < to; ++k) {
        const double x = static_cast<double>(k) - root;
        const double value = constant + factor * x * x;
        c_[k][0] += value;
        c_[k + 1][0] -= value;
      }
      return;
    }
    const std::array<double, 3> coefficients{constant + factor * root * root, -2 * factor * root, factor};
    for (std::size_t i = 0; i < 3; ++i) {
      c_[from][i] += coefficients[i];
      c_[to][i] -= coefficients[i];
    }
  }

  double low_ = 0, per_unit_ = 0;
  std::size_t edges_ = 0;
  std::vector<std::array<double, 3>> c_;
};

}  // namespace

double area_below(const Cell& cell, double v) {
  const auto [d0, d1, d2] = sorted(cell).d;
  if (v < d0) return 0;
  if (v >= d2) return cell.area;
  if (v < d1) return cell.area * ((v - d0) / (d1 - d0)) * ((v - d0) / (d2 - d0));
  return cell.area - cell.area * ((d2 - v) / (d2 - d0)) * ((d2 - v) / (d2 - d1));
}

template <class Source>
Distribution<Source>::Distribution(const Source& cells, double area, double limit, const Context& context)
    : cells_(cells), context_(context), area_(area), limit_(limit) {}

template <class Source>
std::vector<double> Distribution<Source>::area_up_to_edges(double low, double high, std::size_t count) const {
  context_.check();
  return reduce_blocks<EdgeSums>(
             items_of(cells_), block,
             [&](std::size_t begin, std::size_t end) {
               EdgeSums part(low, high, count);
               for_cells(cells_, begin, end, [&](const Cell& cell) { part.add(cell); });
               return part;
             },
             [](EdgeSums& total, const EdgeSums& part) { total.add(part); })
      .values();
}

template <class Source>
std::vector<double> Distribution<Source>::areas_between(double low, double high, std::size_t count) const {
  std::vector<double> edges = area_up_to_edges(low, high, count);
  edges.front() = 0;
  edges.back() = area_;
  std::vector<double> areas(count);
  for (std::size_t k = 0; k < count; ++k) areas[k] = std::max(0.0, edges[k + 1] - edges[k]);
  return areas;
}

template <class Source>
std::vector<double> Distribution<Source>::quantiles(const std::vector<Quantile>& wanted) const {
  context_.check();
  const Estimate estimate(cells_);
  std::vector<Search> searches;
  for (Quantile q : wanted) {
    Interval centre{q.centre, q.centre};
    if (q.about != Quantile::nothing) {
      centre = searches[q.about].bracket;
      q.centre = centre.low + (centre.high - centre.low) / 2;
    }
    searches.push_back({q, estimate.bracket(q, limit_), centre, {}});
  }
  for (;;) {
    std::vector<Interval> intervals;
    for (const Search& s : searches)
      if (!s.found) s.add_intervals(intervals);
    if (intervals.empty()) break;
    intervals = merged(std::move(intervals));
    const AreaUpTo area(cells_, intervals);
    for (Search& s : searches) {
      if (s.found) continue;
      if (s.wanted.about != Quantile::nothing) {
        const Search& centre = searches[s.wanted.about];
        s.centre = centre.found ? Interval{*centre.found, *centre.found} : centre.bracket;
        s.wanted.centre = s.centre.low;
        if (!centre.found) continue;
      }
      s.solve(area, s.wanted.share * area_, limit_);
    }
  }
  std::vector<double> found;
  for (const Search& s : searches) found.push_back(*s.found);
  return found;
}

template class Distribution<CellView>;
template class Distribution<Overlay>;

}  // namespace isopach
