// How well `sequence` does where the truth is known: chewing_bench [FRAMES [POINTS [THREADS]]], writes the table of
// docs/use/sequence.md. Scene `chewing` of `simulate`; labels outside the transition zone, errors of the motion of
// every frame, CPU time and time a frame.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <numbers>

#include "isopach/apps/motions.hpp"
#include "isopach/apps/sequence.hpp"
#include "isopach/simulate/chewing.hpp"

namespace {

using namespace isopach;

double cpu() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

void run(const ChewingOptions& o, int threads, std::uint64_t seed) {
  const Chewing chewing(o, seed);
  std::vector<Cloud> made;
  for (std::size_t k = 0; k < o.frames; ++k) made.push_back(chewing.frame(k));
  const FrameSource source{o.frames, [](std::size_t k) { return fmt::format("{}", k); },
                           [&](std::size_t k) { return made[k]; }};
  Context context;
  context.threads = threads;
  const double start = cpu();
  const SequenceResult r = sequence(source, {}, context);
  const double used = cpu() - start;
  const Array<double>& truth = made[0].find_attribute("blend")->values;
  std::size_t outside = 0, right = 0, sure = 0;
  for (std::size_t i = 0; i < r.points.size(); ++i) {
    const double b = truth[r.ids[i]];
    if (b > 0 && b < 1) continue;
    ++outside;
    right += (r.blend[i] > 0.5) == (b > 0.5);
    sure += r.label[i] == (b > 0.5 ? PartLabel::moving : PartLabel::still);
  }
  double worst_angle = 0, worst_shift = 0, sum_angle = 0, sum_shift = 0, sigma_angle = 0, sigma_shift = 0;
  std::size_t skipped = 0;
  for (const FrameMotion& f : r.frames) {
    if (!f.skipped.empty()) {
      ++skipped;
      continue;
    }
    const Pose true_motion = chewing.jaw(f.index);
    const Point3 w = rotation_vector(composed(f.motion, inverted(true_motion)));
    const double angle = std::hypot(w.x, w.y, w.z) * 180 / std::numbers::pi;
    const Point3 a = f.motion.apply(r.chin), b = true_motion.apply(r.chin);
    const double shift = std::hypot(a.x - b.x, a.y - b.y, a.z - b.z);
    worst_angle = std::max(worst_angle, angle), worst_shift = std::max(worst_shift, shift);
    sum_angle += angle * angle, sum_shift += shift * shift;
    sigma_angle += f.sigma_angle, sigma_shift += f.sigma_shift;
  }
  const auto n = static_cast<double>(r.used);
  const double degrees = 180 / std::numbers::pi;
  fmt::print(
      "| {} | {:.0f} | {:g} | {} | {:.2f} % | {:.2f} % | {:.4f}, {:.4f} ({:.4f}) | {:.4f}, {:.4f} ({:.4f}) | {:.2f} "
      "|\n",
      o.frames, static_cast<double>(made[0].points.size()), o.noise, skipped,
      100.0 * static_cast<double>(right) / static_cast<double>(outside),
      100.0 * static_cast<double>(sure) / static_cast<double>(outside), std::sqrt(sum_angle / n), worst_angle,
      degrees * sigma_angle / n, std::sqrt(sum_shift / n), worst_shift, sigma_shift / n,
      used / static_cast<double>(o.frames));
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  ChewingOptions o;
  if (argc > 1) o.frames = static_cast<std::size_t>(std::atol(argv[1]));
  if (argc > 2) o.points = static_cast<std::size_t>(std::atol(argv[2]));
  const int threads = argc > 3 ? std::atoi(argv[3]) : 2;
  fmt::print(
      "| frames | points a frame | noise, mm | skipped | nearer part right | labels right | error of the "
      "angle, degrees: RMS, worst (stated) | error of the point, mm: RMS, worst (stated) | CPU s a frame "
      "|\n|---|---|---|---|---|---|---|---|---|\n");
  for (const double noise : {0.05, 0.1}) {
    o.noise = noise;
    run(o, threads, 1);
  }
  return 0;
}
