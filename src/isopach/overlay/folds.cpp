#include "isopach/overlay/folds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>
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
  Stars(const Triangulation& t, const Footprint& footprint)
      : t_(t), footprint_(footprint), leaving_(t.nodes, no_index) {
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

enum Cover : unsigned char { open = 0, covered = 1, surely_covered = 2 };

/// Rules 1 to 3 at one node after another.
class Finder {
 public:
  Finder(const Stars& stars, std::span<const Point2> xy, std::span<const double> z, std::span<const double> spread)
      : stars_(stars), xy_(xy), z_(z), spread_(spread) {}

  [[nodiscard]] Cover cover(Index node) {
    if (!may_be_covered(node)) return open;
    const Scale own = scale(node);
    if (!spread_.empty() && spread_[node] > own.limit(surely_torn_steps)) return surely_covered;
    ring_.clear();
    stars_.for_neighbours(node, [&](Index n) { ring_.push_back({n, 0}); });
    for (Neighbour& n : ring_) {
      const double step = z_[n.node] - z_[node], size = std::fabs(step);
      if (!(size > own.limit(torn_steps))) continue;
      const Scale other = scale(n.node);
      if (!(size > other.limit(torn_steps))) continue;
      const bool surely = size > own.limit(surely_torn_steps) && size > other.limit(surely_torn_steps);
      n.torn = (step > 0 ? 1 : -1) * (surely ? 2 : 1);
    }
    return std::max(cover(node, 1), cover(node, -1));
  }

 private:
  struct Scale {
    double spacing = 0, step = 0;
    [[nodiscard]] double limit(double steps) const { return std::max(torn_spacings * spacing, steps * step); }
  };
  struct Neighbour {
    Index node;
    int torn;  // 0; ±1, ±2 surely, above or below
  };

  [[nodiscard]] Cover cover(Index node, int sign) {
    if (!surrounded(node, sign, 1)) return open;
    if (!surrounded(node, sign, 2)) return covered;
    std::size_t torn = 0, runs = 0;
    for (std::size_t k = 0; k < ring_.size(); ++k) {
      const bool is = sign * ring_[k].torn >= 2, before = sign * ring_[(k == 0 ? ring_.size() : k) - 1].torn >= 2;
      torn += is ? 1 : 0, runs += is && !before ? 1 : 0;
    }
    return torn == ring_.size() || runs >= 2 ? surely_covered : covered;
  }

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

  [[nodiscard]] Scale scale(Index node) {
    if (const auto known = scale_of_hub_.find(node); known != scale_of_hub_.end()) return known->second;
    steps_.clear();
    steps_.push_back(step(node));
    stars_.for_neighbours(node, [&](Index n) { steps_.push_back(step(n)); });
    const Scale found{spacing(node), median(steps_)};
    if (values_.size() > most_asked_again) scale_of_hub_[node] = found;
    return found;
  }

  [[nodiscard]] double spacing(Index node) {
    values_.clear();
    stars_.for_neighbours(node, [&](Index n) { values_.push_back(squared(node, n)); });
    return std::sqrt(kth_smallest(values_, 3));
  }
  [[nodiscard]] double step(Index node) {
    if (const auto known = step_of_hub_.find(node); known != step_of_hub_.end()) return known->second;
    values_.clear();
    stars_.for_neighbours(node, [&](Index n) { values_.push_back(std::fabs(z_[n] - z_[node])); });
    const bool is_hub = values_.size() > most_asked_again;
    const double found = kth_smallest(values_, 2);
    if (is_hub) step_of_hub_[node] = found;
    return found;
  }
  [[nodiscard]] double squared(Index a, Index b) const {
    const double dx = xy_[b].x - xy_[a].x, dy = xy_[b].y - xy_[a].y;
    return dx * dx + dy * dy;
  }

  /// Whether no closed half-plane through the node holds all neighbours that are torn as much as `least` to one side.
  /// They go round it counter-clockwise, so it is enough to look at each and the next.
  [[nodiscard]] bool surrounded(Index node, int sign, int least) {
    others_.clear();
    for (const Neighbour& n : ring_)
      if (sign * n.torn >= least) others_.push_back(n.node);
    for (std::size_t k = 0; k < others_.size(); ++k)
      if (orientation(xy_[node], xy_[others_[k]], xy_[others_[(k + 1) % others_.size()]]) <= 0) return false;
    return !others_.empty();
  }

  const Stars& stars_;
  std::span<const Point2> xy_;
  std::span<const double> z_, spread_;
  std::vector<Neighbour> ring_;
  std::vector<Index> others_;
  std::vector<double> values_, steps_;
  // Every neighbour asks for what its neighbours have: of a node with thousands of them that is asked once.
  static constexpr std::size_t most_asked_again = 64;
  std::unordered_map<Index, Scale> scale_of_hub_;
  std::unordered_map<Index, double> step_of_hub_;
};

/// f(node) for the nodes within two edges; some more than once, but the neighbours of no node twice: `asked`.
template <class F>
void for_near(const Stars& stars, Index node, std::vector<bool>& asked, F&& f) {
  stars.for_neighbours(node, [&](Index n) {
    f(n);
    if (asked[n]) return;
    asked[n] = true;
    stars.for_neighbours(n, f);
  });
}

/// Rule 4: the nodes of groups that count.
std::vector<Index> groups_that_count(const Stars& stars, const Array<unsigned char>& cover) {
  std::vector<Index> all;
  std::vector<bool> seen(cover.size()), asked(cover.size());
  for (std::size_t i = 0; i < cover.size(); ++i) {
    if (cover[i] != surely_covered || seen[i]) continue;
    std::vector<Index> group{static_cast<Index>(i)};
    seen[i] = true;
    std::size_t sure = 0;
    for (std::size_t k = 0; k < group.size(); ++k) {
      sure += cover[group[k]] == surely_covered ? 1 : 0;
      const Index node = group[k];
      for_near(stars, node, asked, [&](Index n) {
        if (cover[n] == open || seen[n]) return;
        seen[n] = true;
        group.push_back(n);
      });
    }
    if (sure >= 2) all.insert(all.end(), group.begin(), group.end());
  }
  return all;
}

/// Rule 5, by node: those of the groups and their neighbours; empty if there are none.
Array<unsigned char> nodes_of_folds(const Stars& stars, const Array<unsigned char>& cover) {
  const std::vector<Index> seeds = groups_that_count(stars, cover);
  if (seeds.empty()) return {};
  Array<unsigned char> folded(cover.size());
  std::fill(folded.begin(), folded.end(), static_cast<unsigned char>(0));
  for (const Index seed : seeds) {
    folded[seed] = 1;
    stars.for_neighbours(seed, [&](Index n) { folded[n] = 1; });
  }
  return folded;
}

}  // namespace

Folds find_folds(const Triangulation& t, std::span<const Point2> xy, std::span<const double> z,
                 std::span<const double> spread, const Footprint& footprint, const Context& context) {
  context.check();
  const Stars stars(t, footprint);
  Array<unsigned char> cover(xy.size());
  for_blocks(xy.size(), default_block, [&](std::size_t begin, std::size_t end) {
    Finder finder(stars, xy, z, spread);
    for (std::size_t i = begin; i < end; ++i) cover[i] = finder.cover(static_cast<Index>(i));
  });
  const Array<unsigned char> node = nodes_of_folds(stars, cover);
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
