#include "isopach/overlay/common.hpp"

namespace isopach {

UnitedNodes unite(std::span<const Point2> g1, std::span<const Point2> g2, const CurveBox& box) {
  UnitedNodes g;
  g.xy.reserve(g1.size() + g2.size());
  g.of_1.reserve(g1.size() + g2.size());
  g.of_2.reserve(g1.size() + g2.size());
  const auto key = [&](std::span<const Point2> s, std::size_t i) { return i < s.size() ? curve_key(box, s[i]) : 0; };
  std::size_t i = 0, j = 0;
  std::uint64_t k1 = key(g1, 0), k2 = key(g2, 0);
  while (i < g1.size() || j < g2.size()) {
    bool take_1 = j == g2.size(), take_2 = i == g1.size();
    if (!take_1 && !take_2) {
      take_1 = k1 < k2 || (k1 == k2 && !lexicographic_less(g2[j], g1[i]));
      take_2 = k2 < k1 || (k1 == k2 && !lexicographic_less(g1[i], g2[j]));
    }
    g.xy.push_back(take_1 ? g1[i] : g2[j]);
    g.of_1.push_back(take_1 ? static_cast<Index>(i) : no_index);
    g.of_2.push_back(take_2 ? static_cast<Index>(j) : no_index);
    if (take_1) k1 = key(g1, ++i);
    if (take_2) k2 = key(g2, ++j);
  }
  return g;
}

}  // namespace isopach
