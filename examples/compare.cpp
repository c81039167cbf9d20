// Compares two scans: compare A B with files, or without arguments two simulated flights over a landslide.
#include <cmath>
#include <iostream>

#include "isopach/base/option_key.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/io/read.hpp"
#include "isopach/simulate/scene.hpp"

int main(int argc, char** argv) try {
  const isopach::Context context;  // all cores; no progress, no cancellation
  const bool files = argc == 3;
  isopach::Scene scene;
  if (files) {
    scene.a = isopach::read_cloud(argv[1], {}, context);
    scene.b = isopach::read_cloud(argv[2], {}, context);
  } else {
    scene = isopach::make_scene("terrain", isopach::scene_defaults("terrain"), context);
  }

  const isopach::Comparison c = isopach::compare(scene.a, scene.b, isopach::CompareOptions{}, context);
  const isopach::Volume& v = c.measures.volume;
  std::cout << "gained " << v.above << ", lost " << v.below << ", net " << v.net << " " << c.unit << "³ on "
            << c.domain_area << " " << c.unit << "², mean |d| " << c.measures.rho << " " << c.unit << "\n";
  for (const std::string& warning : c.warnings) std::cout << "warning: " << isopach::for_keywords(warning) << "\n";

  // Noise cancels in the net volume: within 1 % of the truth of the scene.
  return files || std::abs(v.net - scene.truth.net) < 0.01 * scene.truth.net ? 0 : 1;
} catch (const isopach::Error& error) {
  std::cerr << isopach::for_keywords(error.what()) << "\n";
  return static_cast<int>(error.code());
}
