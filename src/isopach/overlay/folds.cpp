#include "isopach/overlay/folds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "isopach/base/median.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/geom/predicates.hpp"

namespace isopach {
namespace {

/// The edges of the footprint, node by node.
class Stars {
 public:
  Stars(const Triangulation& t, const Footprint& footprint) : t_(t), footprint_(footprint), leaving_(t.nodes, no_index) {
    for_each_index(t.real, [&](std::size_t i) {
      if (!footprint.keeps(static_cast<Index>(i))) return;
      for (Index k = 0; k < 3; ++k) write_shared(leaving_[t.triangles[i].v[k]], half_edge(static_cast<Index>(i), k));
    });
    // Which of its half-edges a node was given is left to chance, and no matter: sets of neighbours are asked alone.
  }

  /// f(neighbour) for the other ends of the kept edges at a node, counter-clockwise.
  template <class F>
  void for_neighbours(Index node, F&& f) const {
    const HalfEdge first = leaving_[node];
    if (first == no_index) return;
    HalfEdge h = first;
    do {
      const Index to = t_.target(h);
      if (to != no_index && (keeps(triangle_of(h)) || keeps(triangle_of(t_.twin(h))))) f(to);
      h = t_.next_leaving(h);
    } while (h != first);
  }

 private:
  [[nodiscard]] bool keeps(Index triangle) const { return !t_.is_ghost(triangle) && footprint_.keeps(triangle); }

  const Triangulation& t_;
  const Footprint& footprint_;
  Array<HalfEdge> leaving_;
};

/// The k-th smallest of values, the largest where there are fewer; 0 of none.
double kth_smallest(std::vector<double>& values, std::size_t k) {
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::min(k, values.size()) - 1);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Rules 1 and 2 at one node after another.
class Finder {
 public:
  Finder(const Stars& stars, std::span<const Point2> xy, std::span<const double> z, std::span<const double> spread)
      : stars_(stars), xy_(xy), z_(z), spread_(spread) {}

  [[nodiscard]] bool covered(Index node) {
    if (!may_be_covered(node)) return false;
    const double own = limit(node);
    if (!spread_.empty() && spread_[node] > own) return true;
    above_.clear(), below_.clear();
    stars_.for_neighbours(node, [&](Index n) {
      const double step = z_[n] - z_[node];
      if (std::fabs(step) > own) (step > 0 ? above_ : below_).push_back(n);
    });
    for (std::vector<Index>* others : {&above_, &below_})
      std::erase_if(*others, [&](Index n) { return !(std::fabs(z_[n] - z_[node]) > limit(n)); });
    return surrounded(node, above_) || surrounded(node, below_);
  }

 private:
  /// With the least that the limit can be: on an even surface the answer is no.
  [[nodiscard]] bool may_be_covered(Index node) {
    double shortest2 = std::numeric_limits<double>::infinity(), most = spread_.empty() ? 0 : spread_[node];
    stars_.for_neighbours(node, [&](Index n) {
      shortest2 = std::min(shortest2, squared(node, n));
      most = std::max(most, std::fabs(z_[n] - z_[node]));
    });
    constexpr double rounding = 1 + 1e-12;
    return most * most * rounding > torn_spacings * torn_spacings * shortest2;
  }

  [[nodiscard]] double limit(Index node) {
    steps_.clear();
    steps_.push_back(step(node));
    stars_.for_neighbours(node, [&](Index n) { steps_.push_back(step(n)); });
    return std::max(torn_spacings * spacing(node), torn_steps * median(steps_));
  }

  [[nodiscard]] double spacing(Index node) {
    values_.clear();
    stars_.for_neighbours(node, [&](Index n) { values_.push_back(squared(node, n)); });
    return std::sqrt(kth_smallest(values_, 3));
  }
  [[nodiscard]] double step(Index node) {
    values_.clear();
    stars_.for_neighbours(node, [&](Index n) { values_.push_back(std::fabs(z_[n] - z_[node])); });
    return kth_smallest(values_, 2);
  }
  [[nodiscard]] double squared(Index a, Index b) const {
    const double dx = xy_[b].x - xy_[a].x, dy = xy_[b].y - xy_[a].y;
    return dx * dx + dy * dy;
  }

  /// Whether no closed half-plane through the node holds all of `others`, which go round it counter-clockwise.
  [[nodiscard]] bool surrounded(Index node, const std::vector<Index>& others) const {
    for (std::size_t k = 0; k < others.size(); ++k)
      if (orientation(xy_[node], xy_[others[k]], xy_[others[(k + 1) % others.size()]]) <= 0) return false;
    return !others.empty();
  }

  const Stars& stars_;
  std::span<const Point2> xy_;
  std::span<const double> z_, spread_;
  std::vector<Index> above_, below_;
  std::vector<double> values_, steps_;
};

/// Rule 3: another covered node within two edges.
bool has_company(const Stars& stars, const Array<unsigned char>& covered, Index node) {
  bool found = false;
  stars.for_neighbours(node, [&](Index n) {
    found = found || covered[n] != 0;
    stars.for_neighbours(n, [&](Index m) { found = found || (m != node && covered[m] != 0); });
  });
  return found;
}

/// Rule 4, by node: those that count and their neighbours; empty if there are none.
Array<unsigned char> nodes_of_folds(const Stars& stars, const Array<unsigned char>& covered, std::size_t nodes) {
  Array<unsigned char> seed(nodes), folded(nodes);
  const std::size_t seeds = reduce_blocks<std::size_t>(
      nodes, default_block,
      [&](std::size_t begin, std::size_t end) {
        std::size_t count = 0;
        for (std::size_t i = begin; i < end; ++i) {
          seed[i] = covered[i] != 0 && has_company(stars, covered, static_cast<Index>(i)) ? 1 : 0;
          count += seed[i];
        }
        return count;
      },
      [](std::size_t& total, std::size_t part) { total += part; });
  if (seeds == 0) return {};
  for_each_index(nodes, [&](std::size_t i) {
    folded[i] = seed[i];
    if (folded[i] == 0) stars.for_neighbours(static_cast<Index>(i), [&](Index n) { folded[i] |= seed[n]; });
  });
  return folded;
}

}  // namespace

Folds find_folds(const Triangulation& t, std::span<const Point2> xy, std::span<const double> z,
                 std::span<const double> spread, const Footprint& footprint, const Context& context) {
  context.check();
  const Stars stars(t, footprint);
  Array<unsigned char> covered(xy.size());
  for_blocks(xy.size(), default_block, [&](std::size_t begin, std::size_t end) {
    Finder finder(stars, xy, z, spread);
    for (std::size_t i = begin; i < end; ++i) covered[i] = finder.covered(static_cast<Index>(i)) ? 1 : 0;
  });
  const Array<unsigned char> node = nodes_of_folds(stars, covered, xy.size());
  Folds folds;
  if (node.empty()) return folds;
  folds.folded.resize(t.real);
  folds.area = reduce_blocks<Sum>(
                   t.real, default_block,
                   [&](std::size_t begin, std::size_t end) {
                     Sum area;
                     for (std::size_t i = begin; i < end; ++i) {
                       const auto& v = t.triangles[i].v;
                       const bool is = footprint.keeps(static_cast<Index>(i)) &&
                                       (node[v[0]] != 0 || node[v[1]] != 0 || node[v[2]] != 0);
                       folds.folded[i] = is ? 1 : 0;
                       const Point2 &a = xy[v[0]], &b = xy[v[1]], &c = xy[v[2]];
                       if (is) area.add(0.5 * ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)));
                     }
                     return area;
                   },
                   [](Sum& total, const Sum& part) { total.add(part); })
                   .value();
  return folds;
}

Footprint without(const Footprint& footprint, const Folds& folds) {
  Footprint f = footprint;
  if (!folds.any()) return f;
  if (f.removed.empty()) {
    f.removed = folds.folded;
    return f;
  }
  for_each_index(f.removed.size(), [&](std::size_t i) { f.removed[i] = f.removed[i] != 0 || folds.folded[i] != 0; });
  return f;
}

}  // namespace isopach
