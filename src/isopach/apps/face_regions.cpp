#include "isopach/apps/face_regions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/measure/source.hpp"

namespace isopach {
namespace {

struct Strip {
  std::string name;
  double low, high;  // of y
};

Box2 box_of(const CellView& cells) {
  return reduce_blocks<Box2>(
      items_of(cells), default_block,
      [&](std::size_t begin, std::size_t end) {
        Box2 box;
        for_convex(cells, begin, end, [&](const ConvexCell& cell) { box.add(cell.box()); });
        return box;
      },
      [](Box2& left, const Box2& right) { left.add(right); });
}

std::vector<Strip> strips_of(const CellView& cells, FaceParts parts) {
  constexpr double far = std::numeric_limits<double>::infinity();
  const Box2 box = box_of(cells);
  const auto level = [&](double share) { return box.min.y + share * (box.max.y - box.min.y); };
  std::vector<Strip> strips{{"whole", -far, far}};
  if (parts == FaceParts::halves) {
    strips.push_back({"upper half", level(0.5), far});
    strips.push_back({"lower half", -far, level(0.5)});
  } else {
    strips.push_back({"upper third", level(2.0 / 3), far});
    strips.push_back({"middle third", level(1.0 / 3), level(2.0 / 3)});
    strips.push_back({"lower third", -far, level(1.0 / 3)});
  }
  return strips;
}

struct Sums {
  Sum area, above, below, squares;
  double largest = 0;

  void add(const ConvexCell& piece) {
    for_triangles(piece, [&](double part, const Corner& p, const Corner& q, const Corner& r) {
      add(Cell{part, {p.d(), q.d(), r.d()}});
    });
  }
  void add(const Cell& cell) {
    const Parts parts = split_volume(cell);
    const auto [a, b, c] = cell.d;
    area.add(cell.area), above.add(parts.above), below.add(parts.below);
    squares.add(cell.area / 12 * ((a + b + c) * (a + b + c) + a * a + b * b + c * c));
    largest = std::max({largest, std::fabs(a), std::fabs(b), std::fabs(c)});
  }
  void add(const Sums& other) {
    area.add(other.area), above.add(other.above), below.add(other.below), squares.add(other.squares);
    largest = std::max(largest, other.largest);
  }
};

/// A triangle with what is linear on it, at its three corners.
struct Triple {
  double a, b, c;
  /// `u` and `v`: shares of the second and the third corner. At a corner the value there, to the last bit.
  [[nodiscard]] double at(double u, double v) const { return (1 - u - v) * a + u * b + v * c; }
};

/// A part of a triangle as a convex polygon: z1 and z2 of its corners are the shares u and v, x and y where it is seen.
ConvexCell seen_at(const ConvexCell& part, const Triple& x, const Triple& y) {
  ConvexCell seen;
  double twice_area = 0;
  for (unsigned k = 0; k < part.corners; ++k) {
    const Corner& c = part.at[k];
    seen.add({x.at(c.z1, c.z2), y.at(c.z1, c.z2), c.z1, c.z2});
    if (k < 2) continue;
    const Corner &o = seen.at[0], &p = seen.at[k - 1], &q = seen.at[k];
    twice_area += (p.x - o.x) * (q.y - o.y) - (p.y - o.y) * (q.x - o.x);
  }
  if (twice_area < 0) std::reverse(seen.at.begin(), seen.at.begin() + seen.corners);  // seen in a mirror
  return seen;
}

/// A cell on its way through the polygons.
class MirrorCell {
 public:
  MirrorCell(const CommonCell& of, const FacePolygons& polygons) {
    std::array<Point2, 3> here, there;
    std::array<double, 3> across, d;
    for (std::size_t k = 0; k < 3; ++k) {
      const Corner p = of.corner(k);
      across[k] = p.x + polygons.origin.x;
      here[k] = polygons.seen({p.x, p.y, p.z2});
      there[k] = polygons.seen({-across[k] - polygons.origin.x, p.y, p.z1});
      d[k] = p.d();
    }
    const auto triple = [](const std::array<double, 3>& v) { return Triple{v[0], v[1], v[2]}; };
    d_ = triple(d);
    here_x_ = {here[0].x, here[1].x, here[2].x}, here_y_ = {here[0].y, here[1].y, here[2].y};
    there_x_ = {there[0].x, there[1].x, there[2].x}, there_y_ = {there[0].y, there[1].y, there[2].y};
    area_ = of.cell().area;
    cut_side(triple(across));
  }

  [[nodiscard]] const ConvexCell& positive_side() const { return side_; }

  /// What of the side is seen inside, here or in the mirror.
  void add_within(const Regions& polygon, Regions::Scratch& scratch, std::vector<ConvexCell>& inside,
                  std::vector<ConvexCell>& outside, Sums& sums) const {
    inside.clear(), outside.clear();
    const ConvexCell here = seen_at(side_, here_x_, here_y_);
    const Regions::Answer answer = polygon.split(here, scratch, inside, outside);
    if (answer == Regions::Answer::all) return add(here, sums);
    if (answer == Regions::Answer::none) outside.push_back(here);
    for (const ConvexCell& piece : inside) add(piece, sums);
    const std::vector<ConvexCell> rest = std::move(outside);
    for (const ConvexCell& piece : rest) {
      inside.clear(), outside.clear();
      const ConvexCell there = seen_at(piece, there_x_, there_y_);
      if (polygon.split(there, scratch, inside, outside) == Regions::Answer::all) add(there, sums);
      for (const ConvexCell& part : inside) add(part, sums);
    }
  }

  void add(const ConvexCell& part, Sums& sums) const {
    const auto& at = part.at;
    for (unsigned k = 2; k < part.corners; ++k) {
      const Corner &o = at[0], &p = at[k - 1], &q = at[k];
      const double share = std::fabs((p.z1 - o.z1) * (q.z2 - o.z2) - (p.z2 - o.z2) * (q.z1 - o.z1));
      if (share > 0) sums.add(Cell{share * area_, {d_.at(o.z1, o.z2), d_.at(p.z1, p.z2), d_.at(q.z1, q.z2)}});
    }
  }

 private:
  void cut_side(const Triple& across) {
    const std::array<Corner, 3> corners{{{0, 0, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
    for (std::size_t k = 0; k < 3; ++k) {
      const Corner &p = corners[k], &q = corners[(k + 1) % 3];
      const double xp = across.at(p.z1, p.z2), xq = across.at(q.z1, q.z2);
      if (xp >= 0) side_.add(p);
      if ((xp >= 0) == (xq >= 0)) continue;
      const double t = xp / (xp - xq);
      side_.add({0, 0, p.z1 + t * (q.z1 - p.z1), p.z2 + t * (q.z2 - p.z2)});
    }
  }

  Triple d_{}, here_x_{}, here_y_{}, there_x_{}, there_y_{};
  double area_ = 0;
  ConvexCell side_;
};

SideDifference described(const std::string& name, const Sums& sums) {
  SideDifference r;
  r.name = name;
  r.area = sums.area.value();
  r.volume.above = sums.above.value(), r.volume.below = sums.below.value();
  r.volume.net = r.volume.above - r.volume.below;
  r.volume.absolute = r.volume.above + r.volume.below;
  r.largest = sums.largest;
  if (!(r.area > 0)) return r;
  r.directional = r.volume.net / r.area;
  r.absolute = r.volume.absolute / r.area;
  r.rms = std::sqrt(sums.squares.value() / r.area);
  return r;
}

}  // namespace

std::vector<SideDifference> face_regions(const CellView& cells, FaceParts parts, const Context& context) {
  context.check();
  const std::vector<Strip> strips = strips_of(cells, parts);
  using All = std::vector<Sums>;
  const All sums = reduce_blocks<All>(
      items_of(cells), default_block,
      [&](std::size_t begin, std::size_t end) {
        All part(strips.size());
        for_convex(cells, begin, end, [&](const ConvexCell& cell) {
          const ConvexCell side = cut(cell, [](const Corner& p) { return p.x; });
          if (side.corners == 0) return;
          part[0].add(side);
          for (std::size_t k = 1; k < strips.size(); ++k) {
            const Strip& s = strips[k];
            part[k].add(cut(cut(side, [&](const Corner& p) { return p.y - s.low; }),
                            [&](const Corner& p) { return s.high - p.y; }));
          }
        });
        return part;
      },
      [&](All& total, const All& part) {
        total.resize(strips.size());
        for (std::size_t k = 0; k < part.size(); ++k) total[k].add(part[k]);
      });
  std::vector<SideDifference> regions;
  for (std::size_t k = 0; k < strips.size(); ++k)
    regions.push_back(described(strips[k].name, k < sums.size() ? sums[k] : Sums{}));
  return regions;
}

Point2 FacePolygons::seen(const Point3& p) const {
  const Point3 q{p.x + origin.x, p.y + origin.y, p.z + origin.z};
  const Point3 x = place.axis(0), y = place.axis(1), z = place.axis(2);
  return {x.x * q.x + y.x * q.y + z.x * q.z + place.origin.x, x.y * q.x + y.y * q.y + z.y * q.z + place.origin.y};
}

std::vector<SideDifference> face_regions(const CellView& cells, const FacePolygons& polygons, const Context& context) {
  context.check();
  using All = std::vector<Sums>;
  const std::size_t rows = polygons.regions.size() + 1;
  const All sums = reduce_blocks<All>(
      items_of(cells), default_block,
      [&](std::size_t begin, std::size_t end) {
        All part(rows);
        Regions::Scratch scratch;
        std::vector<ConvexCell> inside, outside;
        for_common(cells, begin, end, [&](const CommonCell& of, std::size_t) {
          const MirrorCell cell(of, polygons);
          if (cell.positive_side().corners == 0) return;
          cell.add(cell.positive_side(), part[0]);
          for (std::size_t k = 1; k < rows; ++k)
            cell.add_within(polygons.regions[k - 1], scratch, inside, outside, part[k]);
        });
        return part;
      },
      [&](All& total, const All& part) {
        total.resize(rows);
        for (std::size_t k = 0; k < part.size(); ++k) total[k].add(part[k]);
      });
  std::vector<SideDifference> regions;
  for (std::size_t k = 0; k < rows; ++k)
    regions.push_back(described(k == 0 ? "whole" : polygons.names[k - 1], k < sums.size() ? sums[k] : Sums{}));
  return regions;
}

}  // namespace isopach
