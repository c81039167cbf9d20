#include "isopach/measure/volume/detail.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "isopach/base/fixed_sum.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/short_sum.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/measure/measures.hpp"
#include "isopach/measure/source.hpp"
#include "isopach/measure/volume/totals.hpp"

namespace isopach {

namespace {

using Kind = Location::Kind;

bool is_asked(std::span<const unsigned char> asked, std::size_t triangle) {
  return asked.empty() || asked[triangle] != 0;
}

bool is_kept(const OverlayMesh& m, Index triangle) {
  return !m.t.is_ghost(triangle) && (m.kept.empty() || m.kept[triangle] != 0);
}

/// Differences are of heights of the one scan and of the other, on whose nodes or between them.
SumBounds bounds_of_both(const OverlayMesh& a, const OverlayMesh& b) {
  Box2 box;
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (const OverlayMesh* m : {&a, &b})
    for (std::size_t i = 0; i < m->xy.size(); ++i)
      box.add(m->xy[i]), low = std::min(low, m->z[i]), high = std::max(high, m->z[i]);
  if (box.empty()) return {};
  return {(box.max.x - box.min.x) * (box.max.y - box.min.y), high - low};
}

[[gnu::always_inline]] inline double area_of(const OverlayMesh& m, std::size_t triangle) {
  const std::array<Index, 3> v = from_first_corner(m.t.triangles[triangle].v);
  return std::max(0.0, triangle_area(m.xy[v[0]], m.xy[v[1]], m.xy[v[2]]));
}

double per_node(const FixedSum& area, std::size_t nodes) {
  return nodes == 0 ? 0 : area.value() / static_cast<double>(nodes);
}

double exact_area_per_node(const OverlayMesh& m, const SumBounds& bounds) {
  return per_node(kept_area(m, bounds, {}), m.xy.size());
}

/// Blocks of the passes that add areas up.
constexpr std::size_t area_block = std::size_t{1} << 15;

/// Areas of the kept triangles, added as they come.
double plain_area(const OverlayMesh& m) {
  return reduce_blocks<double>(
      m.t.real, area_block,
      [&](std::size_t begin, std::size_t end) {
        double part = 0;
        for (std::size_t i = begin; i < end; ++i)
          if (is_kept(m, static_cast<Index>(i))) part += area_of(m, i);
        return part;
      },
      [](double& total, double part) { total += part; });
}

/// Whether b is the coarser of two meshes, by the exact sums of their areas; these are made where plain ones, block by
/// block, do not tell. Summands are positive, so that a plain sum is off by less than one rounding for each addition
/// that a summand takes part in.
bool is_coarser(const OverlayMesh& b, double plain_b, const OverlayMesh& a, double plain_a, const SumBounds& bounds) {
  const auto per_node = [](double area, const OverlayMesh& m) {
    return m.xy.empty() ? 0 : area / static_cast<double>(m.xy.size());
  };
  const auto slack = [](double value, const OverlayMesh& m) {
    return value * 0x1p-52 * static_cast<double>(area_block + m.t.real / area_block + 8);
  };
  const double of_a = per_node(plain_a, a), of_b = per_node(plain_b, b);
  if (of_b - slack(of_b, b) > of_a + slack(of_a, a)) return true;
  if (of_b + slack(of_b, b) < of_a - slack(of_a, a)) return false;
  return exact_area_per_node(b, bounds) > exact_area_per_node(a, bounds);
}

/// The sums of those nodes that short sums are not exact for.
void add_up_again(const OverlayMesh& m, const FixedScale& scale, const Array<ShortSum>& sums, Array<double>& w) {
  std::vector<Index> nodes;
  for (std::size_t i = 0; i < sums.size(); ++i)
    if (!sums[i].is_exact()) nodes.push_back(static_cast<Index>(i));
  if (nodes.empty()) return;
  std::vector<FixedSum> exact(nodes.size(), FixedSum(scale));
  for (Index i = 0; i < m.t.real; ++i) {
    if (!is_kept(m, i)) continue;
    for (const Index node : m.t.triangles[i].v)
      if (!sums[node].is_exact())
        exact[static_cast<std::size_t>(std::lower_bound(nodes.begin(), nodes.end(), node) - nodes.begin())].add(
            area_of(m, i) / 3);
  }
  for (std::size_t k = 0; k < nodes.size(); ++k) w[nodes[k]] = exact[k].value();
}

struct NodeAreas {
  Array<double> at;  // a third of the area of the kept triangles at each node, added exactly
  double plain = 0;  // as plain_area
};

/// Triangles lie in memory as their nodes do, so a block of them writes to a range of nodes of its own and keeps what
/// others get for the end.
NodeAreas node_areas(const OverlayMesh& m, const FixedScale& scale) {
  struct Third {
    Index node;
    double area;
  };
  struct Part {
    std::vector<Third> elsewhere;
    double plain = 0;
  };
  const double least = ShortSum::least_exact(scale);
  Array<ShortSum> sums(m.xy.size());
  const auto first_node = [&](std::size_t triangle) { return triangle * m.xy.size() / m.t.real; };
  const Part all = reduce_blocks<Part>(
      m.t.real, area_block,
      [&](std::size_t begin, std::size_t end) {
        const std::size_t first = first_node(begin), last = first_node(end);
        Part part;
        for (std::size_t i = begin; i < end; ++i) {
          if (!is_kept(m, static_cast<Index>(i))) continue;
          const double area = area_of(m, i), third = area / 3;
          part.plain += area;
          for (const Index node : m.t.triangles[i].v)
            if (node >= first && node < last)
              sums[node].add(third, least);
            else
              part.elsewhere.push_back({node, third});
        }
        return part;
      },
      [](Part& total, const Part& part) {
        total.elsewhere.insert(total.elsewhere.end(), part.elsewhere.begin(), part.elsewhere.end());
        total.plain += part.plain;
      });
  for (const Third& t : all.elsewhere) sums[t.node].add(t.area, least);
  NodeAreas found{Array<double>(m.xy.size()), all.plain};
  for_each_index(found.at.size(), [&](std::size_t i) { found.at[i] = sums[i].value(); });
  add_up_again(m, scale, sums, found.at);
  return found;
}

/// The kept triangles that a located point touches.
class Touching {
 public:
  Touching(const OverlayMesh& m, const Locations& points) : m_(m) {
    if (std::find(points.kind.begin(), points.kind.end(), Kind::node) == points.kind.end()) return;
    leaving_.resize(m.xy.size());  // a half-edge of a real triangle at each node
    for (Index i = 0; i < m.t.real; ++i)
      for (Index k = 0; k < 3; ++k) leaving_[m.t.triangles[i].v[k]] = half_edge(i, k);
  }

  /// f(triangle) for each; gives how many there are.
  template <class F>
  Index visit(const Location& at, F&& f) const {
    Index count = 0;
    const auto meet = [&](Index triangle) {
      if (is_kept(m_, triangle)) f(triangle), ++count;
    };
    if (at.kind == Kind::triangle) meet(at.id);
    if (at.kind == Kind::edge) meet(triangle_of(at.id)), meet(triangle_of(m_.t.twin(at.id)));
    if (at.kind == Kind::node && m_.t.real > 0) {
      const HalfEdge first = leaving_[at.id];
      HalfEdge h = first;
      do {
        meet(triangle_of(h));
        h = m_.t.next_leaving(h);
      } while (h != first);
    }
    return count;
  }

 private:
  const OverlayMesh& m_;
  Array<HalfEdge> leaving_;
};

/// For each triangle of the coarser mesh the nodes of the finer one in it, those without weight left out.
class NodesInside {
 public:
  NodesInside(const OverlayMesh& coarse, const OverlayMesh& fine, const Array<double>& weight)
      : first_(coarse.t.real, no_index), next_(fine.xy.size()) {
    const Touching touching(coarse, fine.in_other);
    for (std::size_t q = fine.xy.size(); q-- > 0;) {  // the last comes first: lists are then in the order of the nodes
      if (!(weight[q] > 0)) continue;
      const Location at = fine.in_other[q];
      if (at.kind == Kind::triangle) {
        next_[q] = std::exchange(first_[at.id], static_cast<Index>(q));
        continue;
      }
      const Index count = touching.visit(at, [](Index) {});
      touching.visit(at, [&](Index t) {
        const Index entry = static_cast<Index>(next_.size() + shared_.size());
        shared_.push_back({static_cast<Index>(q), std::exchange(first_[t], entry), count});
      });
    }
  }

  /// f(node, how many triangles share it), in the order of the nodes.
  template <class F>
  void visit(std::size_t triangle, F&& f) const {
    for (Index entry = first_[triangle]; entry != no_index;) {
      if (entry < next_.size()) {
        f(entry, Index{1});
        entry = next_[entry];
      } else {
        const Shared& s = shared_[entry - next_.size()];
        f(s.node, s.count);
        entry = s.next;
      }
    }
  }

 private:
  struct Shared {  // a node on an edge, or a node, of the coarser mesh: in one of the triangles that touch it
    Index node, next, count;
  };
  Array<Index> first_;  // by triangle: a node, or the number of nodes and an index into shared_
  Array<Index> next_;   // by node
  std::vector<Shared> shared_;
};

/// Whether each node of the coarser mesh lies in a kept triangle of the finer one. A node of both does if it has area
/// there.
Array<unsigned char> known_nodes(const OverlayMesh& coarse, const OverlayMesh& fine, const Array<double>& weight,
                                 bool extrapolate) {
  Array<unsigned char> known(coarse.xy.size());
  for_each_index(known.size(), [&](std::size_t i) {
    const Location at = coarse.in_other[i];
    bool is_known = extrapolate && at.kind != Kind::none;
    if (at.kind == Kind::triangle) is_known |= is_kept(fine, at.id);
    if (at.kind == Kind::edge)
      is_known |= is_kept(fine, triangle_of(at.id)) || is_kept(fine, triangle_of(fine.t.twin(at.id)));
    if (at.kind == Kind::node) is_known |= weight[at.id] > 0;
    known[i] = is_known ? 1 : 0;
  });
  return known;
}

double area_inside(const OverlayMesh& m, std::size_t triangle, const Domain& domain, Domain::Scratch& scratch) {
  ConvexCell cell;
  for (const Index v : from_first_corner(m.t.triangles[triangle].v)) cell.add({m.xy[v].x, m.xy[v].y, 0, 0});
  double area = 0;
  domain.for_pieces(cell, scratch, [&](const ConvexCell& piece) { area += piece.area(); });
  return area;
}

/// δ of a triangle that holds nodes of the finer mesh; nothing if it does not.
std::optional<double> mean_inside(const OverlayMesh& fine, const NodesInside& nodes, const Array<double>& weight,
                                  std::size_t triangle) {
  Sum all, difference;  // one after the other: a triangle may hold any number of them
  nodes.visit(triangle, [&](Index q, Index count) {
    const double share = weight[q] / static_cast<double>(count);
    all.add(share);
    difference.add(share * (fine.z[q] - fine.other_z[q]));
  });
  if (!(all.value() > 0)) return std::nullopt;
  return difference.value() / all.value();
}

/// Both meshes and what is known of their nodes.
struct Scene {
  const OverlayMesh &coarse, &fine;
  const Array<double>& weight;  // of the finer mesh's nodes
  const NodesInside& nodes;
  const Array<unsigned char>& known;  // of the coarser mesh's
};

DetailSums add_up(const Scene& s, const DetailRule& rule) {
  const OverlayMesh& coarse = s.coarse;
  const Domain& domain = rule.domain;
  return reduce_blocks<DetailSums>(
      coarse.t.real, default_block,
      [&](std::size_t begin, std::size_t end) {
        DetailSums part(rule.bounds);
        Domain::Scratch scratch;
        for (std::size_t i = begin; i < end; ++i) {
          const std::array<Index, 3> v = from_first_corner(coarse.t.triangles[i].v);
          if (!is_asked(rule.asked, i) || !is_kept(coarse, static_cast<Index>(i)) ||
              (s.known[v[0]] & s.known[v[1]] & s.known[v[2]]) == 0)
            continue;
          const auto at = [&](Index node) { return coarse.other_z[node] - coarse.z[node]; };
          const double area = domain.is_everything() ? area_of(coarse, i) : area_inside(coarse, i, domain, scratch);
          if (!domain.is_everything() && !(area > 0)) continue;
          const std::optional<double> mean = mean_inside(s.fine, s.nodes, s.weight, i);
          part.add(area, mean ? *mean : (at(v[0]) + at(v[1]) + at(v[2])) / 3);
          ++(mean ? part.averaged : part.bare);
        }
        return part;
      },
      [](DetailSums& total, const DetailSums& part) { total.add(part); });
}

/// With the areas at the nodes of the finer mesh.
DetailSums sums_with(const OverlayMesh& coarse, const OverlayMesh& fine, const Array<double>& weight,
                     const DetailRule& rule) {
  std::optional<NodesInside> nodes;
  Array<unsigned char> known;
  both([&] { nodes.emplace(coarse, fine, weight); },
       [&] { known = known_nodes(coarse, fine, weight, rule.extrapolate); });
  return add_up({coarse, fine, weight, *nodes, known}, rule);
}

std::optional<DetailMeasure> measure_of(bool coarser_is_b, const DetailSums& all) {
  DetailMeasure m;
  m.coarser_is_b = coarser_is_b;
  m.area = all.area.value();
  if (!(m.area > 0)) return std::nullopt;
  m.rho = total(all.above, all.below) / m.area;
  m.mean = (coarser_is_b ? -1 : 1) * difference(all.above, all.below) / m.area;
  m.averaged = all.averaged;
  m.bare = all.bare;
  return m;
}

}  // namespace

DetailSums::DetailSums(const SumBounds& bounds) {
  const SumScales scales(bounds);
  area = FixedSum(scales.area), above = below = FixedSum(scales.volume);
}

void DetailSums::add(double of_triangle, double delta) {
  area.add(of_triangle);
  if (delta >= 0)
    above.add(of_triangle * delta);
  else
    below.add(of_triangle * -delta);
}

void DetailSums::add(const DetailSums& part) {
  area.add(part.area);
  above.add(part.above);
  below.add(part.below);
  averaged += part.averaged;
  bare += part.bare;
}

FixedSum kept_area(const OverlayMesh& m, const SumBounds& bounds, std::span<const unsigned char> asked) {
  const FixedScale scale = SumScales(bounds).area;
  return reduce_blocks<FixedSum>(
      m.t.real, default_block,
      [&](std::size_t begin, std::size_t end) {
        FixedSum part(scale);
        for (std::size_t i = begin; i < end; ++i)
          if (is_asked(asked, i) && is_kept(m, static_cast<Index>(i))) part.add(area_of(m, i));
        return part;
      },
      [](FixedSum& total, const FixedSum& part) { total.add(part); });
}

DetailSums detail_sums(const OverlayMesh& coarse, const OverlayMesh& fine, const DetailRule& rule,
                       const Context& context) {
  context.check();
  return sums_with(coarse, fine, node_areas(fine, SumScales(rule.bounds).area).at, rule);
}

std::optional<DetailMeasure> detail_of(const DetailOfScan& a, const DetailOfScan& b) {
  const bool coarser_is_b = per_node(b.area, b.nodes) > per_node(a.area, a.nodes);
  return measure_of(coarser_is_b, (coarser_is_b ? b : a).as_coarser);
}

std::optional<DetailMeasure> detail_measure(const OverlayMesh& a, const OverlayMesh& b, bool extrapolate,
                                            const Domain& domain, const Context& context,
                                            const std::optional<SumBounds>& bounds) {
  context.check();
  const DetailRule rule{extrapolate, domain, bounds ? *bounds : bounds_of_both(a, b), {}};
  const FixedScale scale = SumScales(rule.bounds).area;
  // The areas at the nodes of the finer mesh are wanted, and tell which one it is: most often the one of more nodes.
  const bool more_in_b = b.xy.size() > a.xy.size();
  NodeAreas areas = node_areas(more_in_b ? b : a, scale);
  const double plain_other = plain_area(more_in_b ? a : b);
  const bool coarser_is_b = more_in_b ? is_coarser(b, areas.plain, a, plain_other, rule.bounds)
                                      : is_coarser(b, plain_other, a, areas.plain, rule.bounds);
  const OverlayMesh& coarse = coarser_is_b ? b : a;
  const OverlayMesh& fine = coarser_is_b ? a : b;
  if (coarser_is_b == more_in_b) areas = node_areas(fine, scale);
  return measure_of(coarser_is_b, sums_with(coarse, fine, areas.at, rule));
}

}  // namespace isopach
