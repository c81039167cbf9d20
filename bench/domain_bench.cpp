// What polygons cost: domain_bench [POINTS [POLYGONS [ROUNDS]]], the ratio in docs/use/domain.md. CPU time of a
// comparison with --budget and with --include over that without, medians of rounds that take turns. The polygons are
// quadrangles with shared sides that cover the scans.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "isopach/base/random.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/io/polygons.hpp"
#include "isopach/simulate/scene.hpp"

namespace {

using namespace isopach;

double seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

void write_quadrangles(const std::string& path, const Box3& box, std::size_t n) {
  const RandomStream random(1, 1);
  const auto corner = [&](std::size_t i, std::size_t j) {
    const auto at = [&](std::size_t k, double low, double high, std::uint64_t draw) {
      const double step = (high - low) / static_cast<double>(n);
      const double moved = k == 0 || k == n ? 0 : 0.6 * (random.uniform(draw) - 0.5);
      return low + (static_cast<double>(k) + moved) * step;
    };
    const std::uint64_t draw = 2 * (j * (n + 1) + i);
    return fmt::format("[{},{}]", at(i, box.min.x, box.max.x, draw), at(j, box.min.y, box.max.y, draw + 1));
  };
  std::ofstream out(path);
  out << R"({"type":"FeatureCollection","features":[)";
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t i = 0; i < n; ++i)
      out << (i + j > 0 ? "," : "")
          << R"({"type":"Feature","properties":{},"geometry":{"type":"Polygon","coordinates":[[)" << corner(i, j) << ","
          << corner(i + 1, j) << "," << corner(i + 1, j + 1) << "," << corner(i, j + 1) << "," << corner(i, j)
          << "]]}}";
  out << "]}";
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

}  // namespace

int main(int argc, char** argv) {
  const auto number = [&](int i, double fallback) { return argc > i ? std::atof(argv[i]) : fallback; };
  SceneOptions scene_options;
  scene_options.points_a = scene_options.points_b = static_cast<std::size_t>(number(1, 1e6));
  const Scene scene = make_scene("terrain", scene_options, {});
  Box3 box;
  for (const Point3& p : scene.a.points) box.add(p);
  for (const Point3& p : scene.b.points) box.add(p);
  const auto n = static_cast<std::size_t>(std::ceil(std::sqrt(number(2, 1000))));
  const std::string path = (std::filesystem::temp_directory_path() / "isopach-domain-bench.geojson").string();
  write_quadrangles(path, box, n);

  std::vector<double> plain, with_budget, with_include;
  double worst = 0;
  for (int round = 0; round < static_cast<int>(number(3, 5)); ++round) {
    const auto timed = [&](std::vector<double>& times, const AreaOptions& area) {
      CompareOptions options;
      options.area = area;
      const double start = seconds();
      Comparison c = compare(scene.a, scene.b, options, {});
      times.push_back(seconds() - start);
      if (c.budget.empty()) return;
      double net = 0;
      for (const BudgetRow& row : c.budget) net += row.volume.net;
      worst = std::max(worst, std::fabs(net - c.measures.volume.net) / c.measures.volume.absolute);
    };
    timed(plain, {});
    timed(with_budget, {{}, {}, {read_polygons(path)}, {}});
    timed(with_include, {{read_polygons(path)}, {}, {}, {}});
  }
  std::filesystem::remove(path);
  fmt::print("{} polygons, {} + {} points: CPU time with --budget {:.2f}, with --include {:.2f} times that without\n",
             n * n, scene.a.points.size(), scene.b.points.size(), median(with_budget) / median(plain),
             median(with_include) / median(plain));
  fmt::print("sum of the rows' net against the whole: {:.1e} of the gross at most\n", worst);
  return 0;
}
