// A chewing face, frame by frame, as a scanner in front of it sees it: the upper face moves with the head, the lower
// one with the jaw as well (hinge and translation), the skin between them follows by a blend of the two. mm, the face
// of the scene `face`: x to the viewer's right, y up, z to the viewer.
//
// A point p of the face at rest is at head(k) · ((1 − blend) p + blend · jaw(k) p) in frame k. Every frame samples the
// face anew; what is turned away from the scanner is not seen; the open mouth is a hole. Noise is along z.
// Tests: tests/simulate/chewing_test.cpp
#pragma once
#include <functional>

#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud.hpp"
#include "isopach/geom/rigid.hpp"
#include "isopach/simulate/sampling.hpp"

namespace isopach {

struct ChewingOptions {
  std::size_t frames = 60;
  std::size_t points = 50000;  ///< about, a frame: a few per cent are turned away
  double noise = 0.05;         ///< standard deviation along z, mm
  double opening = 18;         ///< of the jaw at its widest, degrees
  std::size_t frames_a_cycle = 20;
};

class Chewing {
 public:
  /// Errors: UsageError, naming the number, for no frames, fewer than 100 points, more than max_nodes, a noise that is
  /// negative or not finite, an opening outside (0, 40], cycles of fewer than 2 frames.
  Chewing(const ChewingOptions& options, std::uint64_t seed);

  [[nodiscard]] std::size_t frames() const { return options_.frames; }

  /// Frame k as the scanner gives it, with the true `blend` as an attribute. A function of (options, seed, k); the same
  /// bits for any number of threads. Cost O(points).
  [[nodiscard]] Cloud frame(std::size_t k) const;

  /// T_frame_rest of the head; the identity for frame 0.
  [[nodiscard]] Pose head(std::size_t k) const;
  /// The jaw relative to the head, in the coordinates of the face at rest; the identity for frame 0.
  [[nodiscard]] Pose jaw(std::size_t k) const;

  /// 0: moves with the head, 1: with the jaw; strictly between them within the transition zone.
  [[nodiscard]] static double blend(double x, double y);

  /// What the jaw turns about before it slides: along x through this point.
  static constexpr Point3 hinge{0, 0, 10};

 private:
  [[nodiscard]] double phase(std::size_t k) const;

  ChewingOptions options_;
  std::uint64_t seed_;
  std::function<double(double, double)> height_;
  Outline footprint_;
};

}  // namespace isopach
