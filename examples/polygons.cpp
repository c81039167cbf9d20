// Volumes by polygon: a budget of two halves of a lifted plane.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "isopach/compare/compare.hpp"
#include "isopach/simulate/scene.hpp"

int main() try {
  const auto file = std::filesystem::temp_directory_path() / "isopach-example-polygons.geojson";
  std::ofstream(file) << R"({"type": "FeatureCollection", "features": [
    {"type": "Feature", "properties": {"name": "west"}, "geometry": {"type": "Polygon", "coordinates":
      [[[-1000, -1000], [40, -1000], [40, 1000], [-1000, 1000], [-1000, -1000]]]}},
    {"type": "Feature", "properties": {"name": "east"}, "geometry": {"type": "Polygon", "coordinates":
      [[[40, -1000], [1000, -1000], [1000, 1000], [40, 1000], [40, -1000]]]}}]})";

  const isopach::Context context;
  const isopach::Scene scene = isopach::make_scene("plane", isopach::scene_defaults("plane"), context);
  isopach::CompareOptions options;
  options.area.budget = {file.string()};  // rows; options.area.include would also limit what is measured
  const isopach::Comparison c = isopach::compare(scene.a, scene.b, options, context);
  std::filesystem::remove(file);

  double net = 0;
  for (const isopach::BudgetRow& row : c.budget) {
    std::cout << row.name << ": net " << row.volume.net << " " << c.unit << "³ on " << row.area << " " << c.unit
              << "²\n";
    net += row.volume.net;
  }
  // Cells are cut exactly: the two halves add up to the whole.
  return c.budget.size() == 2 && std::abs(net - c.measures.volume.net) < 1e-9 * net ? 0 : 1;
} catch (const isopach::Error& error) {
  std::cerr << error.what() << "\n";
  return static_cast<int>(error.code());
}
