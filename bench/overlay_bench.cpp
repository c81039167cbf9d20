// The exact overlay beside the common triangulation: overlay_bench [LARGEST], on one thread, CPU time, medians of five
// (of three above 10⁶ nodes).
// Uniform nodes, N in each mesh, with heights of a relief or of white noise; both start from T1 and T2 and share
// localisation and interpolation.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <vector>

#include "isopach/base/parallel.hpp"
#include "isopach/base/random.hpp"
#include "isopach/delaunay/spanning_tree.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/measure/source.hpp"
#include "isopach/overlay/common.hpp"
#include "isopach/overlay/interpolate.hpp"
#include "isopach/overlay/localise.hpp"

namespace {

using namespace isopach;

struct Mesh {
  Array<Point2> xy;
  Array<double> z;
  Triangulation t;
};

constexpr CurveBox unit_square{{0, 0}, 0x1p32};

Mesh uniform_mesh(std::size_t n, std::uint64_t seed, bool relief) {
  const RandomStream x(seed, 1), y(seed, 2), z(seed, 3);
  Array<Point2> points(n);
  for (std::size_t i = 0; i < n; ++i) points[i] = {x.uniform(i), y.uniform(i)};
  Mesh mesh;
  for (const Index i : curve_order(points, unit_square)) mesh.xy.push_back(points[i]);
  for (std::size_t i = 0; i < n; ++i) {
    const Point2& p = mesh.xy[i];
    mesh.z.push_back(relief ? 0.1 * std::sin(9 * p.x) * std::cos(7 * p.y) +
                                  0.002 * static_cast<double>(seed) * std::sin(40 * p.x + 25 * p.y) + 1e-5 * z.normal(i)
                            : z.uniform(i) + p.x);
  }
  mesh.t = triangulate(mesh.xy, unit_square, {});
  return mesh;
}

struct Times {
  std::vector<double> seconds;
  void add(const std::function<void()>& work) {
    const std::clock_t start = std::clock();
    work();
    seconds.push_back(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  [[nodiscard]] double median() {
    std::sort(seconds.begin(), seconds.end());
    return seconds[seconds.size() / 2];
  }
};

void run(std::size_t n, bool relief) {
  const Mesh a = uniform_mesh(n, 1, relief), b = uniform_mesh(n, 2, relief);
  Times locate, united, measured, overlay, overlay_measured;
  std::size_t cells = 0;
  double above = 0, common_above = 0;
  for (int repeat = 0; repeat < (n > 1'000'000 ? 3 : 5); ++repeat) {
    Locations a_in_b, b_in_a;
    Array<double> b_at_a, a_at_b;
    locate.add([&] {
      a_in_b = localise(a.xy, spanning_tree(a.t, a.xy, {}), b.t, b.xy, {});
      b_in_a = localise(b.xy, spanning_tree(b.t, b.xy, {}), a.t, a.xy, {});
      b_at_a = interpolate(a_in_b, a.xy, b.t, b.xy, b.z, {});
      a_at_b = interpolate(b_in_a, b.xy, a.t, a.xy, a.z, {});
    });
    UnitedNodes g;
    Triangulation t;
    united.add([&] {
      g = unite(a.xy, b.xy, unit_square);
      t = triangulate(g.xy, unit_square, {});
    });
    measured.add([&] {
      Array<double> z1(g.xy.size()), z2(g.xy.size());
      for (std::size_t i = 0; i < g.xy.size(); ++i) {
        z1[i] = g.of_1[i] != no_index ? a.z[g.of_1[i]] : a_at_b[g.of_2[i]];
        z2[i] = g.of_2[i] != no_index ? b.z[g.of_2[i]] : b_at_a[g.of_1[i]];
      }
      const Array<unsigned char> all(t.real, 1);
      common_above = measure(CellView{t, g.xy, z1, z2, all}, {}).volume.above;
    });
    const OverlayMesh m1{a.t, a.xy, a.z, a_in_b, b_at_a}, m2{b.t, b.xy, b.z, b_in_a, a_at_b};
    overlay.add([&] { above = sum_up(Overlay(m1, m2, {}), {}).volume.above; });
    if (repeat < 3) overlay_measured.add([&] { (void)measure(Overlay(m1, m2, {}), {}); });
    if (repeat > 0) continue;
    const Overlay whole(m1, m2, {});
    Overlay::Scratch scratch;
    for (std::size_t i = 0; i < whole.items(); ++i) cells += whole.cells(i, scratch).size();
  }
  const double per = 1e9 / static_cast<double>(2 * n);
  const double shared = locate.median(), common = shared + united.median() + measured.median();
  fmt::print(
      "N {:>8}, {}: trees, locations, heights {:.0f} ns per node; T {:.0f}; its measure {:.0f}; overlay {:.0f} ({:.2f} "
      "cells "
      "per node of one mesh, {:.0f} ns per cell); with all statistics {:.0f}; overlay / common after triangulation "
      "{:.2f}, with all statistics {:.2f}; above {:.6g}, common {:.6g}\n",
      n, relief ? "relief" : "white noise", shared * per, united.median() * per, measured.median() * per,
      overlay.median() * per, static_cast<double>(cells) / static_cast<double>(n),
      1e9 * overlay.median() / static_cast<double>(cells), overlay_measured.median() * per,
      (shared + overlay.median()) / common, (shared + overlay_measured.median()) / common, above, common_above);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const std::size_t largest = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 1'000'000;
  run_with_threads(1, [&] {
    for (const std::size_t n : {10'000, 100'000, 300'000, 1'000'000, 4'000'000})
      for (const bool relief : {true, false})
        if (n <= largest) run(n, relief);
  });
  return 0;
}
