// What the function of C++ takes for two arrays of (n, 3) doubles, for bench/python/costs.py: seconds of the wall and
// of the processor of each call, from outside, with what it frees at its end.
//   isopach-call A.ply B.ply REPEATS
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "isopach/compare/compare.hpp"
#include "isopach/io/read.hpp"

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const isopach::Context context;
  const isopach::Cloud a = isopach::read_cloud(argv[1], {}, context), b = isopach::read_cloud(argv[2], {}, context);
  for (int i = 0; i < std::atoi(argv[3]); ++i) {
    const auto begin = std::chrono::steady_clock::now();
    const std::clock_t used = std::clock();
    const isopach::Comparison c = isopach::compare(a, b, isopach::CompareOptions{}, context);
    const double cpu = static_cast<double>(std::clock() - used) / CLOCKS_PER_SEC;
    const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    std::printf("%.6f %.6f %.17g\n", wall, cpu, c.measures.volume.net);
  }
}
