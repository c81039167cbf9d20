// The overlay as one mesh. A crossing is seen from both outer triangles at its edge, each with its own rounding: the
// one with the lesser index owns it. So the corners are numbered without hashing: nodes of both meshes by their ids,
// then the crossings of each side of each outer triangle in the order of the inner edges.
#include <algorithm>

#include "isopach/base/parallel.hpp"
#include "isopach/overlay/overlay.hpp"

namespace isopach {

namespace {

constexpr std::size_t block = 1 << 10;

struct Crossing {
  HalfEdge inner;  // the lesser one of both half-edges of the inner edge
  Point2 at;
  double z1, z2;
};

// Of one side of one outer triangle, by the inner edge.
struct SideOfTriangle {
  std::size_t begin = 0, end = 0;
};

double area_of(const OverlayCell& c) {
  double twice = 0;
  for (unsigned k = 2; k < c.corners; ++k)
    twice += (c.x[k - 1] - c.x[0]) * (c.y[k] - c.y[0]) - (c.y[k - 1] - c.y[0]) * (c.x[k] - c.x[0]);
  return twice / 2;
}

bool has_area(const OverlayCell& c, unsigned i, unsigned j, unsigned k) {
  return (c.x[j] - c.x[i]) * (c.y[k] - c.y[i]) - (c.y[j] - c.y[i]) * (c.x[k] - c.x[i]) > 0;
}

HalfEdge lesser_twin(const Triangulation& t, HalfEdge h) { return std::min(h, t.twin(h)); }

using SidesOfItem = std::array<std::vector<Crossing>, 3>;

void collect(std::span<const OverlayCell> cells, const Triangulation& inner, SidesOfItem& sides) {
  for (auto& side : sides) side.clear();
  for (const OverlayCell& c : cells)
    for (unsigned k = 0; k < c.corners; ++k)
      if ((c.crossings >> k & 1) != 0)
        sides[c.of[k].outer].push_back(
            {lesser_twin(inner, c.of[k].inner), {c.origin.x + c.x[k], c.origin.y + c.y[k]}, c.z1[k], c.z2[k]});
  for (auto& side : sides) {
    std::sort(side.begin(), side.end(), [](const Crossing& a, const Crossing& b) { return a.inner < b.inner; });
    side.erase(
        std::unique(side.begin(), side.end(), [](const Crossing& a, const Crossing& b) { return a.inner == b.inner; }),
        side.end());
  }
}

struct Block {
  std::vector<Crossing> crossings;
  std::vector<std::array<std::size_t, 3>> counts;  // of each item
};

// Drops vertices of no triangle and numbers the others as the triangles first name them: near each other in the plane,
// near each other in memory.
void compact(OverlaySurface& s) {
  Array<Index> renamed(s.xy.size(), no_index);
  OverlaySurface kept;
  for (auto& triangle : s.triangles)
    for (Index& v : triangle) {
      if (renamed[v] == no_index) {
        renamed[v] = static_cast<Index>(kept.xy.size());
        kept.xy.push_back(s.xy[v]);
        kept.z1.push_back(s.z1[v]);
        kept.z2.push_back(s.z2[v]);
      }
      v = renamed[v];
    }
  kept.triangles = std::move(s.triangles);
  s = std::move(kept);
}

}  // namespace

OverlaySurface Overlay::surface(const Context& context) const {
  context.check();
  const std::size_t n = items();
  std::vector<Block> blocks((n + block - 1) / block);
  for_blocks(n, block, [&](std::size_t begin, std::size_t end) {
    Block& b = blocks[begin / block];
    Scratch scratch;
    SidesOfItem sides;
    for (std::size_t i = begin; i < end; ++i) {
      collect(cells(i, scratch), inner_.t, sides);
      b.counts.push_back({sides[0].size(), sides[1].size(), sides[2].size()});
      for (const auto& side : sides) b.crossings.insert(b.crossings.end(), side.begin(), side.end());
    }
  });

  const std::size_t nodes = outer_.xy.size() + inner_.xy.size();
  std::size_t total = nodes;
  for (const Block& b : blocks) total += b.crossings.size();
  if (total > no_index / 2)
    throw InputError("the overlay of the scans has too many corners to be written: leave it out with @no-cells");
  OverlaySurface s;
  s.xy.resize(total), s.z1.resize(total), s.z2.resize(total);
  const auto put_nodes = [&](const OverlayMesh& m, std::size_t first, bool is_second) {
    for_each_index(m.xy.size(), [&](std::size_t i) {
      s.xy[first + i] = m.xy[i];
      (is_second ? s.z2 : s.z1)[first + i] = m.z[i];
      (is_second ? s.z1 : s.z2)[first + i] = m.other_z[i];
    });
  };
  put_nodes(outer_, 0, exchanged_);
  put_nodes(inner_, outer_.xy.size(), !exchanged_);

  Array<SideOfTriangle> sides(3 * std::size_t{outer_.t.real});
  std::fill(sides.begin(), sides.end(), SideOfTriangle{});
  Array<HalfEdge> inner_edge(total - nodes);
  std::size_t next = 0;
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    for (std::size_t i = 0; i < blocks[k].counts.size(); ++i) {
      std::size_t at = next;
      for (std::size_t side = 0; side < 3; ++side) {
        const std::size_t count = blocks[k].counts[i][side];
        // An item without cells may stand for a triangle that has them as another item.
        if (count > 0) sides[3 * std::size_t{outer_of(k * block + i)} + side] = {at, at + count};
        at += count;
      }
      next = at;
    }
    std::size_t at = next - blocks[k].crossings.size();
    for (const Crossing& c : blocks[k].crossings) {
      inner_edge[at] = c.inner;
      s.xy[nodes + at] = c.at;
      s.z1[nodes + at] = c.z1, s.z2[nodes + at] = c.z2;
      ++at;
    }
    blocks[k] = {};
  }

  const auto in_side = [&](HalfEdge outer, HalfEdge inner) {
    const SideOfTriangle& side = sides[3 * std::size_t{triangle_of(outer)} + side_of(outer)];
    const auto begin = inner_edge.begin() + static_cast<std::ptrdiff_t>(side.begin),
               end = inner_edge.begin() + static_cast<std::ptrdiff_t>(side.end);
    const auto found = std::lower_bound(begin, end, inner);
    return found != end && *found == inner ? static_cast<Index>(nodes + (found - inner_edge.begin())) : no_index;
  };
  const auto vertex = [&](const OverlayCell& c, unsigned k, Index t) {
    const OverlayCorner& corner = c.of[k];
    if ((c.crossings >> k & 1) == 0)
      return corner.inner == no_index ? corner.outer : static_cast<Index>(outer_.xy.size() + corner.inner);
    const HalfEdge inner = lesser_twin(inner_.t, corner.inner), here = half_edge(t, corner.outer),
                   there = outer_.t.twin(here);
    if (!outer_.t.is_ghost(triangle_of(there)) && triangle_of(there) < t)
      if (const Index v = in_side(there, inner); v != no_index) return v;
    return in_side(here, inner);
  };
  using Triangles = std::vector<std::array<Index, 3>>;
  std::vector<Triangles> found(blocks.size());
  for_blocks(n, block, [&](std::size_t begin, std::size_t end) {
    Scratch scratch;
    for (std::size_t i = begin; i < end; ++i)
      for (const OverlayCell& c : cells(i, scratch)) {
        if (!(area_of(c) > 0)) continue;
        const Index t = outer_of(i);
        for (unsigned k = 2; k < c.corners; ++k)
          if (has_area(c, 0, k - 1, k))
            found[begin / block].push_back({vertex(c, 0, t), vertex(c, k - 1, t), vertex(c, k, t)});
      }
  });
  for (Triangles& part : found) {
    s.triangles.insert(s.triangles.end(), part.begin(), part.end());
    Triangles().swap(part);
  }
  compact(s);
  return s;
}

}  // namespace isopach
