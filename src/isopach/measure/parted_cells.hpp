// PartedCells: a source of cells, as those of source.hpp, that lie in parts: what tiles found final of T, and the rest.
// All of it together is T of the whole, and gives the sums, quantiles and histogram of the whole bit for bit: sums are
// exact, and samples are chosen by places.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "isopach/measure/source.hpp"

namespace isopach {

/// Whole cells within the domain, by nodes of their own: a part of T.
struct CellPart {
  std::span<const Point2> xy;
  std::span<const double> z1, z2;
  std::span<const std::array<Index, 3>> triangles;  ///< counter-clockwise, the corner first on the curve first
  std::size_t first_node = 0;                       ///< number of the first of its nodes on the curve, among all of T
  std::span<const std::array<Index, 2>> points{};   ///< by node: of how many points of either scan; empty: not known

  [[nodiscard]] double d(Index node) const { return z2[node] - z1[node]; }
  [[nodiscard]] Cell cell(std::size_t i) const {
    const std::array<Index, 3>& v = triangles[i];
    return {triangle_area(xy[v[0]], xy[v[1]], xy[v[2]]), {d(v[0]), d(v[1]), d(v[2])}};
  }
};

/// How a part is looked at: the cells may lie in a file, which is opened for a block of them and closed after it, so
/// that what is in memory does not grow with the parts.
struct PartedCellsPart {
  std::size_t cells = 0;
  std::function<std::shared_ptr<const CellPart>()> open;
};

class PartedCells {
 public:
  /// `rest`: the cells that are in no part, with its bounds. `population`: items_of T as a whole, cells that are not in
  /// the domain included.
  PartedCells(std::vector<PartedCellsPart> parts, const CellView& rest, std::size_t population);

  [[nodiscard]] const CellView& rest() const { return rest_; }
  [[nodiscard]] std::size_t population() const { return population_; }
  [[nodiscard]] std::size_t items() const { return in_parts() + items_of(rest_); }
  [[nodiscard]] std::size_t in_parts() const { return first_.back(); }

  /// f(CellPart) for all of them, one after the other.
  template <class F>
  void for_parts(F&& f) const {
    for (const PartedCellsPart& part : parts_) f(*part.open());
  }
  /// f(CellPart or CellView, begin, end) for the items in a range, by their own numbers.
  template <class F>
  void visit(std::size_t begin, std::size_t end, F&& f) const {
    std::size_t k = part_of(begin);
    while (begin < end && k < parts_.size()) {
      const std::size_t stop = std::min(end, first_[k + 1]);
      if (begin < stop) f(*parts_[k].open(), begin - first_[k], stop - first_[k]);
      begin = std::max(begin, stop), ++k;
    }
    if (begin < end) f(rest_, begin - in_parts(), end - in_parts());
  }

 private:
  /// The part that holds an item, or the number of parts.
  [[nodiscard]] std::size_t part_of(std::size_t item) const;

  std::vector<PartedCellsPart> parts_;
  std::vector<std::size_t> first_;  // item of each part, and where the rest begins
  const CellView& rest_;
  std::size_t population_;
};

[[nodiscard]] inline std::size_t items_of(const PartedCells& cells) { return cells.items(); }
[[nodiscard]] inline SumBounds bounds_of(const PartedCells& cells) { return bounds_of(cells.rest()); }

template <class F>
void for_cells(const CellPart& part, std::size_t begin, std::size_t end, F&& f) {
  for (std::size_t i = begin; i < end; ++i) f(part.cell(i));
}
template <class F>
void for_cells(const PartedCells& cells, std::size_t begin, std::size_t end, F&& f) {
  cells.visit(begin, end, [&](const auto& view, std::size_t from, std::size_t to) { for_cells(view, from, to, f); });
}
[[nodiscard]] inline std::uint64_t name_of(const CellPart& part, std::size_t i) {
  const std::array<Index, 3>& v = part.triangles[i];
  return hash_of(part.xy[v[1]], hash_of(part.xy[v[0]]));
}
[[nodiscard]] inline bool may_have_cells(const CellPart&, std::size_t) { return true; }

/// f(view, begin, end) for a block of items of a source, by the views that it is made of.
template <class Source, class F>
void for_views(const Source& cells, std::size_t begin, std::size_t end, F&& f) {
  if constexpr (std::is_same_v<Source, PartedCells>)
    cells.visit(begin, end, f);
  else
    f(cells, begin, end);
}

/// As of the other sources (measures.hpp).
[[nodiscard]] Measures measure(const PartedCells& cells, const Context& context,
                               std::span<const double> percentiles = {});

}  // namespace isopach
