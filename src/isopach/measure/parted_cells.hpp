// PartedCells: a source of cells, as those of source.hpp, that lie in parts: what tiles found final of T, and the rest.
// All of it together is T of the whole, and gives the sums, quantiles and histogram of the whole bit for bit: sums are
// exact, and samples are chosen by places.
#pragma once
#include <array>
#include <span>
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

  [[nodiscard]] double d(Index node) const { return z2[node] - z1[node]; }
  [[nodiscard]] Cell cell(std::size_t i) const {
    const std::array<Index, 3>& v = triangles[i];
    return {triangle_area(xy[v[0]], xy[v[1]], xy[v[2]]), {d(v[0]), d(v[1]), d(v[2])}};
  }
};

class PartedCells {
 public:
  /// `rest`: the cells that are in no part, with its bounds. `population`: items_of T as a whole, cells that are not in
  /// the domain included.
  PartedCells(std::vector<CellPart> parts, const CellView& rest, std::size_t population);

  [[nodiscard]] std::span<const CellPart> parts() const { return parts_; }
  [[nodiscard]] const CellView& rest() const { return rest_; }
  [[nodiscard]] std::size_t population() const { return population_; }
  [[nodiscard]] std::size_t items() const { return first_.back() + items_of(rest_); }

  /// f(part, begin, end) for the items of parts in a range, and rest(begin, end) for those of the rest, by their own
  /// numbers.
  template <class F, class G>
  void visit(std::size_t begin, std::size_t end, F&& f, G&& rest) const {
    std::size_t k = part_of(begin);
    while (begin < end && k < parts_.size()) {
      const std::size_t stop = std::min(end, first_[k + 1]);
      if (begin < stop) f(parts_[k], begin - first_[k], stop - first_[k]);
      begin = std::max(begin, stop), ++k;
    }
    if (begin < end) rest(begin - first_.back(), end - first_.back());
  }
  /// The part that holds an item, or the number of parts.
  [[nodiscard]] std::size_t part_of(std::size_t item) const;
  [[nodiscard]] std::size_t first_item(std::size_t part) const { return first_[part]; }

 private:
  std::vector<CellPart> parts_;
  std::vector<std::size_t> first_;  // item of each part, and where the rest begins
  const CellView& rest_;
  std::size_t population_;
};

[[nodiscard]] inline std::size_t items_of(const PartedCells& cells) { return cells.items(); }
[[nodiscard]] inline SumBounds bounds_of(const PartedCells& cells) { return bounds_of(cells.rest()); }

template <class F>
void for_cells(const PartedCells& cells, std::size_t begin, std::size_t end, F&& f) {
  cells.visit(
      begin, end,
      [&](const CellPart& part, std::size_t from, std::size_t to) {
        for (std::size_t i = from; i < to; ++i) f(part.cell(i));
      },
      [&](std::size_t from, std::size_t to) { for_cells(cells.rest(), from, to, f); });
}

[[nodiscard]] std::uint64_t name_of(const PartedCells& cells, std::size_t item);
[[nodiscard]] bool may_have_cells(const PartedCells& cells, std::size_t item);

/// As of the other sources (measures.hpp).
[[nodiscard]] Measures measure(const PartedCells& cells, const Context& context,
                               std::span<const double> percentiles = {});

}  // namespace isopach
