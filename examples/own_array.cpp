// A caller's own array, rows of doubles with further columns, compared where it lies: nothing of it is copied.
#include <cmath>
#include <cstddef>
#include <iostream>
#include <vector>

#include "isopach/compare/compare.hpp"

constexpr std::size_t width = 5;  // x, y, z, quality, time: as another library keeps them

std::vector<double> scan(double height) {
  std::vector<double> rows;
  for (int i = 0; i < 100; ++i)
    for (int j = 0; j < 100; ++j) rows.insert(rows.end(), {0.1 * i, 0.1 * j, height, i < 50 ? 1.0 : 0.5, 0.01 * j});
  return rows;
}

isopach::CloudView view_of(const std::vector<double>& rows) {  // which must live as long as the view is used
  const std::size_t points = rows.size() / width;
  isopach::CloudView view{isopach::PointsView(rows.data(), points, width)};
  view.attributes = {{"quality", {rows.data() + 3, points, width}}};
  view.unit = view.vertical_unit = "m";
  return view;
}

int main() try {
  const std::vector<double> before = scan(2), after = scan(2.5);
  isopach::CompareOptions options;
  options.weight = {isopach::WeightSource::Kind::attribute, isopach::WeightSource::Scan::b, "quality"};
  const isopach::Comparison c = isopach::compare(view_of(before), view_of(after), options, {});
  std::cout << "mean d " << c.measures.difference.mean << " m, net by quality " << c.weighted->net << " m³\n";
  return std::abs(c.measures.difference.mean - 0.5) < 1e-9 ? 0 : 1;
} catch (const isopach::Error& error) {
  std::cerr << error.what() << "\n";
  return static_cast<int>(error.code());
}
