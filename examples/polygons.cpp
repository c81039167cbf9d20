// Volumes by polygon: a budget of two halves of a lifted plane.
#include <cmath>
#include <iostream>

#include "isopach/base/option_key.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/simulate/scene.hpp"

int main() try {
  isopach::PolygonSet halves;  // or isopach::read_polygons("halves.geojson"), from isopach/io/polygons.hpp
  halves.path = "halves";      // its name in messages
  halves.polygons = {{"west", {{{-1000, -1000}, {40, -1000}, {40, 1000}, {-1000, 1000}}}},
                     {"east", {{{40, -1000}, {1000, -1000}, {1000, 1000}, {40, 1000}}}}};

  const isopach::Context context;
  const isopach::Scene scene = isopach::make_scene("plane", isopach::scene_defaults("plane"), context);
  isopach::CompareOptions options;
  options.area.budget = {halves};  // rows; options.area.include would also limit what is measured
  const isopach::Comparison c = isopach::compare(scene.a, scene.b, options, context);

  double net = 0;
  for (const isopach::BudgetRow& row : c.budget) {
    std::cout << row.name << ": net " << row.volume.net << " " << c.unit << "³ on " << row.area << " " << c.unit
              << "²\n";
    net += row.volume.net;
  }
  // Cells are cut exactly: the two halves add up to the whole.
  return c.budget.size() == 2 && std::abs(net - c.measures.volume.net) < 1e-9 * net ? 0 : 1;
} catch (const isopach::Error& error) {
  std::cerr << isopach::for_keywords(error.what()) << "\n";
  return static_cast<int>(error.code());
}
