// Everything that a comparison reads from files elsewhere is a value here: scans, a polygon, a mask, a weight as a
// function, standard deviations as a raster. B lies 0.25 above A, within a polygon of 6 x 4, of which the mask takes
// a half away: net = 0.25 * 12 in every digit.
#include <iostream>

#include "isopach/isopach.hpp"

namespace {

isopach::Cloud plane(double z) {
  isopach::Cloud cloud;
  for (int row = 0; row < 20; ++row)
    for (int column = 0; column < 30; ++column) cloud.points.push_back({double(column), double(row), z});
  return cloud;
}

isopach::SigmaSource sigma_everywhere(double sigma) {
  isopach::Cloud cells;
  cells.grid = isopach::RasterGrid{1, 1, {-1, 40, 0, -1, 0, 40}};
  cells.points.push_back({19, 19, sigma});
  return {isopach::SigmaSource::Kind::raster, 0, "everywhere", isopach::RasterValues(cells)};
}

}  // namespace

int main() {
  isopach::CompareOptions options;
  isopach::PolygonSet site;
  site.path = "site";
  site.polygons.push_back({"field", {{{2, 2}, {8, 2}, {8, 6}, {2, 6}}}});
  options.area.include = {site};
  options.area.mask =
      isopach::Mask{"west", "", {{{0, 0}, {5, 0}}, {{5, 0}, {5, 9}}, {{5, 9}, {0, 9}}, {{0, 9}, {0, 0}}}, {}, {}};
  options.weight = {isopach::WeightSource::Kind::expression, isopach::WeightSource::Scan::any, "two",
                    [](const isopach::Place&) { return 2.0; }};
  options.uncertainty.sigma1 = options.uncertainty.sigma2 = sigma_everywhere(0.01);
  const isopach::Comparison c = isopach::compare(plane(1), plane(1.25), options, isopach::Context{});
  std::cout << "net " << c.measures.volume.net << " area " << c.domain_area << " weighted " << c.weighted->rho
            << " row " << c.budget.at(0).name << " detected " << c.uncertainty.detected->area << "\n";
  return 0;
}
