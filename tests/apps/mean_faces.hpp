// Faces that the search for a face knows: the mean face of its template at 150 mm, sampled at random places with noise,
// with what is added to it; then turned and shifted. x > 0 is the patient's left.
#pragma once
#include "isopach/apps/face_template.hpp"
#include "tests/apps/faces.hpp"

namespace isopach::test {

inline Cloud mean_face_scan(const FaceScan& scan) {
  constexpr double width = 150;
  const RandomStream random(scan.seed, 7);
  Cloud cloud;
  for (std::uint64_t i = 0; cloud.points.size() < scan.points && i < 10 * scan.points; ++i) {
    const double x = 144 * (random.uniform(4 * i) - .5), y = 166 * (random.uniform(4 * i + 1) - .5);
    if (std::hypot(x / 74, y / 86) >= 1 || !scan.seen(x, y)) continue;
    const double noise = scan.noise * random.normal(2 * i + 1);
    cloud.points.push_back({x, y, width * mean_face(x / width, y / width) + scan.added(x, y) + noise});
  }
  cloud.path = "face.ply";
  cloud.unit = cloud.vertical_unit = "mm";
  return posed(std::move(cloud), scan.pose);
}

}  // namespace isopach::test
