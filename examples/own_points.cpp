// A format of one's own: points from the caller's arrays, with a weight for each of them.
#include <cmath>
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

int main() try {
  std::vector<Beam> beams;  // level ground, 2 m below the scanner
  for (float elevation = -1.2F; elevation < -0.3F; elevation += 0.01F)
    for (float azimuth = 0; azimuth < 6.28F; azimuth += 0.01F)
      beams.push_back({-2 / std::sin(elevation), azimuth, elevation, azimuth < 3.14F ? 1.F : 0.5F});
  isopach::CompareOptions options;
  options.weight = {isopach::WeightSource::Kind::attribute, isopach::WeightSource::Scan::b, "quality"};
  const isopach::Comparison c = isopach::compare(cloud_of(beams, 2), cloud_of(beams, 2.5), options, {});
  std::cout << "mean d " << c.measures.difference.mean << " m, net by quality " << c.weighted->net << " m³\n";
  return std::abs(c.measures.difference.mean - 0.5) < 1e-6 ? 0 : 1;
} catch (const isopach::Error& error) {
  std::cerr << error.what() << "\n";
  return static_cast<int>(error.code());
}
