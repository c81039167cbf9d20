#include "isopach/measure/distribution.hpp"

#include <algorithm>
#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"

namespace isopach {

namespace {

constexpr std::size_t block = 1 << 14;
constexpr std::size_t bins = 512;

double area_up_to(const Cell& cell, const Variable& variable, double v) {
  if (!variable.absolute) return area_below(cell, v);
  if (v < 0) return 0;
  // The lower limit belongs to the range: a cell constant at centre − v counts.
  const Cell mirrored{cell.area, {-cell.d[0], -cell.d[1], -cell.d[2]}};
  return std::max(0.0, area_below(cell, variable.centre + v) + area_below(mirrored, v - variable.centre) - cell.area);
}

struct Range {
  double low, high;
};
Range range_of(const Cell& cell, const Variable& variable) {
  auto [low, high] = std::minmax({cell.d[0], cell.d[1], cell.d[2]});
  if (!variable.absolute) return {low, high};
  low -= variable.centre;
  high -= variable.centre;
  if (low <= 0 && high >= 0) return {0, std::max(-low, high)};
  return {std::min(std::fabs(low), std::fabs(high)), std::max(std::fabs(low), std::fabs(high))};
}

// Adds the area of a cell to bins [k·step + from, …).
class Binner {
 public:
  Binner(double from, double to) : from_(from), step_((to - from) / static_cast<double>(bins)) {}
  [[nodiscard]] double edge(std::size_t k) const { return from_ + step_ * static_cast<double>(k); }
  [[nodiscard]] std::size_t bin(double v) const {
    const double k = (v - from_) / step_;
    return k > 0 ? std::min(bins - 1, static_cast<std::size_t>(k)) : 0;
  }
  void add(std::vector<double>& areas, const Cell& cell, const Variable& variable, double& before) const {
    const Range r = range_of(cell, variable);
    const std::size_t first = bin(r.low), last = bin(r.high);
    double done = r.low < from_ ? area_up_to(cell, variable, from_) : 0;
    before += done;
    for (std::size_t k = first; k <= last; ++k) {
      const double next = k == last && r.high <= edge(k + 1) ? cell.area : area_up_to(cell, variable, edge(k + 1));
      areas[k] += next - done;
      done = next;
    }
  }

 private:
  double from_, step_;
};

struct BinnedAreas {
  std::vector<double> areas = std::vector<double>(bins, 0.0);
  double before = 0;
};

BinnedAreas bin_cells(const std::vector<Cell>& cells, const Variable& variable, const Binner& binner) {
  return reduce_blocks<BinnedAreas>(
      cells.size(), block,
      [&](std::size_t begin, std::size_t end) {
        BinnedAreas part;
        for (std::size_t i = begin; i < end; ++i) binner.add(part.areas, cells[i], variable, part.before);
        return part;
      },
      [](BinnedAreas& total, const BinnedAreas& part) {
        for (std::size_t k = 0; k < bins; ++k) total.areas[k] += part.areas[k];
        total.before += part.before;
      });
}

// The v in [low, high] where `base` + Σ area{variable ≤ v} over the cells reaches `target`.
double bisect(const std::vector<Cell>& cells, const Variable& variable, double base, double target, double low,
              double high) {
  const auto area_at = [&](double v) {
    Sum sum;
    for (const Cell& c : cells) sum.add(area_up_to(c, variable, v));
    return base + sum.value();
  };
  for (int i = 0; i < 200; ++i) {
    const double middle = low + (high - low) / 2;
    if (middle <= low || middle >= high) break;
    (area_at(middle) >= target ? high : low) = middle;
  }
  return high;
}

std::vector<Cell> domain_cells(const CellView& view) {
  std::vector<Cell> cells;
  const std::size_t n = view.t.real;
  std::vector<std::size_t> start((n + block - 1) / block + 1, 0);
  for_blocks(n, block, [&](std::size_t begin, std::size_t end) {
    std::size_t count = 0;
    for (std::size_t i = begin; i < end; ++i) count += view.in_domain[i] != 0 ? 1 : 0;
    start[begin / block + 1] = count;
  });
  for (std::size_t b = 1; b < start.size(); ++b) start[b] += start[b - 1];
  cells.resize(start.back());
  for_blocks(n, block, [&](std::size_t begin, std::size_t end) {
    std::size_t place = start[begin / block];
    for (std::size_t i = begin; i < end; ++i)
      if (view.in_domain[i] != 0) cells[place++] = cell_at(view, i);
  });
  return cells;
}

// Narrows [low, high] round the wanted quantile until few cells are left.
double quantile(std::vector<Cell> cells, const Variable& variable, double low, double high, double target) {
  double base = 0;  // area of the cells already known to lie wholly below `low`
  for (int round = 0; round < 12 && cells.size() > 2000; ++round) {
    const Binner binner(low, high);
    if (!(binner.edge(1) > low)) break;
    const BinnedAreas binned = bin_cells(cells, variable, binner);
    double sum = base + binned.before;
    std::size_t k = 0;
    while (k + 1 < bins && sum + binned.areas[k] < target) sum += binned.areas[k++];
    const double from = binner.edge(k), to = k + 1 == bins ? high : binner.edge(k + 1);
    std::vector<Cell> cut;
    Sum below;
    for (const Cell& c : cells) {
      const Range r = range_of(c, variable);
      if (r.high < from)
        below.add(c.area);
      else if (r.low <= to)
        cut.push_back(c);
    }
    base += below.value();
    low = from;
    high = to;
    if (cut.size() > cells.size() * 9 / 10 && round > 2) {
      cells = std::move(cut);
      break;
    }
    cells = std::move(cut);
  }
  return bisect(cells, variable, base, target, std::nextafter(low, -HUGE_VAL), high);
}

}  // namespace

double area_below(const Cell& cell, double v) {
  double d0 = cell.d[0], d1 = cell.d[1], d2 = cell.d[2];
  if (d0 > d1) std::swap(d0, d1);
  if (d1 > d2) std::swap(d1, d2);
  if (d0 > d1) std::swap(d0, d1);
  if (v < d0) return 0;
  if (v >= d2) return cell.area;
  if (v < d1) return cell.area * ((v - d0) / (d1 - d0)) * ((v - d0) / (d2 - d0));
  return cell.area - cell.area * ((d2 - v) / (d2 - d0)) * ((d2 - v) / (d2 - d1));
}

std::vector<double> quantiles(const CellView& view, double area, Variable variable, double limit,
                              const std::vector<double>& shares, const Context& context) {
  context.check();
  const std::vector<Cell> cells = domain_cells(view);
  std::vector<double> found;
  for (const double p : shares)
    found.push_back(quantile(cells, variable, variable.absolute ? 0 : -limit, limit, p * area));
  return found;
}

std::vector<double> areas_between(const CellView& view, const std::vector<double>& edges, const Context& context) {
  context.check();
  const std::vector<Cell> cells = domain_cells(view);
  const std::size_t count = edges.size() - 1;
  using Areas = std::vector<double>;
  return reduce_blocks<Areas>(
      cells.size(), block,
      [&](std::size_t begin, std::size_t end) {
        Areas part(count, 0.0);
        for (std::size_t i = begin; i < end; ++i) {
          const auto [low, high] = std::minmax({cells[i].d[0], cells[i].d[1], cells[i].d[2]});
          const auto place = [&](double v) {
            const auto it = std::upper_bound(edges.begin(), edges.end(), v);
            const auto k = it - edges.begin() - 1;
            return static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(k, 0, static_cast<std::ptrdiff_t>(count) - 1));
          };
          const std::size_t first = place(low), last = place(high);
          double done = 0;
          for (std::size_t k = first; k <= last; ++k) {
            const double next = k == last ? cells[i].area : area_below(cells[i], edges[k + 1]);
            part[k] += next - done;
            done = next;
          }
        }
        return part;
      },
      [&](Areas& total, const Areas& part) {
        total.resize(count, 0.0);
        for (std::size_t k = 0; k < count; ++k) total[k] += part[k];
      });
}

}  // namespace isopach
