#include "isopach/measure/uncertainty/local_fit.hpp"

#include <algorithm>
#include <cmath>

#include "isopach/base/parallel.hpp"

namespace isopach {

namespace {

constexpr std::size_t unknowns = LocalFits::terms + 1;
constexpr std::array<std::size_t, 4> unknowns_of_degree{1, 3, 6, 10};
constexpr std::size_t most_gathered = 64;  // of a node with very many neighbours: enough to choose the nearest from
constexpr double least_pivot = 1e-8;       // of a normal matrix with unit diagonal: below it the terms depend on others
constexpr double least_freedom = 0.05;     // 1 − leverage: a fit that follows the node says nothing of its residual

using Vector = std::array<double, unknowns>;

// One half-edge that leaves each node; of a node in no triangle none.
Array<HalfEdge> leaving(const Triangulation& t) {
  Array<HalfEdge> first(t.nodes);
  for_each_index(first.size(), [&](std::size_t i) { first[i] = no_index; });
  for (Index i = 0; i < t.real; ++i)
    for (Index side = 0; side < 3; ++side) first[t.triangles[i].v[side]] = half_edge(i, side);
  return first;
}

class Neighbourhood {
 public:
  Neighbourhood(const Triangulation& t, std::span<const HalfEdge> first, std::span<const Point2> xy)
      : t_(t), first_(first), xy_(xy) {}

  // The node itself first, then the others by distance.
  std::span<const Index> of(Index node) {
    count_ = 0;
    found_[count_++] = node;
    add_ring(node);
    const std::size_t ring = count_;
    for (std::size_t i = 1; i < ring; ++i) add_ring(found_[i]);
    const auto distance2 = [&](Index i) {
      const double dx = xy_[i].x - xy_[node].x, dy = xy_[i].y - xy_[node].y;
      return dx * dx + dy * dy;
    };
    std::array<std::pair<double, Index>, most_gathered> by_distance;
    for (std::size_t i = 0; i < count_; ++i) by_distance[i] = {distance2(found_[i]), found_[i]};
    const std::size_t kept = std::min(count_, LocalFits::most_neighbours + 1);
    std::partial_sort(by_distance.begin(), by_distance.begin() + static_cast<std::ptrdiff_t>(kept),
                      by_distance.begin() + static_cast<std::ptrdiff_t>(count_));
    for (std::size_t i = 0; i < kept; ++i) found_[i] = by_distance[i].second;
    return {found_.data(), kept};
  }

 private:
  void add(Index node) {
    if (node == no_index || count_ == most_gathered) return;
    const auto end = found_.begin() + static_cast<std::ptrdiff_t>(count_);
    if (std::find(found_.begin(), end, node) == end) found_[count_++] = node;
  }
  void add_ring(Index node) {
    const HalfEdge start = first_[node];
    if (start == no_index) return;
    HalfEdge h = start;
    do {
      add(t_.target(h));
      h = t_.next_leaving(h);
    } while (h != start && count_ < most_gathered);
  }

  const Triangulation& t_;
  std::span<const HalfEdge> first_;
  std::span<const Point2> xy_;
  std::array<Index, most_gathered> found_{};
  std::size_t count_ = 0;
};

double weight_at(double distance2) {
  const double s = 1 - 0.8 * distance2;
  return s * s;
}

Vector terms_at(double x, double y) {
  return {1, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y};
}

// Normal equations N c = b of one neighbourhood, N = L Lᵀ. The terms are in order of their degree, so a leading part of
// L solves the fit of a lower degree.
struct NormalEquations {
  std::array<Vector, unknowns> n{};  // lower triangle; then L
  Vector height{}, noise{};

  void add(const Vector& term, double weight, double dz, double e) {
    for (std::size_t i = 0; i < unknowns; ++i) {
      const double weighted = weight * term[i];
      for (std::size_t j = 0; j <= i; ++j) n[i][j] += weighted * term[j];
      height[i] += weighted * dz;
      noise[i] += weighted * e;
    }
  }

  // The number of leading rows that could be factored.
  std::size_t factor() {
    for (std::size_t i = 0; i < unknowns; ++i) {
      const double whole = n[i][i];
      for (std::size_t j = 0; j <= i; ++j) {
        double s = n[i][j];
        for (std::size_t k = 0; k < j; ++k) s -= n[i][k] * n[j][k];
        if (j < i) {
          n[i][j] = s / n[j][j];
        } else {
          if (!(s > least_pivot * whole)) return i;
          n[i][i] = std::sqrt(s);
        }
      }
    }
    return unknowns;
  }

  void solve(Vector& b, std::size_t size) const {
    for (std::size_t i = 0; i < size; ++i) {
      for (std::size_t k = 0; k < i; ++k) b[i] -= n[i][k] * b[k];
      b[i] /= n[i][i];
    }
    for (std::size_t i = size; i-- > 0;) {
      for (std::size_t k = i + 1; k < size; ++k) b[i] -= n[k][i] * b[k];
      b[i] /= n[i][i];
    }
  }
};

// Coefficients for lengths in units of `radius` into such for lengths as they are.
LocalFits::Terms unscaled(const Vector& c, std::size_t size, double radius) {
  LocalFits::Terms terms{};
  for (std::size_t i = 1; i < size; ++i) {
    const double scale = i < unknowns_of_degree[1]   ? radius
                         : i < unknowns_of_degree[2] ? radius * radius
                                                     : radius * radius * radius;
    terms[i - 1] = c[i] / scale;
  }
  return terms;
}

}  // namespace

LocalFits local_fits(const Triangulation& t, std::span<const Point2> xy, std::span<const double> z,
                     std::span<const double> noise, const Context& context) {
  context.check();
  const std::size_t count = xy.size();
  LocalFits fits;
  fits.shape.resize(count), fits.echo.resize(count), fits.residual.resize(count);
  const Array<HalfEdge> first = leaving(t);
  for_blocks(count, default_block, [&](std::size_t begin, std::size_t end) {
    Neighbourhood neighbourhood(t, first, xy);
    for (std::size_t i = begin; i < end; ++i) {
      fits.shape[i] = fits.echo[i] = {};
      fits.residual[i] = 0;
      const std::span<const Index> near = neighbourhood.of(static_cast<Index>(i));
      const Point2& last = xy[near.back()];
      const double radius = std::hypot(last.x - xy[i].x, last.y - xy[i].y);
      if (!(radius > 0)) continue;
      NormalEquations equations;
      std::array<Vector, LocalFits::most_neighbours + 1> terms;
      std::array<double, LocalFits::most_neighbours + 1> weight;
      for (std::size_t k = 0; k < near.size(); ++k) {
        const double x = (xy[near[k]].x - xy[i].x) / radius, y = (xy[near[k]].y - xy[i].y) / radius;
        terms[k] = terms_at(x, y);
        weight[k] = weight_at(x * x + y * y);
        equations.add(terms[k], weight[k], z[near[k]] - z[i], noise[near[k]]);
      }
      const std::size_t rank = equations.factor();
      for (std::size_t degree = 3; degree > 0; --degree) {
        const std::size_t size = unknowns_of_degree[degree];
        if (size > rank || size >= near.size()) continue;
        // The fit at the node is Σ part_k z_k.
        Vector inverse{1};
        equations.solve(inverse, size);
        double variance = 0, own = 0;
        for (std::size_t k = 0; k < near.size(); ++k) {
          double part = 0;
          for (std::size_t j = 0; j < size; ++j) part += inverse[j] * terms[k][j];
          part *= weight[k];
          if (k == 0) own = part;
          variance += k == 0 ? (1 - part) * (1 - part) : part * part;
        }
        if (1 - own < least_freedom) continue;
        equations.solve(equations.height, size);
        equations.solve(equations.noise, size);
        fits.residual[i] = -equations.height[0] / std::sqrt(variance);
        fits.shape[i] = unscaled(equations.height, size, radius);
        fits.echo[i] = unscaled(equations.noise, size, radius);
        break;
      }
    }
  });
  return fits;
}

}  // namespace isopach
