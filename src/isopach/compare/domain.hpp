// The part of the plane that is measured, as the user bounds it, and the table of volumes by polygon.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "isopach/compare/comparison.hpp"
#include "isopach/compare/stages.hpp"
#include "isopach/measure/source.hpp"
#include "isopach/measure/volume/budget.hpp"

namespace isopach::stages {

/// Polygons in a frame: each with its name.
struct NamedRegions {
  std::vector<std::string> names;
  std::vector<Region> regions;
};

/// The polygons of `option` in a frame. `crs`: of the scans, empty if unknown. Throws UsageError where the direction of
/// `frame` is not z; InputError naming the file for polygons that cannot be mended, for corners more than 1e60 away
/// and, unless `allow_crs`, a CRS that is not that of the scans. The notes of the file go into `warnings`, and so do
/// polygons that were mended.
[[nodiscard]] NamedRegions regions_of(const std::string& option, const PolygonSet& file, const Frame& frame,
                                      const std::string& crs, bool allow_crs, std::vector<std::string>& warnings,
                                      const Context& context);

/// The polygons and the mask of options.area, brought into the frame of the comparison.
/// Domain = what the scans share ∩ ∪ include ∩ mask ∖ ∪ exclude. Rows of the budget: every polygon of include and of
/// budget, over its part of that domain.
class AreaOfInterest {
 public:
  /// What c.options name, for the inputs that c describes. Errors as of regions_of.
  AreaOfInterest(Comparison& c, const Context& context);

  [[nodiscard]] const Domain& domain() const { return domain_; }
  [[nodiscard]] bool wants_budget() const { return !rows_.empty(); }

  /// Fills c.budget over the exact overlay.
  void fill_budget(const OverlayCells& cells, Comparison& c, const Context& context) const;

  /// Cuts c.cells. Throws OverlapError if nothing is left of what there was.
  void cut_cells(Comparison& c, const Context& context) const;
  /// Fills c.budget over c.cells.
  void fill_budget(Comparison& c, const Context& context) const;

 private:
  void fill(const std::vector<RegionSums>& sums, Comparison& c) const;

  Domain domain_;
  Regions polygons_{{}, 0};      // of the budget
  std::vector<BudgetRow> rows_;  // names and own areas alone
};

/// What Borders says of areas, and c.area_union, inside the domain alone. Cost O(triangles).
void cut_borders(const Pair& pair, const Domain& domain, Borders& borders, Comparison& c, const Context& context);

}  // namespace isopach::stages
