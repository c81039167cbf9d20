// Currents: what was missed against what was asked for, the time beside the direct sum, and growth. Writes the tables
// of docs/method/currents.md: currents_bench [errors|speed|growth]. Two scans of one rough relief with noise; CPU time,
// all threads together.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/field/height_field.hpp"
#include "isopach/measure/currents/current.hpp"
#include "isopach/simulate/scene.hpp"

namespace {

using namespace isopach;

struct Pair {
  SurfaceCurrent a, b;
  double edge;
};

/// Nearly `triangles` of each.
Pair scans(std::size_t triangles) {
  SceneOptions o;
  o.points_a = o.points_b = triangles / 2;
  o.noise_a = o.noise_b = 0.02;
  o.variant = "rough";
  const Scene s = make_scene("relief", o, {});
  const Frame frame = choose_frame(s.a, s.b, {}, {}, {});
  const auto current = [&](const Cloud& cloud) {
    const HeightField h = project(cloud, {}, frame, {}, {});
    const Triangulation t = triangulate(h.xy, frame.curve, {});
    return surface_current(t, h.xy, h.z, {});
  };
  Pair p{current(s.a), current(s.b), 0};
  p.edge = std::max(p.a.mean_edge, p.b.mean_edge);
  return p;
}

double seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

struct Timed {
  Currents c;
  double time;
};
Timed timed(const Pair& p, const CurrentsOptions& o) {
  const double start = seconds();
  const Currents c = currents(p.a.view(), p.b.view(), o, {});
  return {c, seconds() - start};
}

void errors() {
  const Pair p = scans(10000);
  fmt::print(
      "{} + {} triangles\n\n| σ / mean edge | asked for | ‖A‖², relative | ⟨A, B⟩, to the norms | ρ, to its bound |\n"
      "|---|---|---|---|---|\n",
      p.a.centroids.size(), p.b.centroids.size());
  for (const double edges : {0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0}) {
    const Currents exact = timed(p, {edges * p.edge, 1e-6, CurrentsMethod::direct}).c;
    for (const double error : {1e-3, 1e-6, 1e-9}) {
      const Currents c = timed(p, {edges * p.edge, error}).c;
      const double norms = std::sqrt(exact.norm_a2 * exact.norm_b2);
      fmt::print("| {} | {:.0e} | {:.1e} | {:.1e} | {:.2f} |{}\n", edges, error,
                 std::fabs(c.norm_a2 - exact.norm_a2) / exact.norm_a2, std::fabs(c.inner - exact.inner) / norms,
                 std::fabs(c.rho - exact.rho) / (c.error_bound + exact.error_bound), c.reached ? "" : " NOT REACHED");
    }
  }
}

double pairs(const Pair& p) {
  return 0.5 * std::pow(static_cast<double>(p.a.centroids.size() + p.b.centroids.size()), 2);
}

/// The direct sum is timed on a fifth of the triangles: a pair costs the same whatever their number.
void speed(std::size_t n) {
  const Pair p = scans(n), few = scans(n / 5);
  const double a_pair = timed(few, {5 * few.edge, 1e-6, CurrentsMethod::direct}).time / pairs(few);
  const double direct = a_pair * pairs(p);
  fmt::print(
      "{} + {} triangles, error 1e-6; direct sum: {:.1f} ns a pair on {} + {} triangles, {:.0f} s of all\n\n"
      "| σ / mean edge | CPU s | direct sum over it |\n|---|---|---|\n",
      p.a.centroids.size(), p.b.centroids.size(), 1e9 * a_pair, few.a.centroids.size(), few.b.centroids.size(), direct);
  for (const double edges : {0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0}) {
    const double time = timed(p, {edges * p.edge, 1e-6}).time;
    fmt::print("| {} | {:.2f} | {:.0f} |\n", edges, time, direct / time);
  }
}

void growth() {
  fmt::print("| triangles each | CPU µs a triangle, σ = 5 mean edges | σ = 20 mean edges |\n|---|---|---|\n");
  for (const std::size_t n : {10000UL, 30000UL, 100000UL, 300000UL, 1000000UL}) {
    const Pair p = scans(n);
    const double count = static_cast<double>(p.a.centroids.size() + p.b.centroids.size());
    fmt::print("| {} | {:.1f} | {:.1f} |\n", n, 1e6 * timed(p, {5 * p.edge, 1e-6}).time / count,
               1e6 * timed(p, {20 * p.edge, 1e-6}).time / count);
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  const auto asked = [&](const char* name) { return argc < 2 || std::strcmp(argv[1], name) == 0; };
  run_with_threads(0, [&] {
    if (asked("errors")) errors();
    if (asked("speed")) speed(argc > 2 ? std::strtoul(argv[2], nullptr, 10) : 100000);
    if (asked("growth")) growth();
  });
  return 0;
}
