#include "isopach/overlay/common.hpp"

#include <algorithm>
#include <vector>

#include "isopach/base/parallel.hpp"

namespace isopach {

namespace {

// How far both sets have been merged.
struct Place {
  std::size_t of_1, of_2;
};

// The order of the curve.
bool comes_before(const CurveNodes& g, std::size_t i, std::uint64_t key, const Point2& p) {
  return g.keys[i] != key ? g.keys[i] < key : lexicographic_less(g.xy[i], p);
}

// How many nodes of `g` come before node i of `cut`.
std::size_t count_before(const CurveNodes& g, const CurveNodes& cut, std::size_t i) {
  std::size_t first = 0, last = g.xy.size();
  while (first < last) {
    const std::size_t middle = first + (last - first) / 2;
    if (comes_before(g, middle, cut.keys[i], cut.xy[i]))
      first = middle + 1;
    else
      last = middle;
  }
  return first;
}

// Where parts of about equal size begin, and the end. Equal nodes lie in the same part.
std::vector<Place> cuts(const CurveNodes& g1, const CurveNodes& g2) {
  constexpr std::size_t part = std::size_t{1} << 15;
  const bool by_1 = g1.xy.size() >= g2.xy.size();
  const CurveNodes &larger = by_1 ? g1 : g2, &smaller = by_1 ? g2 : g1;
  std::vector<Place> places{{0, 0}};
  for (std::size_t i = part; i < larger.xy.size(); i += part) {
    const std::size_t j = count_before(smaller, larger, i);
    places.push_back(by_1 ? Place{i, j} : Place{j, i});
  }
  places.push_back({g1.xy.size(), g2.xy.size()});
  return places;
}

// Merges what lies between two places, and writes it from `at` on; returns where it ends. Which set has the next node,
// nobody can predict: without a branch on that.
std::size_t merge_part(const CurveNodes& g1, const CurveNodes& g2, Place from, const Place& to, std::size_t at,
                       UnitedNodes& g) {
  auto& [i, j] = from;
  while (i < to.of_1 && j < to.of_2) {
    const std::uint64_t k1 = g1.keys[i], k2 = g2.keys[j];
    bool take_1 = k1 <= k2, take_2 = k2 <= k1;
    if (k1 == k2) [[unlikely]] {
      take_1 = !lexicographic_less(g2.xy[j], g1.xy[i]);
      take_2 = !lexicographic_less(g1.xy[i], g2.xy[j]);
    }
    const Point2* const next = take_1 ? &g1.xy[i] : &g2.xy[j];
    g.xy[at] = *next;
    g.of_1[at] = take_1 ? static_cast<Index>(i) : no_index;
    g.of_2[at] = take_2 ? static_cast<Index>(j) : no_index;
    i += take_1 ? 1 : 0, j += take_2 ? 1 : 0, ++at;
  }
  for (; i < to.of_1; ++i, ++at) g.xy[at] = g1.xy[i], g.of_1[at] = static_cast<Index>(i), g.of_2[at] = no_index;
  for (; j < to.of_2; ++j, ++at) g.xy[at] = g2.xy[j], g.of_1[at] = no_index, g.of_2[at] = static_cast<Index>(j);
  return at;
}

// Closes the gaps that shared nodes have left behind the parts.
void close_gaps(const std::vector<Place>& begin, const std::vector<std::size_t>& end, UnitedNodes& g) {
  std::size_t at = 0;
  for (std::size_t p = 0; p < end.size(); ++p) {
    const std::size_t first = begin[p].of_1 + begin[p].of_2, last = end[p];
    const auto move_down = [&](auto& values) {
      if (at < first) std::copy(values.data() + first, values.data() + last, values.data() + at);
    };
    move_down(g.xy), move_down(g.of_1), move_down(g.of_2);
    at += last - first;
  }
  g.xy.resize(at), g.of_1.resize(at), g.of_2.resize(at);
}

Array<std::uint64_t> keys_of(std::span<const Point2> xy, const CurveBox& box) {
  Array<std::uint64_t> keys(xy.size());
  for_each_index(xy.size(), [&](std::size_t i) { keys[i] = curve_key(box, xy[i]); });
  return keys;
}

}  // namespace

UnitedNodes unite(const CurveNodes& g1, const CurveNodes& g2) {
  const std::vector<Place> place = cuts(g1, g2);
  const std::size_t parts = place.size() - 1, most = g1.xy.size() + g2.xy.size();
  UnitedNodes g;
  g.xy.resize(most), g.of_1.resize(most), g.of_2.resize(most);
  std::vector<std::size_t> end(parts);
  for_blocks(parts, 1, [&](std::size_t p, std::size_t) {
    end[p] = merge_part(g1, g2, place[p], place[p + 1], place[p].of_1 + place[p].of_2, g);
  });
  close_gaps(place, end, g);
  return g;
}

UnitedNodes unite(std::span<const Point2> g1, std::span<const Point2> g2, const CurveBox& box) {
  const Array<std::uint64_t> k1 = keys_of(g1, box), k2 = keys_of(g2, box);
  return unite({g1, k1}, {g2, k2});
}

}  // namespace isopach
