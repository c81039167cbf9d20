#include "isopach/measure/volume/detail.hpp"

#include <algorithm>
#include <cmath>

#include "isopach/base/fixed_sum.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/measure/measures.hpp"
#include "isopach/measure/source.hpp"
#include "isopach/measure/volume/totals.hpp"

namespace isopach {

namespace {

using Kind = Location::Kind;

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

double area_of(const OverlayMesh& m, std::size_t triangle) {
  const std::array<Index, 3> v = from_first_corner(m.t.triangles[triangle].v);
  return std::max(0.0, triangle_area(m.xy[v[0]], m.xy[v[1]], m.xy[v[2]]));
}

double area_per_node(const OverlayMesh& m, const FixedScale& scale) {
  const FixedSum area = reduce_blocks<FixedSum>(
      m.t.real, default_block,
      [&](std::size_t begin, std::size_t end) {
        FixedSum part(scale);
        for (std::size_t i = begin; i < end; ++i)
          if (is_kept(m, static_cast<Index>(i))) part.add(area_of(m, i));
        return part;
      },
      [](FixedSum& total, const FixedSum& part) { total.add(part); });
  return m.xy.empty() ? 0 : area.value() / static_cast<double>(m.xy.size());
}

/// A third of the area of the kept triangles at each node.
Array<double> node_areas(const OverlayMesh& m, const FixedScale& scale) {
  std::vector<FixedSum> sums(m.xy.size(), FixedSum(scale));
  for (Index i = 0; i < m.t.real; ++i) {
    if (!is_kept(m, i)) continue;
    const double third = area_of(m, i) / 3;
    for (const Index node : m.t.triangles[i].v) sums[node].add(third);
  }
  Array<double> w(m.xy.size());
  for_each_index(w.size(), [&](std::size_t i) { w[i] = sums[i].value(); });
  return w;
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

struct Gathered {
  Sum weight, difference;
};

/// For each triangle of the coarser mesh the weights, and weighted differences fine − coarse, of the nodes in it. In
/// the order of the nodes, one after the other: a triangle may hold any number of them.
std::vector<Gathered> gather(const OverlayMesh& coarse, const OverlayMesh& fine, const Array<double>& weight) {
  std::vector<Gathered> found(coarse.t.real);
  const Touching touching(coarse, fine.in_other);
  for (std::size_t q = 0; q < fine.xy.size(); ++q) {
    if (!(weight[q] > 0)) continue;
    const Location at = fine.in_other[q];
    const Index count = touching.visit(at, [](Index) {});
    if (count == 0) continue;
    const double share = weight[q] / static_cast<double>(count);
    const double difference = fine.z[q] - fine.other_z[q];
    touching.visit(at, [&](Index t) {
      found[t].weight.add(share);
      found[t].difference.add(share * difference);
    });
  }
  return found;
}

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

struct DetailSums {
  FixedSum area, signed_sum, size_sum;
  Index averaged = 0, bare = 0;

  DetailSums() = default;
  explicit DetailSums(const SumScales& scales)
      : area(scales.area), signed_sum(scales.volume), size_sum(scales.volume) {}
};

void combine(DetailSums& total, const DetailSums& part) {
  total.area.add(part.area);
  total.signed_sum.add(part.signed_sum);
  total.size_sum.add(part.size_sum);
  total.averaged += part.averaged;
  total.bare += part.bare;
}

double area_inside(const OverlayMesh& m, std::size_t triangle, const Domain& domain, Domain::Scratch& scratch) {
  ConvexCell cell;
  for (const Index v : from_first_corner(m.t.triangles[triangle].v)) cell.add({m.xy[v].x, m.xy[v].y, 0, 0});
  double area = 0;
  domain.for_pieces(cell, scratch, [&](const ConvexCell& piece) { area += piece.area(); });
  return area;
}

DetailSums add_up(const OverlayMesh& coarse, const std::vector<Gathered>& gathered, const Array<unsigned char>& known,
                  const Domain& domain, const SumScales& scales) {
  return reduce_blocks<DetailSums>(
      coarse.t.real, default_block,
      [&](std::size_t begin, std::size_t end) {
        DetailSums part(scales);
        Domain::Scratch scratch;
        for (std::size_t i = begin; i < end; ++i) {
          const std::array<Index, 3> v = from_first_corner(coarse.t.triangles[i].v);
          if (!is_kept(coarse, static_cast<Index>(i)) || (known[v[0]] & known[v[1]] & known[v[2]]) == 0) continue;
          const auto at = [&](Index node) { return coarse.other_z[node] - coarse.z[node]; };
          const double area = domain.is_everything() ? area_of(coarse, i) : area_inside(coarse, i, domain, scratch);
          if (!domain.is_everything() && !(area > 0)) continue;
          const double weight = gathered[i].weight.value();
          const bool is_bare = !(weight > 0);
          const double delta = is_bare ? (at(v[0]) + at(v[1]) + at(v[2])) / 3 : gathered[i].difference.value() / weight;
          part.area.add(area);
          part.signed_sum.add(area * delta);
          part.size_sum.add(area * std::fabs(delta));
          ++(is_bare ? part.bare : part.averaged);
        }
        return part;
      },
      combine);
}

}  // namespace

std::optional<DetailMeasure> detail_measure(const OverlayMesh& a, const OverlayMesh& b, bool extrapolate,
                                            const Domain& domain, const Context& context) {
  context.check();
  const SumScales scales(bounds_of_both(a, b));
  DetailMeasure m;
  m.coarser_is_b = area_per_node(b, scales.area) > area_per_node(a, scales.area);
  const OverlayMesh& coarse = m.coarser_is_b ? b : a;
  const OverlayMesh& fine = m.coarser_is_b ? a : b;
  const Array<double> weight = node_areas(fine, scales.area);
  std::vector<Gathered> gathered;
  Array<unsigned char> known;
  both([&] { gathered = gather(coarse, fine, weight); },
       [&] { known = known_nodes(coarse, fine, weight, extrapolate); });
  const DetailSums total = add_up(coarse, gathered, known, domain, scales);
  m.area = total.area.value();
  if (!(m.area > 0)) return std::nullopt;
  m.rho = total.size_sum.value() / m.area;
  m.mean = (m.coarser_is_b ? -1 : 1) * total.signed_sum.value() / m.area;
  m.averaged = total.averaged;
  m.bare = total.bare;
  return m;
}

}  // namespace isopach
