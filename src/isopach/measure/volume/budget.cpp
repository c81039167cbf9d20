#include "isopach/measure/volume/budget.hpp"

#include <unordered_map>

#include "isopach/base/parallel.hpp"
#include "isopach/measure/volume/totals.hpp"

namespace isopach {

namespace {

// The regions that a block of cells meets: few of all.
class BlockSums {
 public:
  void add(Index region, const ConvexCell& piece, const SumScales& scales) {
    VolumeSums& sums = of(region, scales);
    for_triangles(piece, [&](double area, const Corner& a, const Corner& b, const Corner& c) {
      sums.add(Cell{area, {a.d(), b.d(), c.d()}});
    });
  }
  void add_to(std::vector<VolumeSums>& all) const {
    for (const auto& [region, at] : place_) all[region].add(sums_[at]);
  }

 private:
  VolumeSums& of(Index region, const SumScales& scales) {
    const auto [found, is_new] = place_.try_emplace(region, sums_.size());
    if (is_new) sums_.emplace_back(scales);
    return sums_[found->second];
  }
  std::unordered_map<Index, std::size_t> place_;
  std::vector<VolumeSums> sums_;
};

template <class Source>
std::vector<RegionSums> budget_of(const Source& cells, const Regions& regions, const Context& context) {
  context.check();
  const SumScales scales(bounds_of(cells));
  const std::size_t n = items_of(cells), block = default_block;
  std::vector<BlockSums> blocks((n + block - 1) / block);
  for_blocks(n, block, [&](std::size_t begin, std::size_t end) {
    Regions::Scratch scratch;
    for_convex(cells, begin, end, [&](const ConvexCell& cell) {
      regions.for_pieces(cell, scratch, [&](Index region, const ConvexCell& piece) {
        blocks[begin / block].add(region, piece, scales);
      });
    });
  });
  std::vector<VolumeSums> sums(regions.size());
  for (const BlockSums& b : blocks) b.add_to(sums);
  std::vector<RegionSums> rows;
  for (const VolumeSums& s : sums) rows.push_back({s.area.value(), s.volume()});
  return rows;
}

}  // namespace

std::vector<RegionSums> budget(const CellView& cells, const Regions& regions, const Context& context) {
  return budget_of(cells, regions, context);
}
std::vector<RegionSums> budget(const OverlayCells& cells, const Regions& regions, const Context& context) {
  return budget_of(cells, regions, context);
}

}  // namespace isopach
