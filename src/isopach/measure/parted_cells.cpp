#include "isopach/measure/parted_cells.hpp"

#include <algorithm>

namespace isopach {

PartedCells::PartedCells(std::vector<CellPart> parts, const CellView& rest, std::size_t population)
    : parts_(std::move(parts)), first_{0}, rest_(rest), population_(population) {
  for (const CellPart& part : parts_) first_.push_back(first_.back() + part.triangles.size());
}

std::size_t PartedCells::part_of(std::size_t item) const {
  const auto after = std::upper_bound(first_.begin(), first_.end(), item);
  return static_cast<std::size_t>(after - first_.begin()) - 1;
}

std::uint64_t name_of(const PartedCells& cells, std::size_t item) {
  const std::size_t k = cells.part_of(item), i = item - cells.first_item(k);
  if (k == cells.parts().size()) return name_of(cells.rest(), i);
  const CellPart& part = cells.parts()[k];
  const std::array<Index, 3>& v = part.triangles[i];
  return hash_of(part.xy[v[1]], hash_of(part.xy[v[0]]));
}

bool may_have_cells(const PartedCells& cells, std::size_t item) {
  const std::size_t k = cells.part_of(item);
  return k < cells.parts().size() || may_have_cells(cells.rest(), item - cells.first_item(k));
}

}  // namespace isopach
