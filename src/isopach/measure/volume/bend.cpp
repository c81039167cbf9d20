#include "isopach/measure/volume/bend.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/base/random.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/measure/source.hpp"
#include "isopach/overlay/localise.hpp"

namespace isopach {

namespace {

constexpr unsigned steps = 4;                                // along each side of a cell
constexpr unsigned lattice = (steps + 1) * (steps + 2) / 2;  // points of a cell, its corners among them
constexpr unsigned made = lattice - 3;
constexpr double deviations = 2.5758293035489004;  // 99 % of a normal distribution
// Points move this far towards the centroid, so that none falls out of a hull by rounding; the moves of a linear d
// cancel in the cell.
constexpr double inwards = 0x1p-30;

/// Number of the lattice point i steps towards corner 1 and j towards corner 2.
constexpr unsigned number(unsigned i, unsigned j) { return j * (steps + 1) - j * (j - 1) / 2 + i; }
constexpr bool is_corner(unsigned i, unsigned j) { return i + j == 0 || i == steps || j == steps; }

struct Drawn {
  std::size_t item;  // a triangle of T or a piece of one, see source.hpp
  double weight;     // cells it stands for, by area
};

struct Draw {
  Array<Drawn> cells;
  bool is_sample = false;
};

// All cells of the domain, or one for each stretch of equal area.
Draw draw(const CellView& cells, std::size_t most, const Context& context) {
  struct Part {
    std::size_t count = 0;
    Sum area;
  };
  const std::vector<std::size_t> order = items_in_order(cells);
  std::vector<Part> parts((order.size() + default_block - 1) / default_block);
  for_blocks(order.size(), default_block, [&](std::size_t begin, std::size_t end) {
    Part& part = parts[begin / default_block];
    for (std::size_t i = begin; i < end; ++i) ++part.count, part.area.add(of_item(cells, order[i]).cell().area);
  });
  Part total;
  std::vector<double> before;
  for (const Part& part : parts) {
    before.push_back(total.area.value());
    total.count += part.count, total.area.add(part.area);
  }
  Draw result;
  Array<Drawn>& drawn = result.cells;
  if (total.count <= most) {
    for (const std::size_t item : order) drawn.push_back({item, 1});
    return result;
  }
  result.is_sample = true;
  const double stretch = total.area.value() / static_cast<double>(most);
  const RandomStream random(context.seed, 0x62656e64);
  const auto place = [&](std::size_t k) { return (static_cast<double>(k) + random.uniform(k)) * stretch; };
  drawn.reserve(most);
  std::size_t next = 0;  // the draw whose place is not reached yet
  for (std::size_t b = 0; b < parts.size() && next < most; ++b) {
    const double end = b + 1 < parts.size() ? before[b + 1] : HUGE_VAL;
    if (place(next) >= end) continue;
    double reached = before[b];
    const std::size_t last = std::min(order.size(), (b + 1) * default_block);
    for (std::size_t i = b * default_block; i < last; ++i) {
      const double area = of_item(cells, order[i]).cell().area;
      reached += area;
      for (; next < most && place(next) < reached; ++next) drawn.push_back({order[i], stretch / area});
    }
  }
  return result;
}

Array<Point2> lattice_points(const CellView& cells, const Array<Drawn>& drawn) {
  Array<Point2> points(made * drawn.size());
  for_each_index(drawn.size(), [&](std::size_t k) {
    const CommonCell cell = of_item(cells, drawn[k].item);
    const Corner o = cell.corner(0), p = cell.corner(1), q = cell.corner(2);
    std::size_t at = made * k;
    for (unsigned j = 0; j <= steps; ++j)
      for (unsigned i = 0; i + j <= steps; ++i) {
        if (is_corner(i, j)) continue;
        const double s = i * (1 - inwards) / steps + inwards / 3, t = j * (1 - inwards) / steps + inwards / 3;
        points[at++] = {o.x + s * (p.x - o.x) + t * (q.x - o.x), o.y + s * (p.y - o.y) + t * (q.y - o.y)};
      }
  });
  return points;
}

/// A cell cut into n² triangles, n a divisor of `steps`, d linear on each.
Parts cut(double area, const std::array<double, lattice>& d, unsigned n) {
  const unsigned step = steps / n;
  Sum above, below;
  const auto add = [&](unsigned a, unsigned b, unsigned c) {
    const Parts part = split_volume({area / (n * n), {d[a], d[b], d[c]}});
    above.add(part.above), below.add(part.below);
  };
  for (unsigned j = 0; j < steps; j += step)
    for (unsigned i = 0; i + j < steps; i += step) {
      add(number(i, j), number(i + step, j), number(i, j + step));
      if (i + j + 2 * step <= steps) add(number(i + step, j), number(i + step, j + step), number(i, j + step));
    }
  return {above.value(), below.value()};
}

// Of above, below, net, absolute.
using Four = std::array<double, 4>;
Four four(const Parts& p) { return {p.above, p.below, p.above - p.below, p.above + p.below}; }

struct Estimate {
  std::array<Sum, 4> correction, rest, square;
};

}  // namespace

BendError bend_error(const CellView& cells, const SmoothSurface& s1, const SmoothSurface& s2, const Context& context,
                     std::size_t most_cells) {
  context.check();
  const auto [drawn, is_sample] = draw(cells, most_cells, context);
  const Array<Point2> points = lattice_points(cells, drawn);
  const auto heights = [&](const SmoothSurface& s) {
    return s.at(localise_in_order(points, s.triangulation(), s.nodes(), context), points, context);
  };
  Array<double> z1, z2;
  both([&] { z1 = heights(s1); }, [&] { z2 = heights(s2); });

  Array<Four> corrections(drawn.size()), rests(drawn.size());
  for_each_index(drawn.size(), [&, &drawn = drawn](std::size_t k) {
    const Cell cell = of_item(cells, drawn[k].item).cell();
    std::array<double, lattice> d;
    std::size_t at = made * k;
    for (unsigned j = 0; j <= steps; ++j)
      for (unsigned i = 0; i + j <= steps; ++i) {
        if (is_corner(i, j)) {
          d[number(i, j)] = cell.d[i == steps ? 1 : j == steps ? 2 : 0];
          continue;
        }
        d[number(i, j)] = z2[at] - z1[at];
        ++at;
      }
    const Four whole = four(split_volume(cell)), coarse = four(cut(cell.area, d, 2)), fine = four(cut(cell.area, d, 4));
    for (unsigned v = 0; v < 4; ++v) {
      rests[k][v] = drawn[k].weight * (fine[v] - coarse[v]);
      // The error of a smooth integrand falls to a fourth with each halving: a third of the last step is left.
      corrections[k][v] = drawn[k].weight * (fine[v] - whole[v]) + rests[k][v] / 3;
    }
  });

  Estimate e;
  for (std::size_t k = 0; k < drawn.size(); ++k)
    for (unsigned v = 0; v < 4; ++v) {
      e.correction[v].add(corrections[k][v]), e.rest[v].add(rests[k][v]);
      e.square[v].add(rests[k][v] * rests[k][v]);  // what is left in one cell knows nothing of the next
      if (!is_sample || k % 2 == 0) continue;
      const double difference = corrections[k][v] - corrections[k - 1][v];
      e.square[v].add(difference * difference);
    }
  BendError result;
  result.correction = {e.correction[0].value(), e.correction[1].value(), e.correction[2].value(),
                       e.correction[3].value()};
  for (unsigned v = 0; v < 4; ++v)
    result.bound = std::max(result.bound, std::fabs(e.correction[v].value()) + std::fabs(e.rest[v].value()) +
                                              deviations * std::sqrt(e.square[v].value()));
  return result;
}

}  // namespace isopach
