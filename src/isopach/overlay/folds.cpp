#include "isopach/overlay/folds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <utility>
#include <vector>

#include "isopach/base/median.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/first_corner.hpp"
#include "isopach/geom/predicates.hpp"

namespace isopach {
namespace {

/// The edges of the footprint, node by node. A node is named by any half-edge that leaves it, of a kept triangle or
/// with one on the other side; which one, is no matter: sets of neighbours are asked alone.
class Stars {
 public:
  Stars(const Triangulation& t, const Footprint& footprint) : t_(t), footprint_(footprint) {}

  [[nodiscard]] const Triangulation& mesh() const { return t_; }
  [[nodiscard]] Index node(HalfEdge leaving) const { return t_.origin(leaving); }
  [[nodiscard]] bool keeps(Index triangle) const { return !t_.is_ghost(triangle) && footprint_.keeps(triangle); }

  /// f(half-edge that leaves a neighbour) for the other ends of the kept edges at a node, counter-clockwise.
  template <class F>
  void for_neighbours(HalfEdge leaving, F&& f) const {
    HalfEdge h = leaving;
    do {
      const HalfEdge back = t_.twin(h);
      if (t_.target(h) != no_index && (keeps(triangle_of(h)) || keeps(triangle_of(back)))) f(back);
      h = t_.next_leaving(h);
    } while (h != leaving);
  }

 private:
  const Triangulation& t_;
  const Footprint& footprint_;
};

/// The k-th smallest of values, the largest where there are fewer; 0 of none.
double kth_smallest(std::vector<double>& values, std::size_t k) {
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::min(k, values.size()) - 1);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

enum Cover : unsigned char { open = 0, covered = 1, surely_covered = 2 };

/// Whether heights may lie farther apart than the limit of rule 1 at a node, of whose spacing not more is known than
/// the third-shortest of all edges there, kept or not. `step2`, `third2`: squares.
bool may_be_torn(double step2, double third2) {
  constexpr double rounding = 1 + 1e-12;
  return step2 * rounding > torn_spacings * torn_spacings * third2;
}

/// Rules 1 to 3 at one node after another.
class Finder {
 public:
  Finder(const Stars& stars, std::span<const Point2> xy, std::span<const double> z, std::span<const double> spread)
      : stars_(stars), xy_(xy), z_(z), spread_(spread) {}

  [[nodiscard]] Cover cover(HalfEdge leaving) {
    const Index node = stars_.node(leaving);
    const Scale own = scale(leaving);
    if (!spread_.empty() && spread_[node] > own.limit(surely_torn_steps)) return surely_covered;
    ring_.clear();
    stars_.for_neighbours(leaving, [&](HalfEdge n) { ring_.push_back({n, stars_.node(n), 0}); });
    for (Neighbour& n : ring_) {
      const double step = z_[n.node] - z_[node], size = std::fabs(step);
      if (!(size > own.limit(torn_steps))) continue;
      const Scale other = scale(n.leaving);
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
    HalfEdge leaving;
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

  [[nodiscard]] Scale scale(HalfEdge leaving) {
    const Index node = stars_.node(leaving);
    if (const auto known = scale_of_hub_.find(node); known != scale_of_hub_.end()) return known->second;
    steps_.clear();
    steps_.push_back(step(leaving));
    stars_.for_neighbours(leaving, [&](HalfEdge n) { steps_.push_back(step(n)); });
    const Scale found{spacing(leaving), median(steps_)};
    if (values_.size() > most_asked_again) scale_of_hub_[node] = found;
    return found;
  }

  [[nodiscard]] double spacing(HalfEdge leaving) {
    values_.clear();
    const Index node = stars_.node(leaving);
    stars_.for_neighbours(leaving, [&](HalfEdge n) { values_.push_back(squared(node, stars_.node(n))); });
    return std::sqrt(kth_smallest(values_, 3));
  }
  [[nodiscard]] double step(HalfEdge leaving) {
    const Index node = stars_.node(leaving);
    if (const auto known = step_of_hub_.find(node); known != step_of_hub_.end()) return known->second;
    values_.clear();
    stars_.for_neighbours(leaving, [&](HalfEdge n) { values_.push_back(std::fabs(z_[stars_.node(n)] - z_[node])); });
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

/// Half-edges that leave nodes which may be covered, a few of the same node: nodes with an edge that may be torn, and
/// those whose points lie far enough apart. Where a node has fewer than three kept edges, the third-shortest of all may
/// be longer than its spacing: so all nodes of triangles at the rim of the footprint are among them. On an even surface
/// there are no others.
std::vector<HalfEdge> candidates(const Stars& stars, std::span<const double> z, std::span<const double> spread,
                                 std::span<const double> third2) {
  using Found = std::vector<HalfEdge>;
  const Triangulation& t = stars.mesh();
  return gather_blocks<Found>(t.real, default_block, [&](std::size_t begin, std::size_t end) {
    Found found;
    for (std::size_t i = begin; i < end; ++i) {
      if (!stars.keeps(static_cast<Index>(i))) continue;
      const Triangle& triangle = t.triangles[i];
      const bool at_rim = !(stars.keeps(triangle_of(triangle.n[0])) && stars.keeps(triangle_of(triangle.n[1])) &&
                            stars.keeps(triangle_of(triangle.n[2])));
      for (Index k = 0; k < 3; ++k) {
        const Index from = triangle.v[k], to = triangle.v[next_side(k)];
        const double step = z[to] - z[from];
        if (at_rim || may_be_torn(step * step, std::max(third2[from], third2[to])))
          found.push_back(half_edge(static_cast<Index>(i), k)), found.push_back(triangle.n[k]);
        else if (!spread.empty() && may_be_torn(spread[from] * spread[from], third2[from]))
          found.push_back(half_edge(static_cast<Index>(i), k));
      }
    }
    return found;
  });
}

/// Nodes that are covered, each by a half-edge that leaves it.
struct Covered {
  Array<unsigned char> cover;     // by node
  std::vector<HalfEdge> leaving;  // of those not open
};

Covered covered_nodes(const Stars& stars, std::span<const Point2> xy, std::span<const double> z,
                      std::span<const double> spread, std::span<const double> third2,
                      std::span<const unsigned char> asked_nodes) {
  Covered found;
  found.cover.assign(xy.size(), open);
  std::vector<HalfEdge> asked = candidates(stars, z, spread, third2);
  constexpr unsigned char is_asked = 255;
  std::size_t nodes = 0;
  for (const HalfEdge h : asked) {  // each node once
    if (!asked_nodes.empty() && asked_nodes[stars.node(h)] == 0) continue;
    if (std::exchange(found.cover[stars.node(h)], is_asked) != is_asked) asked[nodes++] = h;
  }
  asked.resize(nodes);
  for_blocks(nodes, default_block, [&](std::size_t begin, std::size_t end) {
    Finder finder(stars, xy, z, spread);
    for (std::size_t i = begin; i < end; ++i) found.cover[stars.node(asked[i])] = finder.cover(asked[i]);
  });
  for (const HalfEdge h : asked)
    if (found.cover[stars.node(h)] != open) found.leaving.push_back(h);
  return found;
}

/// f(half-edge) for the nodes within two edges; some more than once, but the neighbours of no node twice: `asked`.
template <class F>
void for_near(const Stars& stars, HalfEdge leaving, std::vector<bool>& asked, F&& f) {
  stars.for_neighbours(leaving, [&](HalfEdge n) {
    f(n);
    if (asked[stars.node(n)]) return;
    asked[stars.node(n)] = true;
    stars.for_neighbours(n, f);
  });
}

/// Rule 4: the nodes of groups that count.
std::vector<HalfEdge> groups_that_count(const Stars& stars, const Covered& of) {
  std::vector<HalfEdge> all;
  std::vector<bool> seen(of.cover.size()), asked(of.cover.size());
  const auto cover = [&](HalfEdge h) { return of.cover[stars.node(h)]; };
  for (const HalfEdge start : of.leaving) {
    if (cover(start) != surely_covered || seen[stars.node(start)]) continue;
    std::vector<HalfEdge> group{start};
    seen[stars.node(start)] = true;
    std::size_t sure = 0;
    for (std::size_t k = 0; k < group.size(); ++k) {
      sure += cover(group[k]) == surely_covered ? 1 : 0;
      const HalfEdge leaving = group[k];
      for_near(stars, leaving, asked, [&](HalfEdge n) {
        if (cover(n) == open || seen[stars.node(n)]) return;
        seen[stars.node(n)] = true;
        group.push_back(n);
      });
    }
    if (sure >= 2) all.insert(all.end(), group.begin(), group.end());
  }
  return all;
}

/// Rule 5, by node: those of the groups and their neighbours; empty if there are none.
Array<unsigned char> nodes_of_folds(const Stars& stars, const Covered& of) {
  const std::vector<HalfEdge> seeds = groups_that_count(stars, of);
  if (seeds.empty()) return {};
  Array<unsigned char> folded(of.cover.size());
  std::fill(folded.begin(), folded.end(), static_cast<unsigned char>(0));
  for (const HalfEdge seed : seeds) {
    folded[stars.node(seed)] = 1;
    stars.for_neighbours(seed, [&](HalfEdge n) { folded[stars.node(n)] = 1; });
  }
  return folded;
}

}  // namespace

Folds find_folds(const Triangulation& t, std::span<const Point2> xy, std::span<const double> z,
                 std::span<const double> spread, const Footprint& footprint, const Context& context,
                 const AskedNodes& asked) {
  context.check();
  const Stars stars(t, footprint);
  const bool known = !footprint.third2.empty();
  const Array<double> own = known ? Array<double>() : squared_third_edges(t, xy);
  const Array<double>& third2 = known ? footprint.third2 : own;
  const Array<unsigned char> node = nodes_of_folds(stars, covered_nodes(stars, xy, z, spread, third2, asked.flags));
  Folds folds;
  if (node.empty()) return folds;
  folds.folded.resize(t.real);
  const FixedScale scale{1, asked.area_bound > 0 ? asked.area_bound : box_of(xy).area()};
  folds.area_sum = reduce_blocks<FixedSum>(
      t.real, default_block,
      [&](std::size_t begin, std::size_t end) {
        FixedSum area(scale);
        for (std::size_t i = begin; i < end; ++i) {
          const std::array<Index, 3> v = from_first_corner(t.triangles[i].v);
          const bool is =
              footprint.keeps(static_cast<Index>(i)) && (node[v[0]] != 0 || node[v[1]] != 0 || node[v[2]] != 0);
          folds.folded[i] = is ? 1 : 0;
          if (is) area.add(triangle_area(xy[v[0]], xy[v[1]], xy[v[2]]));
        }
        return area;
      },
      [](FixedSum& total, const FixedSum& part) { total.add(part); });
  folds.area = folds.area_sum.value();
  return folds;
}

Array<unsigned char> nodes_covered(const Triangulation& t, std::span<const Point2> xy, std::span<const double> z,
                                   std::span<const double> spread, const AskedNodes& asked, const Context& context) {
  context.check();
  const Footprint whole;
  const Stars stars(t, whole);
  Covered found = covered_nodes(stars, xy, z, spread, squared_third_edges(t, xy), asked.flags);
  return std::move(found.cover);
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
