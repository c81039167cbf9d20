#include "isopach/distance/surface_tree.hpp"

#include <algorithm>
#include <numeric>

#include "isopach/base/parallel.hpp"
#include "isopach/distance/vectors.hpp"

namespace isopach {
namespace {

constexpr std::size_t leaf_size = 4;
constexpr std::size_t parallel_size = 8192, turning_block = 16;
constexpr int deepest = 64;
// Boxes are said to overlap where a place on the surface lies in more leaves than this, on the average of some places;
// in ordinary meshes it is 3 to 5. No place is counted beyond `most_leaves`.
constexpr std::size_t overlap_places = 256, many_leaves = 16, most_leaves = 4096;
constexpr double worth = 0.5;  // a turned box is kept where its area is this share of the plain one's, or less
// Squared sine of a corner, below which rounding of the normal would be seen in the foot, and below which there is no
// normal at all.
constexpr double thin = 1e-6, flat = 1e-26;

ClosestPoint at(const Point3& p, const Point3& q) { return {q, squared_length(p - q)}; }

ClosestPoint closest_on_segment(const Point3& p, const Point3& a, const Point3& b) {
  const Point3 ab = b - a;
  const double length2 = squared_length(ab);
  // From the nearer end, so that a foot near b is as accurate as one near a.
  if (const double s = dot(p - a, ab); !(s > 0) || length2 == 0)
    return at(p, a);
  else if (2 * s <= length2)
    return at(p, a + (s / length2) * ab);
  const double s = dot(b - p, ab);
  return s > 0 ? at(p, b - (s / length2) * ab) : at(p, b);
}

ClosestPoint closest_on_border(const Point3& p, const std::array<Point3, 3>& c) {
  ClosestPoint best;
  for (std::size_t k = 0; k < 3; ++k) {
    const ClosestPoint q = closest_on_segment(p, c[k], c[(k + 1) % 3]);
    if (q.distance2 < best.distance2) best = q;
  }
  return best;
}

double component(const Point3& p, int axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }

double distance2_to_box(const Point3& p, const Box3& box) {
  const double x = std::max({box.min.x - p.x, 0.0, p.x - box.max.x});
  const double y = std::max({box.min.y - p.y, 0.0, p.y - box.max.y});
  const double z = std::max({box.min.z - p.z, 0.0, p.z - box.max.z});
  return x * x + y * y + z * z;
}

/// Smallest |t| at which the line is in the box; infinity if it never is.
double line_to_box(const Point3& p, const Point3& d, const Box3& box) {
  constexpr double never = std::numeric_limits<double>::infinity();
  double low = -never, high = never;
  for (int axis = 0; axis < 3; ++axis) {
    const double from = component(box.min, axis) - component(p, axis),
                 to = component(box.max, axis) - component(p, axis);
    const double s = component(d, axis);
    if (s == 0) {
      if (from > 0 || to < 0) return never;
      continue;
    }
    low = std::max(low, std::min(from / s, to / s));
    high = std::min(high, std::max(from / s, to / s));
  }
  if (low > high) return never;
  return low > 0 ? low : high < 0 ? -high : 0;
}

/// The line turned upright by a shear: what is constant for all triangles.
class UprightLine {
 public:
  UprightLine(const Point3& p, const Point3& d) : p_(p) {
    const double x = std::fabs(d.x), y = std::fabs(d.y), z = std::fabs(d.z);
    w_ = z >= x && z >= y ? 2 : y >= x ? 1 : 0;
    u_ = (w_ + 1) % 3, v_ = (w_ + 2) % 3;
    const double along = component(d, w_);
    shear_u_ = component(d, u_) / along, shear_v_ = component(d, v_) / along, scale_ = 1 / along;
  }
  /// t of the crossing; infinity if there is none.
  [[nodiscard]] double cross(const std::array<Point3, 3>& corners) const {
    double x[3], y[3], z[3];
    for (std::size_t k = 0; k < 3; ++k) {
      const Point3 q = corners[k] - p_;
      z[k] = component(q, w_);
      x[k] = component(q, u_) - shear_u_ * z[k];
      y[k] = component(q, v_) - shear_v_ * z[k];
    }
    const double a = x[2] * y[1] - y[2] * x[1], b = x[0] * y[2] - y[0] * x[2], c = x[1] * y[0] - y[1] * x[0];
    const double sum = a + b + c;
    if (((a < 0 || b < 0 || c < 0) && (a > 0 || b > 0 || c > 0)) || sum == 0)
      return std::numeric_limits<double>::infinity();
    return (a / sum * z[0] + b / sum * z[1] + c / sum * z[2]) * scale_;
  }

 private:
  Point3 p_;
  int u_, v_, w_;
  double shear_u_, shear_v_, scale_;
};

/// Nodes still to be visited. `bound(node)` is the least its boxes can hold; nearer children first.
template <class Bound, class Search>
void visit(int levels, Bound&& bound, Search& leaf) {
  struct Entry {
    std::size_t node;
    int level;
    double least;
  };
  Entry stack[deepest + 2];
  int top = 0;
  stack[top++] = {0, 0, bound(0)};
  while (top > 0) {
    const Entry e = stack[--top];
    if (!leaf.wants(e.least)) continue;
    if (e.level == levels) {
      leaf.look(e.node, e.level);
      continue;
    }
    Entry near{2 * e.node + 1, e.level + 1, bound(2 * e.node + 1)};
    Entry far{2 * e.node + 2, e.level + 1, bound(2 * e.node + 2)};
    if (far.least < near.least) std::swap(near, far);
    stack[top++] = far;
    stack[top++] = near;
  }
}

}  // namespace

ClosestPoint closest_on_triangle(const Point3& p, const std::array<Point3, 3>& c) {
  const Point3 ab = c[1] - c[0], ac = c[2] - c[0], ap = p - c[0];
  const Point3 n = cross(ab, ac);
  const double n2 = squared_length(n), size = squared_length(ab) * squared_length(ac);
  if (!(n2 > flat * size)) return closest_on_border(p, c);
  const double v = dot(cross(ap, ac), n), w = dot(cross(ab, ap), n), u = dot(cross(c[2] - c[1], p - c[1]), n);
  if (u < 0 || v < 0 || w < 0) return closest_on_border(p, c);
  Point3 q = c[0] + (v / n2) * ab + (w / n2) * ac;
  if (n2 > thin * size) return at(p, q);
  const Point3 rest = p - q;  // the same step again takes back what rounding did to a thin triangle
  q = q + (dot(cross(rest, ac), n) / n2) * ab + (dot(cross(ab, rest), n) / n2) * ac;
  const ClosestPoint inside = at(p, q), border = closest_on_border(p, c);
  return inside.distance2 < border.distance2 ? inside : border;
}

SurfaceTree::SurfaceTree(const Mesh& mesh) : mesh_(mesh) {
  const std::size_t n = mesh.faces.size();
  while ((leaf_size << levels_) < n) ++levels_;
  order_.resize(n);
  std::iota(order_.begin(), order_.end(), Index{0});
  Array<Point3> centres(n);
  for_each_index(n, [&](std::size_t i) {
    const auto c = mesh.corners(i);
    centres[i] = c[0] + c[1] + c[2];
  });
  boxes_.resize((std::size_t{2} << levels_) - 1);
  build(0, 0, centres);
  corners_.resize(n);
  for_each_index(n, [&](std::size_t i) { corners_[i] = mesh.corners(order_[i]); });
  if (const std::size_t plain = overlap<false>(); plain > many_leaves * overlap_places) {
    turn_boxes();
    if (overlap<true>() > plain / 2) turned_of_.clear(), turned_.clear();  // they are no help
  }
}

SurfaceTree::Range SurfaceTree::range(std::size_t node, int level) const {
  const std::size_t place = node + 1 - (std::size_t{1} << level), n = order_.size();
  // n·place may not overflow: split n into whole shares and the rest.
  const std::size_t whole = n >> level, rest = n & ((std::size_t{1} << level) - 1);
  const auto begin = [&](std::size_t i) { return whole * i + ((rest * i) >> level); };
  return {begin(place), begin(place + 1)};
}

Box3 SurfaceTree::leaf_box(const Range& r) const {
  Box3 box;
  double largest = 0;
  for (std::size_t i = r.begin; i < r.end; ++i)
    for (const Point3& p : mesh_.corners(order_[i])) {
      box.add(p);
      largest = std::max({largest, std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
    }
  const double pad = 8 * std::numeric_limits<double>::epsilon() * largest;  // rounding in line_to_box
  box.min = box.min - Point3{pad, pad, pad};
  box.max = box.max + Point3{pad, pad, pad};
  return box;
}

Box3 SurfaceTree::build(std::size_t node, int level, const Array<Point3>& centres) {
  const Range r = range(node, level);
  if (level == levels_) return boxes_[node] = leaf_box(r);
  Box3 spread;
  for (std::size_t i = r.begin; i < r.end; ++i) spread.add(centres[order_[i]]);
  const Point3 side = spread.max - spread.min;
  const int axis = side.x >= side.y && side.x >= side.z ? 0 : side.y >= side.z ? 1 : 2;
  const auto place = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(place(r.begin), place(range(2 * node + 1, level + 1).end), place(r.end), [&](Index i, Index j) {
    const double a = component(centres[i], axis), b = component(centres[j], axis);
    return a < b || (a == b && i < j);
  });
  Box3 left, right;
  const auto build_left = [&] { left = build(2 * node + 1, level + 1, centres); };
  const auto build_right = [&] { right = build(2 * node + 2, level + 1, centres); };
  if (r.end - r.begin > parallel_size)
    both(build_left, build_right);
  else
    build_left(), build_right();
  left.add(right);
  return boxes_[node] = left;
}

/// Counts for some places of the surface how many leaves have them in their boxes.
template <bool turned>
std::size_t SurfaceTree::overlap() const {
  struct Search {
    std::size_t leaves = 0;
    [[nodiscard]] bool wants(double least) const { return least <= 0 && leaves < most_leaves; }
    void look(std::size_t, int) { ++leaves; }
  };
  const std::size_t places = std::min(overlap_places, corners_.size());
  std::size_t all = 0;
  for (std::size_t i = 0; i < places; ++i) {
    const auto& c = corners_[corners_.size() / places * i];
    const Point3 middle = (1.0 / 3) * (c[0] + c[1] + c[2]);
    const auto bound = [&](std::size_t node) {
      const double plain = distance2_to_box(middle, boxes_[node]);
      return turned && plain <= 0 && turned_of_[node] != no_index ? turned_[turned_of_[node]].bound(middle).distance2
                                                                  : plain;
    };
    Search search;
    visit(levels_, bound, search);
    all += search.leaves;
  }
  return all * (overlap_places / places);
}

void SurfaceTree::turn_boxes() {
  turned_of_.resize(boxes_.size());
  std::vector<TurnedNode> of_level;
  for (int level = 0; level <= levels_; ++level) {
    const std::size_t first = (std::size_t{1} << level) - 1;
    of_level.resize(first + 1);
    for_blocks(of_level.size(), turning_block, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const Range r = range(first + i, level);
        const auto first_face = order_.begin() + static_cast<std::ptrdiff_t>(r.begin);
        of_level[i] = {TurnedBox({corners_.data() + r.begin, r.end - r.begin}),
                       *std::min_element(first_face, first_face + static_cast<std::ptrdiff_t>(r.end - r.begin))};
      }
    });
    for (std::size_t i = 0; i < of_level.size(); ++i) {
      const bool kept = of_level[i].is_fan() || of_level[i].area() <= worth * area_of(boxes_[first + i]);
      turned_of_[first + i] = kept ? static_cast<Index>(turned_.size()) : no_index;
      if (kept) turned_.push_back(of_level[i]);
    }
  }
}

template <bool turned, class Count>
Closest SurfaceTree::search_closest(const Point3& p, Count& count) const {
  struct Search {
    const SurfaceTree& tree;
    const Point3& p;
    Count& count;
    Closest best;
    [[nodiscard]] bool wants(double least) const { return least <= best.at.distance2; }
    void look(std::size_t node, int level) {
      const Range r = tree.range(node, level);
      for (std::size_t i = r.begin; i < r.end; ++i) {
        count.triangle();
        offer(closest_on_triangle(p, tree.corners_[i]), tree.order_[i]);
      }
    }
    void offer(const ClosestPoint& q, Index face) {
      if (q.distance2 < best.at.distance2 || (q.distance2 == best.at.distance2 && face < best.face)) best = {q, face};
    }
  } search{*this, p, count, {}};
  const auto bound = [&](std::size_t node) {
    count.box();
    const double plain = distance2_to_box(p, boxes_[node]);
    if constexpr (turned)
      if (search.wants(plain) && turned_of_[node] != no_index) {
        const TurnedNode& box = turned_[turned_of_[node]];
        const TurnedBox::Bound least = box.bound(p);
        if (!least.at_tip) return std::max(plain, least.distance2);
        search.offer(at(p, box.tip()), box.least);
        return std::numeric_limits<double>::infinity();
      }
    return plain;
  };
  visit(levels_, bound, search);
  return search.best;
}

Closest SurfaceTree::closest(const Point3& p) const {
  struct {
    void box() {}
    void triangle() {}
  } none;
  return turned_.empty() ? search_closest<false>(p, none) : search_closest<true>(p, none);
}

Closest SurfaceTree::closest(const Point3& p, SearchCounts& counts) const {
  struct {
    SearchCounts& counts;
    void box() { ++counts.boxes; }
    void triangle() { ++counts.triangles; }
  } count{counts};
  return turned_.empty() ? search_closest<false>(p, count) : search_closest<true>(p, count);
}

template <bool turned>
Crossing SurfaceTree::search_crossing(const Point3& p, const Point3& direction) const {
  struct Search {
    const SurfaceTree& tree;
    UprightLine line;
    Crossing best;
    [[nodiscard]] bool wants(double least) const {
      return std::isfinite(least) && least <= std::fabs(best.t) * (1 + 1e-12);
    }
    void look(std::size_t node, int level) {
      const Range r = tree.range(node, level);
      for (std::size_t i = r.begin; i < r.end; ++i) {
        const double t = line.cross(tree.corners_[i]);
        const Index face = tree.order_[i];
        const double less = std::fabs(best.t) - std::fabs(t);
        if (std::isfinite(t) && (less > 0 || (less == 0 && face < best.face))) best = {t, face};
      }
    }
  } search{*this, UprightLine(p, direction), {}};
  const auto bound = [&](std::size_t node) {
    const double plain = line_to_box(p, direction, boxes_[node]);
    if constexpr (turned)
      if (search.wants(plain) && turned_of_[node] != no_index) {
        const TurnedBox::Line line = turned_[turned_of_[node]].turned(p, direction);
        return std::max(plain, line_to_box(line.p, line.direction, line.box));
      }
    return plain;
  };
  visit(levels_, bound, search);
  return search.best;
}

Crossing SurfaceTree::cross(const Point3& p, const Point3& direction) const {
  return turned_.empty() ? search_crossing<false>(p, direction) : search_crossing<true>(p, direction);
}

}  // namespace isopach
