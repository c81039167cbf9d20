#include "isopach/compare/domain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "isopach/field/extent.hpp"

namespace isopach::stages {

namespace {

// Polygons are given in x and y of the input: the frame may shift those, but not turn them.
void check_direction(const Frame& frame, const std::string& option) {
  if (frame.rotation != std::array<double, 9>{1, 0, 0, 0, 1, 0, 0, 0, 1})
    throw UsageError(
        option +
        ": polygons and masks are in x and y, so they go with @direction z alone; leave the direction, or turn the "
        "scans first (isopach convert @pose)");
}

// `given`: a PolygonSet or a Mask.
template <class Given>
void check_crs(const std::string& option, const Given& given, const std::string& of_scans, bool allowed) {
  const std::string& crs = given.crs;
  if (allowed || crs.empty() || of_scans.empty() || crs == of_scans) return;
  if (given.geo.same_crs && given.geo.same_crs(crs, of_scans)) return;
  const auto short_name = [&](const std::string& text) {
    return given.geo.short_name ? given.geo.short_name(text) : text;
  };
  throw InputError(
      fmt::format("{}: {}: its CRS is {}, that of the scans {}: reproject it (ogr2ogr -t_srs), or pass "
                  "@allow-crs if the coordinates are right",
                  given.path, option, short_name(crs), short_name(of_scans)));
}

std::vector<Edge> moved(std::vector<Edge> edges, const Frame& frame) {
  for (Edge& e : edges)
    for (Point2* p : {&e.a, &e.b}) {
      const Point3 at = frame.to_field({p->x, p->y, 0});
      *p = {at.x, at.y};
    }
  return edges;
}

bool in_reach(const Point2& p) { return std::fabs(p.x) <= max_extent && std::fabs(p.y) <= max_extent; }

[[noreturn]] void refuse_far(const std::string& what, const Point2& p, const Frame& frame) {
  const Point3 at = frame.to_input({p.x, p.y, 0});
  throw InputError(fmt::format("{} has a corner at ({:.10g}, {:.10g}), farther than {} from the scans: mend the file",
                               what, at.x, at.y, max_extent));
}

Region region_of(Polygon polygon, const PolygonSet& file, const Frame& frame, std::vector<std::string>& warnings) {
  for (auto& ring : polygon.rings)
    for (Point2& p : ring) {
      const Point3 here = frame.to_field({p.x, p.y, 0});
      p = {here.x, here.y};
      if (!in_reach(p)) refuse_far(fmt::format("{}: polygon '{}'", file.path, polygon.name), p, frame);
    }
  Region region;
  region.edges = edges_of(polygon);
  Point2 at{};
  auto parts = trapezoids(region.edges, &at);
  if (!parts) {
    const std::optional<Polygon> better = file.geo.mended ? file.geo.mended(polygon) : std::nullopt;
    if (better) {
      region.edges = edges_of(*better);
      parts = trapezoids(region.edges);
    }
    const Point3 where = frame.to_input({at.x, at.y, 0});
    if (!parts)
      throw InputError(
          fmt::format("{}: polygon '{}' has no area, or crosses itself near ({:.10g}, {:.10g}) in a way "
                      "that could not be mended: mend the file",
                      file.path, polygon.name, where.x, where.y));
    warnings.push_back(fmt::format(
        "{}: polygon '{}' crosses itself or doubles a side near ({:.10g}, {:.10g}); it was mended: check its area",
        file.path, polygon.name, where.x, where.y));
  }
  region.parts = std::move(*parts);
  return region;
}

Box2 box_of(const std::vector<Region>& regions, const Frame& frame) {
  Box2 box;
  for (const Region& region : regions)
    for (const Edge& e : region.edges)
      for (const Point2& p : {e.a, e.b}) {
        const Point3 at = frame.to_input({p.x, p.y, 0});
        box.add(Point2{at.x, at.y});
      }
  return box;
}

// Longitudes and latitudes beside scans that are projected: polygons of GeoJSON without a named CRS are, by its
// standard, in degrees.
void check_degrees(const std::string& option, const std::string& path, const Box2& polygons, const Box3& scans) {
  if (polygons.empty() || scans.empty()) return;
  const double largest =
      std::max({std::fabs(scans.min.x), std::fabs(scans.max.x), std::fabs(scans.min.y), std::fabs(scans.max.y)});
  const bool may_be_degrees =
      polygons.min.x >= -180 && polygons.max.x <= 360 && polygons.min.y >= -90 && polygons.max.y <= 90;
  const bool apart = polygons.max.x < scans.min.x || scans.max.x < polygons.min.x || polygons.max.y < scans.min.y ||
                     scans.max.y < polygons.min.y;
  if (!may_be_degrees || !apart || !(largest > 360)) return;
  throw InputError(fmt::format(
      "{}: {}: its coordinates look like degrees (longitude {:.6g} to {:.6g}, latitude {:.6g} to {:.6g}), those of the "
      "scans do not (x {:.10g} to {:.10g}, y {:.10g} to {:.10g}): reproject it to the CRS of the scans (ogr2ogr -s_srs "
      "EPSG:4326 -t_srs CRS)",
      path, option, polygons.min.x, polygons.max.x, polygons.min.y, polygons.max.y, scans.min.x, scans.max.x,
      scans.min.y, scans.max.y));
}

/// What the options name, as regions of the frame of the comparison.
class InFrame {
 public:
  InFrame(Comparison& c, const Context& context)
      : options_(c.options),
        crs_(!c.a.crs.empty() ? c.a.crs : c.b.crs),
        cells_(2 * (c.a.nodes + c.b.nodes)),
        c_(c),
        context_(context) {}

  std::vector<Region> regions(const std::string& option, const std::vector<PolygonSet>& sets,
                              std::vector<BudgetRow>* rows) {
    std::vector<Region> regions;
    for (const PolygonSet& set : sets) {
      NamedRegions file = regions_of(option, set, c_.frame, crs_, options_.allow_crs, c_.warnings, context_);
      Box3 scans = c_.a.bounds;
      scans.add(c_.b.bounds);
      check_degrees(option, set.path, box_of(file.regions, c_.frame), scans);
      for (Region& region : file.regions) regions.push_back(std::move(region));
      if (rows == nullptr) continue;
      for (std::string& name : file.names) {
        BudgetRow row;
        row.name = std::move(name);
        row.file = set.path;
        row.restricts = option == "@include";
        rows->push_back(std::move(row));
      }
    }
    return regions;
  }

  Region region(const Mask& mask) {
    check_direction(c_.frame, "@mask");
    check_crs("@mask", mask, crs_, options_.allow_crs);
    for (const std::string& note : mask.notes) c_.warnings.push_back(mask.path + ": " + note);
    Region region;
    region.edges = moved(mask.edges, c_.frame);
    for (const Edge& e : region.edges)
      if (!in_reach(e.a)) refuse_far(mask.path + ": @mask", e.a, c_.frame);
    auto parts = trapezoids(region.edges);
    if (!parts)
      throw InputError(mask.path +
                       ": @mask: its pixels are too small for its coordinates: use a raster with larger pixels");
    region.parts = std::move(*parts);
    return region;
  }

  [[nodiscard]] Regions index(std::vector<Region> regions) const { return {std::move(regions), cells_}; }

 private:
  const CompareOptions& options_;
  std::string crs_;
  std::size_t cells_;  // about how many there will be
  Comparison& c_;
  const Context& context_;
};

std::vector<Region> joined(std::vector<Region> first, std::vector<Region> second) {
  for (Region& r : second) first.push_back(std::move(r));
  return first;
}

}  // namespace

namespace {

void warn_of_empty_rows(Comparison& c) {
  constexpr std::size_t most_names = 5;
  std::size_t empty = 0;
  std::string names;
  for (const BudgetRow& row : c.budget) {
    if (row.area > 0) continue;
    if (empty++ < most_names) names += (names.empty() ? "'" : ", '") + row.name + "'";
  }
  if (empty == 0) return;
  if (empty > most_names) names += ", …";
  c.warnings.push_back(fmt::format(
      "{} of {} polygons hold no part of the area compared, so nothing was measured in them ({}): check their "
      "coordinates, and on the map whether both scans reach them",
      empty, c.budget.size(), names));
}

}  // namespace

NamedRegions regions_of(const std::string& option, const PolygonSet& file, const Frame& frame, const std::string& crs,
                        bool allow_crs, std::vector<std::string>& warnings, const Context& context) {
  check_direction(frame, option);
  check_crs(option, file, crs, allow_crs);
  for (const std::string& note : file.notes) warnings.push_back(note);
  NamedRegions found;
  for (const Polygon& polygon : file.polygons) {
    context.check();
    found.names.push_back(polygon.name);
    found.regions.push_back(region_of(polygon, file, frame, warnings));
  }
  return found;
}

AreaOfInterest::AreaOfInterest(Comparison& c, const Context& context) {
  const CompareOptions& options = c.options;
  InFrame in_frame(c, context);
  std::vector<Region> include = in_frame.regions("@include", options.area.include, &rows_);
  std::vector<Region> rows_alone = in_frame.regions("@budget", options.area.budget, &rows_);
  if (!rows_.empty()) polygons_ = in_frame.index(joined(include, std::move(rows_alone)));
  for (std::size_t i = 0; i < rows_.size(); ++i) rows_[i].polygon_area = polygons_.area(i);
  if (!include.empty()) domain_.keep(in_frame.index(std::move(include)));
  if (options.area.mask) {
    std::vector<Region> mask;
    mask.push_back(in_frame.region(*options.area.mask));
    domain_.keep(in_frame.index(std::move(mask)));
  }
  std::vector<Region> exclude = in_frame.regions("@exclude", options.area.exclude, nullptr);
  if (!exclude.empty()) domain_.take_away(in_frame.index(std::move(exclude)));
}

void AreaOfInterest::fill(const std::vector<RegionSums>& sums, Comparison& c) const {
  c.budget = rows_;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    BudgetRow& row = c.budget[i];
    row.area = sums[i].area;
    row.volume = sums[i].volume;
    if (row.area > 0) row.mean = row.volume.net / row.area, row.rho = row.volume.absolute / row.area;
    row.coverage = row.polygon_area > 0 ? std::min(1.0, row.area / row.polygon_area) : 0;
  }
  warn_of_empty_rows(c);
}

void AreaOfInterest::fill_budget(const OverlayCells& cells, Comparison& c, const Context& context) const {
  if (wants_budget()) fill(budget(cells, polygons_, context), c);
}

void AreaOfInterest::fill_budget(Comparison& c, const Context& context) const {
  if (wants_budget()) fill(budget(c.cells.view(), polygons_, context), c);
}

void AreaOfInterest::cut_cells(Comparison& c, const Context& context) const {
  if (domain_.is_everything()) return;
  Array<unsigned char>& flags = c.cells.in_domain;
  const auto any = [&] { return std::find(flags.begin(), flags.end(), 1) != flags.end(); };
  const bool were_any = any() || !c.cells.pieces.empty();
  c.cells.unclipped.assign(flags.begin(), flags.end());
  for (const CellPiece& piece : c.cells.pieces) c.cells.unclipped[piece.cell] = 1;
  c.cells.pieces = isopach::cut_cells(c.cells.view(), flags, domain_, context);
  if (were_any && c.cells.pieces.empty() && !any())
    throw OverlapError(
        "the area that the scans share and the polygons and mask leave nothing in common: check the coordinates of "
        "@include, @exclude and @mask");
}

void cut_borders(const Pair& pair, const Domain& domain, Borders& borders, Comparison& c, const Context& context) {
  const Scan &a = pair.scan[0], &b = pair.scan[1];
  Region hull;
  const Array<Index> nodes = hull_nodes(b.t, b.field.xy);
  if (b.t.real > 0)
    for (std::size_t i = 0; i < nodes.size(); ++i)
      hull.edges.push_back({b.field.xy[nodes[i]], b.field.xy[nodes[i + 1 == nodes.size() ? 0 : i + 1]]});
  auto parts = trapezoids(hull.edges);
  if (!parts) throw Error(ExitCode::internal, "the hull of a scan crosses itself: please report this");
  hull.parts = std::move(*parts);
  std::vector<Region> hulls;
  hulls.push_back(std::move(hull));
  const Regions within(std::move(hulls), a.t.real);
  const AreasInside of_1 = areas_inside(domain, a.t, a.field.xy, with_folds(a.kept, a.folded), &within, context);
  const AreasInside of_2 = areas_inside(domain, b.t, b.field.xy, with_folds(b.kept, b.folded), nullptr, context);
  c.area_union = of_1.all + of_2.all - of_1.within;
  borders.kept_area = of_1.flagged + of_2.flagged;
  borders.removed_area = std::max(0.0, of_1.all + of_2.all - borders.kept_area);
}

}  // namespace isopach::stages
