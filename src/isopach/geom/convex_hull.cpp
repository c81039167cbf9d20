#include "isopach/geom/convex_hull.hpp"

#include <algorithm>
#include <iterator>

#include "isopach/geom/predicates.hpp"

namespace isopach {
namespace {

/// Of points in lexicographic order those that turn to one side all the way: +1 to the left, −1 to the right.
std::vector<Point2> chain(const std::vector<Point2>& points, int side) {
  std::vector<Point2> corners;
  for (const Point2& p : points) {
    while (corners.size() >= 2 && side * orientation(corners[corners.size() - 2], corners.back(), p) <= 0)
      corners.pop_back();
    corners.push_back(p);
  }
  return corners;
}

/// On which side of a chain a point between its ends lies.
int side_of(const std::vector<Point2>& chain, const Point2& p) {
  const auto above = std::upper_bound(chain.begin(), chain.end() - 1, p, lexicographic_less);
  return orientation(*(above - 1), *above, p);
}

}  // namespace

void ConvexHull::add(std::span<const Point2> points) {
  std::vector<Point2> all;
  std::copy_if(points.begin(), points.end(), std::back_inserter(all), [&](const Point2& p) { return !holds(p); });
  if (all.empty()) return;
  all.insert(all.end(), lower_.begin(), lower_.end()), all.insert(all.end(), upper_.begin(), upper_.end());
  std::sort(all.begin(), all.end(), lexicographic_less);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  lower_ = chain(all, 1), upper_ = chain(all, -1);
}

std::vector<Point2> ConvexHull::corners() const {
  std::vector<Point2> all = lower_;
  for (std::size_t i = upper_.size(); i-- > 2;) all.push_back(upper_[i - 1]);
  return all;
}

bool ConvexHull::holds(const Point2& p) const {
  if (lower_.empty() || lexicographic_less(p, lower_.front()) || lexicographic_less(lower_.back(), p)) return false;
  return lower_.size() == 1 || (side_of(lower_, p) >= 0 && side_of(upper_, p) <= 0);
}

}  // namespace isopach
