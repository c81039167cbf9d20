// Points of one's own, with a weight for each of them: computed into a cloud, or in an array that is used where it
// lies.
#include <cmath>
#include <cstddef>
#include <iostream>
#include <vector>

#include "isopach/compare/compare.hpp"

struct Beam {  // as the caller's own library gives it: range and two angles
  float range, azimuth, elevation, quality;
};

isopach::Cloud cloud_of(const std::vector<Beam>& beams, double height_of_scanner) {
  isopach::Cloud cloud;
  cloud.unit = cloud.vertical_unit = "m";
  cloud.attributes.push_back({"quality", {}});
  for (const Beam& b : beams) {
    const double level = b.range * std::cos(b.elevation);
    cloud.points.push_back({level * std::cos(b.azimuth), level * std::sin(b.azimuth),
                            height_of_scanner + b.range * std::sin(b.elevation)});
    cloud.attributes[0].values.push_back(b.quality);
  }
  return cloud;
}

/// Rows of x, y, z, quality, as another library keeps them: a view of them copies nothing.
isopach::CloudView view_of(const std::vector<double>& rows) {
  constexpr std::size_t width = 4;
  const std::size_t points = rows.size() / width;
  isopach::CloudView view{isopach::PointsView(rows.data(), points, width)};
  view.attributes = {{"quality", {rows.data() + 3, points, width}}};
  view.unit = view.vertical_unit = "m";
  return view;
}

int main() try {
  std::vector<Beam> beams;  // level ground, 2 m below the scanner
  for (float elevation = -1.2F; elevation < -0.3F; elevation += 0.01F)
    for (float azimuth = 0; azimuth < 6.28F; azimuth += 0.01F)
      beams.push_back({-2 / std::sin(elevation), azimuth, elevation, azimuth < 3.14F ? 1.F : 0.5F});
  isopach::CompareOptions options;
  options.weight = {isopach::WeightSource::Kind::attribute, isopach::WeightSource::Scan::b, "quality"};
  const isopach::Cloud ground = cloud_of(beams, 2);
  const isopach::Comparison c = isopach::compare(ground, cloud_of(beams, 2.5), options, {});
  std::cout << "mean d " << c.measures.difference.mean << " m, net by quality " << c.weighted->net << " m³\n";

  std::vector<double> rows;  // the same ground, 0.25 m higher
  for (std::size_t i = 0; i < ground.points.size(); ++i) {
    const isopach::Point3& p = ground.points[i];
    rows.insert(rows.end(), {p.x, p.y, p.z + 0.25, ground.attributes[0].values[i]});
  }
  const isopach::Comparison of_rows = isopach::compare(ground, view_of(rows), options, {});
  std::cout << "mean d of the rows " << of_rows.measures.difference.mean << " m\n";
  const auto near = [](double value, double wanted) { return std::abs(value - wanted) < 1e-6; };
  return near(c.measures.difference.mean, 0.5) && near(of_rows.measures.difference.mean, 0.25) ? 0 : 1;
} catch (const isopach::Error& error) {
  std::cerr << error.what() << "\n";
  return static_cast<int>(error.code());
}
