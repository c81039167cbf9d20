// How fast files are read and written: read_bench FOLDER [POINTS] makes random files of map coordinates in
// millimetres in FOLDER, and prints the best of five reads of each and the writes of one million points.
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>

#include "isopach/io/read.hpp"
#include "isopach/io/write.hpp"

namespace {

using isopach::Cloud;
using isopach::Context;

double seconds(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double best_of(int times, const std::function<void()>& work) {
  double best = 1e9;
  for (int i = 0; i < times; ++i) best = std::min(best, seconds(work));
  return best;
}

std::uint64_t mix(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return x ^ (x >> 31);
}

double millimetres(std::uint64_t counter, double origin, double extent) {
  const double unit = static_cast<double>(mix(counter) >> 11) * 0x1p-53;
  return std::round((origin + unit * extent) * 1000) / 1000;
}

Cloud make_cloud(std::size_t points) {
  Cloud cloud;
  cloud.points.resize(points);
  for (std::size_t i = 0; i < points; ++i)
    cloud.points[i] = {millimetres(3 * i + 1, 501000, 1000), millimetres(3 * i + 2, 5401000, 1000),
                       millimetres(3 * i + 3, 400, 100)};
  return cloud;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  const std::string folder = argv[1];
  const Context context;
  const Cloud cloud = make_cloud(argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 4'000'000);
  const Cloud million = make_cloud(1'000'000);
  for (const char* const end : {".xyz", ".csv", ".ply", ".pcd", ".obj"}) {
    const std::string path = folder + "/read_bench" + end;
    const double write_million = best_of(3, [&] { isopach::write_cloud(path, million, context); });
    isopach::write_cloud(path, cloud, context);
    std::size_t points = 0;
    const double read = best_of(5, [&] { points = isopach::read_cloud(path, {}, context).points.size(); });
    fmt::print("{}: {} points, {:.0f} MB, read {:.3f} s; write of 1e6 points {:.3f} s\n", end, points,
               static_cast<double>(std::filesystem::file_size(path)) / 1e6, read, write_million);
    std::filesystem::remove(path);
  }
  return 0;
}
