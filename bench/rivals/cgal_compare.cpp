// The straightforward program as a process: cgal_compare A.ply B.ply, binary little-endian with x y z as doubles, as
// the benchmark writes them. Prints area and volumes.
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/rivals/rival.hpp"

namespace {

std::vector<isopach::Point3> read(const char* path) {
  std::ifstream file(path, std::ios::binary);
  std::size_t count = 0;
  for (std::string line; std::getline(file, line) && line != "end_header";)
    if (line.rfind("element vertex ", 0) == 0) count = std::strtoull(line.c_str() + 15, nullptr, 10);
  std::vector<isopach::Point3> points(count);
  file.read(reinterpret_cast<char*>(points.data()), static_cast<std::streamsize>(count * sizeof(isopach::Point3)));
  if (!file || count == 0) throw std::runtime_error(std::string(path) + ": no such PLY file as the benchmark writes");
  return points;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) return 2;
  const auto a = read(argv[1]), b = read(argv[2]);
  const auto v = isopach::bench::rival::compare(a, b);
  std::printf("%.17g %.17g %.17g\n", v.area, v.above, v.below);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
