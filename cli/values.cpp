#include "cli/values.hpp"

#include "cli/session.hpp"
#include "isopach/io/polygons.hpp"
#include "isopach/io/raster_values.hpp"

namespace isopach::cli {
namespace {

std::vector<PolygonSet> read_all(const std::vector<std::string>& paths, const Context& context) {
  std::vector<PolygonSet> sets;
  for (const std::string& path : paths) {
    context.check();
    sets.push_back(polygons_named(path));
  }
  return sets;
}

}  // namespace

AreaOptions read_area(const AreaPaths& paths, const Context& context) {
  AreaOptions area;
  area.include = read_all(paths.include, context);
  area.budget = read_all(paths.budget, context);
  if (!paths.mask.empty()) area.mask = read_mask(paths.mask, context);
  area.exclude = read_all(paths.exclude, context);
  return area;
}

void read_rasters(CompareOptions& options, const Context& context) {
  UncertaintyOptions& u = options.uncertainty;
  if (u.sigma1.kind == SigmaSource::Kind::raster)
    u.sigma1.raster = read_raster_values(u.sigma1.name, "@sigma1", context);
  if (u.sigma2.kind == SigmaSource::Kind::raster)
    u.sigma2.raster = read_raster_values(u.sigma2.name, "@sigma2", context);
  if (options.weight.kind == WeightSource::Kind::raster)
    options.weight.raster = read_raster_values(options.weight.text, "@weight", context);
}

}  // namespace isopach::cli
