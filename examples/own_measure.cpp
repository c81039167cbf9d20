// A measure of one's own: the volume of B that lies more than a level above A, in closed form over every cell.
#include <cmath>
#include <iostream>

#include "isopach/base/option_key.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/measure/source.hpp"
#include "isopach/simulate/scene.hpp"

/// ∫ max(d − level, 0) over the domain.
double volume_above(const isopach::CellView& cells, double level) {
  double volume = 0;
  isopach::for_cells(cells, 0, isopach::items_of(cells), [&](const isopach::Cell& cell) {
    // d is linear on a cell, so d − level is, too: split_volume cuts the cell where it crosses zero.
    const isopach::Cell raised{cell.area, {cell.d[0] - level, cell.d[1] - level, cell.d[2] - level}};
    volume += isopach::split_volume(raised).above;
  });
  return volume;
}

int main() try {
  const isopach::Context context;
  const isopach::Scene scene = isopach::make_scene("paraboloid", isopach::scene_defaults("paraboloid"), context);
  const isopach::Comparison c = isopach::compare(scene.a, scene.b, isopach::CompareOptions{}, context);

  // d = h (1 − r²/R²) with h = 4 m, R = 35 m. Above half of its height: a cap with the volume π h R² / 8.
  const double found = volume_above(c.cells.view(), 2), truth = 3.14159265358979 * 4 * 35 * 35 / 8;
  std::cout << "more than 2 m above: " << found << " m³, in truth " << truth << " m³\n";
  return std::abs(found - truth) < 1e-3 * truth ? 0 : 1;
} catch (const isopach::Error& error) {
  std::cerr << isopach::for_keywords(error.what()) << "\n";
  return static_cast<int>(error.code());
}
