#include "isopach/measure/parted_cells.hpp"

namespace isopach {

PartedCells::PartedCells(std::vector<PartedCellsPart> parts, const CellView& rest, std::size_t population)
    : parts_(std::move(parts)), first_{0}, rest_(rest), population_(population) {
  for (const PartedCellsPart& part : parts_) first_.push_back(first_.back() + part.cells);
}

std::size_t PartedCells::part_of(std::size_t item) const {
  const auto after = std::upper_bound(first_.begin(), first_.end(), item);
  return static_cast<std::size_t>(after - first_.begin()) - 1;
}

}  // namespace isopach
