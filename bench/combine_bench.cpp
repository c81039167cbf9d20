// How well `combine` does where the truth is known: combine_bench [POINTS], writes the table of docs/use/combine.md.
// Scene `combine` of `simulate`: errors of the jaw's place against the truth, and what the result says of them itself.
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <ctime>
#include <numbers>

#include "isopach/apps/combine.hpp"
#include "isopach/apps/motions.hpp"
#include "isopach/base/option_key.hpp"
#include "isopach/simulate/face_and_jaw.hpp"

int main(int argc, char** argv) {
  using namespace isopach;
  FaceAndJawOptions o;
  if (argc > 1) o.points = static_cast<std::size_t>(std::atol(argv[1]));
  fmt::print(
      "| noise, mm | seed | object in face, in jaw | error of the rotation, degrees | error at the jaw's "
      "middle, mm | stated: degrees, mm | CPU s |\n|---|---|---|---|---|---|---|\n");
  for (const double noise : {0.05, 0.1})
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      o.noise = noise;
      const FaceAndJaw s = make_face_and_jaw(o, seed);
      const double start = static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
      try {
        const Combination c = combine(s.face, s.jaw, s.reference, {}, {});
        const double used = static_cast<double>(std::clock()) / CLOCKS_PER_SEC - start;
        const Point3 w = rotation_vector(composed(c.face_jaw, inverted(s.face_jaw)));
        const Point3 p = inverted(c.face_jaw).apply(c.jaw_middle), a = c.jaw_middle, b = s.face_jaw.apply(p);
        fmt::print("| {:g} | {} | {:.1f} %, {:.1f} % | {:.4f} | {:.4f} | {:.4f}, {:.4f} | {:.2f} |\n", noise, seed,
                   100 * s.face_share, 100 * s.jaw_share, std::hypot(w.x, w.y, w.z) * 180 / std::numbers::pi,
                   std::hypot(a.x - b.x, a.y - b.y, a.z - b.z), c.sigma_angle * 180 / std::numbers::pi, c.sigma_middle,
                   used);
      } catch (const Error& error) {
        fmt::print("| {:g} | {} | {} |\n", noise, seed, for_shell(error.what()));
      }
      std::fflush(stdout);
    }
  return 0;
}
