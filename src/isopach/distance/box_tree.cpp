#include "isopach/distance/box_tree.hpp"

#include <algorithm>

#include "isopach/base/parallel.hpp"

namespace isopach {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::size_t nowhere = std::numeric_limits<std::size_t>::max();

struct BestTwo {
  BoxTree::Two two;
  /// Whether points so far away, of this index or a larger one, change nothing.
  [[nodiscard]] bool is_past(double d, std::size_t i) const {
    return !(d < two.second2 || (d == two.second2 && i < two.second));
  }
  void add(double d, Index i) {
    if (d < two.first2 || (d == two.first2 && i < two.first)) {
      two.second = two.first, two.second2 = two.first2;
      two.first = i, two.first2 = d;
    } else {
      two.second = i, two.second2 = d;
    }
  }
};

}  // namespace

BoxTree::BoxTree(std::span<const Point3> points) : size_(points.size()), leaves_((size_ + width - 1) / width) {
  // Places beyond the last are infinitely far, in boxes that nothing is near to.
  for_each_index(leaves_.size(), [&](std::size_t leaf) {
    for (std::size_t k = 0; k < width; ++k) {
      const std::size_t i = leaf * width + k;
      const Point3 p = i < size_ ? points[i] : Point3{infinity, infinity, infinity};
      leaves_[leaf].x[k] = p.x, leaves_[leaf].y[k] = p.y, leaves_[leaf].z[k] = p.z;
    }
  });
  const auto of_leaf = [&](std::size_t leaf, Boxes& into, std::size_t k) {
    const double* values[3] = {leaves_[leaf].x, leaves_[leaf].y, leaves_[leaf].z};
    const std::size_t count = std::min(width, size_ - leaf * width);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      into.low[axis][k] = *std::min_element(values[axis], values[axis] + count);
      into.high[axis][k] = *std::max_element(values[axis], values[axis] + count);
    }
  };
  const auto of_boxes = [](const Boxes& from, Boxes& into, std::size_t k) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      into.low[axis][k] = *std::min_element(from.low[axis], from.low[axis] + width);
      into.high[axis][k] = *std::max_element(from.high[axis], from.high[axis] + width);
    }
  };
  for (std::size_t below = leaves_.size(); below > 0 && (levels_.empty() || below > 1);) {
    Array<Boxes> level((below + width - 1) / width);
    for_each_index(level.size(), [&](std::size_t node) {
      for (std::size_t k = 0; k < width; ++k) {
        const std::size_t child = node * width + k;
        if (child >= below)
          for (std::size_t axis = 0; axis < 3; ++axis)
            level[node].low[axis][k] = infinity, level[node].high[axis][k] = -infinity;
        else if (levels_.empty())
          of_leaf(child, level[node], k);
        else
          of_boxes(levels_.back()[child], level[node], k);
      }
    });
    below = level.size();
    levels_.push_back(std::move(level));
  }
}

template <class Best>
void BoxTree::look_in(const Point3& p, std::size_t leaf, Best& best) const {
  const Leaf& l = leaves_[leaf];
  double d[width];
  for (std::size_t k = 0; k < width; ++k) {
    const double x = p.x - l.x[k], y = p.y - l.y[k], z = p.z - l.z[k];
    d[k] = x * x + y * y + z * z;
  }
  const std::size_t count = std::min(width, size_ - leaf * width);
  for (std::size_t k = 0; k < count; ++k)
    if (!best.is_past(d[k], leaf * width + k)) best.add(d[k], static_cast<Index>(leaf * width + k));
}

/// Nearest boxes first. Rounding is monotone, so a box is never farther than what is in it, in doubles either.
template <class Best>
void BoxTree::descend(const Point3& p, std::size_t level, std::size_t node, std::size_t known, Best& best) const {
  const Boxes& b = levels_[level][node];
  const double place[3] = {p.x, p.y, p.z};
  double d[width] = {};
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t k = 0; k < width; ++k) {
      const double below = b.low[axis][k] - place[axis], above = place[axis] - b.high[axis][k];
      const double out = std::max(std::max(below, above), 0.0);
      d[k] += out * out;
    }
  const std::size_t points = std::size_t{1} << 3 * (level + 1);  // of a child
  std::size_t order[width], count = 0;                           // of those that may matter, equally near ones by index
  for (std::size_t k = 0; k < width; ++k) {
    if (d[k] == infinity || best.is_past(d[k], (node * width + k) * points)) continue;
    std::size_t at = count++;
    for (; at > 0 && d[order[at - 1]] > d[k]; --at) order[at] = order[at - 1];
    order[at] = k;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t child = node * width + order[i];
    if (best.is_past(d[order[i]], child * points)) return;
    if (level > 0)
      descend(p, level - 1, child, known, best);
    else if (child != known)
      look_in(p, child, best);
  }
}

template <class Best>
void BoxTree::look(const Point3& p, Index begin, Best& best) const {
  if (size_ == 0) return;
  std::size_t known = nowhere;
  if (begin != no_index) look_in(p, known = begin / width, best);
  descend(p, levels_.size() - 1, 0, known, best);
}

BoxTree::Two BoxTree::nearest_two(const Point3& p) const { return nearest_two(p, no_index); }

BoxTree::Two BoxTree::nearest_two(const Point3& p, Index begin) const {
  BestTwo best;
  look(p, begin, best);
  if (best.two.first == no_index && size_ > 0) best.two.first = 0;
  return best.two;
}

}  // namespace isopach
