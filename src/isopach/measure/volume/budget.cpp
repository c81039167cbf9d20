#include "isopach/measure/volume/budget.hpp"

#include <unordered_map>

#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"

namespace isopach {

namespace {

struct Sums {
  Sum area, above, below;
  void add(const Sums& other) {
    area.add(other.area);
    above.add(other.above);
    below.add(other.below);
  }
};

// The regions that a block of cells meets: few of all.
class BlockSums {
 public:
  void add(Index region, const ConvexCell& piece) {
    Sums& sums = of(region);
    for_triangles(piece, [&](double area, const Corner& a, const Corner& b, const Corner& c) {
      const Parts parts = split_volume({area, {a.d(), b.d(), c.d()}});
      sums.area.add(area);
      sums.above.add(parts.above);
      sums.below.add(parts.below);
    });
  }
  void add_to(std::vector<Sums>& all) const {
    for (const auto& [region, at] : place_) all[region].add(sums_[at]);
  }

 private:
  Sums& of(Index region) {
    const auto [found, is_new] = place_.try_emplace(region, sums_.size());
    if (is_new) sums_.emplace_back();
    return sums_[found->second];
  }
  std::unordered_map<Index, std::size_t> place_;
  std::vector<Sums> sums_;
};

template <class Source>
std::vector<RegionSums> budget_of(const Source& cells, const Regions& regions, const Context& context) {
  context.check();
  const std::size_t n = items_of(cells), block = default_block;
  std::vector<BlockSums> blocks((n + block - 1) / block);
  for_blocks(n, block, [&](std::size_t begin, std::size_t end) {
    Regions::Scratch scratch;
    for_convex(cells, begin, end, [&](const ConvexCell& cell) {
      regions.for_pieces(cell, scratch,
                         [&](Index region, const ConvexCell& piece) { blocks[begin / block].add(region, piece); });
    });
  });
  std::vector<Sums> sums(regions.size());
  for (const BlockSums& b : blocks) b.add_to(sums);  // per region in the order of blocks
  std::vector<RegionSums> rows;
  for (const Sums& s : sums) {
    RegionSums row;
    row.area = s.area.value();
    row.volume.above = s.above.value();
    row.volume.below = s.below.value();
    row.volume.net = row.volume.above - row.volume.below;
    row.volume.absolute = row.volume.above + row.volume.below;
    rows.push_back(row);
  }
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
