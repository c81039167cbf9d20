#include "isopach/measure/distribution.hpp"

#include <algorithm>
#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"

namespace isopach {

namespace {

constexpr std::size_t block = 1 << 15;
constexpr std::size_t coarse_bins = 4096;
// Sums of coefficients over 4096 bins round to less than this share of the area; brackets allow for it.
constexpr double coarse_rounding = 1e-8;

std::array<double, 3> sorted(std::array<double, 3> d) {
  if (d[0] > d[1]) std::swap(d[0], d[1]);
  if (d[1] > d[2]) std::swap(d[1], d[2]);
  if (d[0] > d[1]) std::swap(d[0], d[1]);
  return d;
}

struct Range {
  double low, high;
};

// Of the variable on a cell where d runs from low to high.
Range range_of(double low, double high, const Quantile& q) {
  if (!q.absolute) return {low, high};
  low -= q.centre;
  high -= q.centre;
  return {std::max({0.0, low, -high}), std::max(-low, high)};
}

// Area where the variable is ≤ v, and how fast it grows with v. Values sorted, not all equal.
struct Growth {
  double area = 0, density = 0;
};
Growth growth_of_d(const Cell& cell, double v) {
  const auto [d0, d1, d2] = cell.d;
  if (v <= d0) return {};
  if (v >= d2) return {cell.area, 0};
  if (v < d1) {
    const double rate = cell.area * (v - d0) / ((d1 - d0) * (d2 - d0));
    return {rate * (v - d0), 2 * rate};
  }
  const double rate = cell.area * (d2 - v) / ((d2 - d0) * (d2 - d1));
  return {cell.area - rate * (d2 - v), 2 * rate};
}
Growth growth(const Cell& cell, const Quantile& q, double v) {
  if (!q.absolute) return growth_of_d(cell, v);
  if (v < 0) return {};
  const Growth upper = growth_of_d(cell, q.centre + v), lower = growth_of_d(cell, q.centre - v);
  return {upper.area - lower.area, upper.density + lower.density};
}

// Area up to each edge of even bins, as running sums of quadratics in the number of the edge.
class EdgeSums {
 public:
  EdgeSums() = default;
  EdgeSums(double low, double high, std::size_t count)
      : low_(low), per_unit_(static_cast<double>(count) / (high - low)), edges_(count + 1), c_(count + 2) {}

  void add(const Cell& cell) {
    std::array<double, 3> u = sorted(cell.d);
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

// Area of constant cells up to a value: they make the distribution jump.
class Steps {
 public:
  explicit Steps(std::vector<std::pair<double, double>> value_and_area) : steps_(std::move(value_and_area)) {
    std::sort(steps_.begin(), steps_.end());
    Sum sum;
    for (auto& step : steps_) {
      sum.add(step.second);
      step.second = sum.value();
    }
  }
  [[nodiscard]] double up_to(double v) const {
    const auto after =
        std::upper_bound(steps_.begin(), steps_.end(), v, [](double x, const auto& step) { return x < step.first; });
    return after == steps_.begin() ? 0 : (after - 1)->second;
  }

 private:
  std::vector<std::pair<double, double>> steps_;
};

// What of the cells is left once the bracket of a quantile is known.
struct Kept {
  Sum below;                                    // area under the bracket
  std::vector<Cell> cut;                        // cells that reach into it
  std::vector<std::pair<double, double>> flat;  // constant cells in it: value of the variable, area
};

// The v in [low, high] where the area reaches the target: Newton's method inside a bracket that bisection keeps
// closing.
double solve(const Kept& kept, const Quantile& q, double low, double high, double target) {
  const Steps steps(kept.flat);
  struct Totals {
    Sum area, density;
  };
  const auto at = [&](double v) {
    const Totals totals = reduce_blocks<Totals>(
        kept.cut.size(), block,
        [&](std::size_t begin, std::size_t end) {
          Totals part;
          for (std::size_t i = begin; i < end; ++i) {
            const Growth g = growth(kept.cut[i], q, v);
            part.area.add(g.area);
            part.density.add(g.density);
          }
          return part;
        },
        [](Totals& total, const Totals& part) {
          total.area.add(part.area);
          total.density.add(part.density);
        });
    return Growth{kept.below.value() + totals.area.value() + steps.up_to(v) - target, totals.density.value()};
  };
  const double rounding = 1e-15 * target;
  low = std::nextafter(low, -HUGE_VAL);
  double v = low + (high - low) / 2;
  for (int i = 0;; ++i) {
    if (v <= low || v >= high) return high;
    const Growth g = at(v);
    if (std::fabs(g.area) <= rounding && g.density > 0) return v;
    (g.area >= 0 ? high : low) = v;
    const double middle = low + (high - low) / 2, aimed = v - g.area / g.density;
    // A step may leave the bracket, or crawl where the distribution jumps: then halve.
    v = i % 4 != 3 && aimed > low && aimed < high ? aimed : middle;
  }
}

}  // namespace

double area_below(const Cell& cell, double v) {
  const auto [d0, d1, d2] = sorted(cell.d);
  if (v < d0) return 0;
  if (v >= d2) return cell.area;
  if (v < d1) return cell.area * ((v - d0) / (d1 - d0)) * ((v - d0) / (d2 - d0));
  return cell.area - cell.area * ((d2 - v) / (d2 - d0)) * ((d2 - v) / (d2 - d1));
}

template <class Source>
Distribution<Source>::Distribution(const Source& cells, double area, double limit, const Context& context)
    : cells_(cells), context_(context), area_(area), limit_(limit) {
  below_ = area_up_to_edges(-limit, limit, coarse_bins);
}

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
typename Distribution<Source>::Bracket Distribution<Source>::bracket(const Quantile& q) const {
  const double step = 2 * limit_ / static_cast<double>(coarse_bins);
  const auto at = [&](double v, bool up) {  // area up to v, rounded out to an edge of the bins
    if (v < -limit_) return 0.0;
    if (v >= limit_) return area_;
    const auto k = static_cast<std::size_t>((v + limit_) / step);
    return below_[std::min(k + (up ? 1 : 0), coarse_bins)];
  };
  const auto bound = [&](double v, bool up) {
    return q.absolute ? at(q.centre + v, up) - at(q.centre - v, !up) : at(v, up);
  };
  const double slack = coarse_rounding * area_;
  const double start = q.absolute ? -step : -limit_ - step;
  const std::size_t end = static_cast<std::size_t>((limit_ + std::fabs(q.centre) - start) / step) + 2;
  // First multiple of the step at which the bound reaches the target.
  const auto first = [&](bool up, double target) {
    std::size_t lo = 0, hi = end;
    while (hi - lo > 1) {
      const std::size_t k = (lo + hi) / 2;
      (bound(start + step * static_cast<double>(k), up) < target ? lo : hi) = k;
    }
    return hi;
  };
  const double target = q.share * area_;
  return {start + step * (static_cast<double>(first(true, target - slack)) - 2),
          start + step * (static_cast<double>(first(false, target + slack)) + 1)};
}

template <class Source>
std::vector<double> Distribution<Source>::quantiles(const std::vector<Quantile>& wanted) const {
  context_.check();
  std::vector<Bracket> brackets;
  for (const Quantile& q : wanted) brackets.push_back(bracket(q));
  std::vector<Kept> kept = reduce_blocks<std::vector<Kept>>(
      items_of(cells_), block,
      [&](std::size_t begin, std::size_t end) {
        std::vector<Kept> part(wanted.size());
        for_cells(cells_, begin, end, [&](Cell cell) {
          cell.d = sorted(cell.d);
          for (std::size_t k = 0; k < wanted.size(); ++k) {
            const Range r = range_of(cell.d[0], cell.d[2], wanted[k]);
            if (r.high < brackets[k].low) {
              part[k].below.add(cell.area);
            } else if (r.low <= brackets[k].high) {
              if (cell.d[0] == cell.d[2])
                part[k].flat.emplace_back(r.low, cell.area);
              else
                part[k].cut.push_back(cell);
            }
          }
        });
        return part;
      },
      [&](std::vector<Kept>& total, const std::vector<Kept>& part) {
        total.resize(wanted.size());
        for (std::size_t k = 0; k < part.size(); ++k) {
          total[k].below.add(part[k].below);
          total[k].cut.insert(total[k].cut.end(), part[k].cut.begin(), part[k].cut.end());
          total[k].flat.insert(total[k].flat.end(), part[k].flat.begin(), part[k].flat.end());
        }
      });
  kept.resize(wanted.size());
  std::vector<double> found(wanted.size());
  for_blocks(wanted.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k)
      found[k] = solve(kept[k], wanted[k], brackets[k].low, brackets[k].high, wanted[k].share * area_);
  });
  return found;
}

template class Distribution<CellView>;
template class Distribution<Overlay>;

}  // namespace isopach
