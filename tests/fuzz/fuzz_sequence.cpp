// Fuzz target: `isopach sequence` in memory, with its summary and its JSON: frames of any clouds, and of a simulated
// chewing face that is damaged.
#include "isopach/apps/sequence.hpp"
#include "isopach/report/sequence.hpp"
#include "isopach/simulate/chewing.hpp"
#include "tests/fuzz/decode.hpp"

namespace {

using namespace isopach;

SequenceOptions decode_options(fuzz::Input& in) {
  SequenceOptions options;
  options.reference = in.below(8) == 7 ? in.below(6) : 0;
  options.model_points = 1500;
  if (in.flag()) options.least_part = in.share();
  const auto place = [&] {
    const double x = in.number(), y = in.number();
    return Point3{x, y, in.number()};
  };
  if (in.below(4) == 3) options.static_at = place();
  if (in.below(4) == 3) options.follow = place();
  options.smooth = in.flag() ? in.length() : 0;
  if (in.flag()) options.rate = in.length();
  return options;
}

std::vector<Cloud> decode_frames(fuzz::Input& in) {
  std::vector<Cloud> frames;
  const std::size_t count = in.below(6);
  if (in.flag()) {
    for (std::size_t k = 0; k < count; ++k) frames.push_back(fuzz::decode_cloud(in));
    return frames;
  }
  ChewingOptions options;
  options.frames = count + 1, options.frames_a_cycle = 6;
  options.points = 1500 + in.byte();  // fewer do not show what moves
  options.noise = in.byte() / 256.0;
  options.opening = 1 + in.byte() / 7.0;
  const Chewing chewing(options, 1);
  for (std::size_t k = 0; k < count; ++k) {
    frames.push_back(chewing.frame(k));
    fuzz::damage(in, frames.back());
  }
  return frames;
}

void check(const SequenceResult& r) {
  fuzz::require_finite("sequence", {r.widest, r.farthest, r.chin.x, r.chin.y, r.chin.z});
  for (const FrameMotion& f : r.frames) {
    if (!f.skipped.empty()) continue;
    fuzz::require_finite("frame", {f.time, f.rms_static, f.rms_moving, f.opening, f.angle, f.excursion});
    for (const double entry : f.motion.m) fuzz::require_finite("motion", {entry});
  }
  for (const double blend : r.blend) fuzz::require(blend >= 0 && blend <= 1, "a blend lies between 0 and 1");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input in(data, size);
  fuzz::only_errors([&] {
    const SequenceOptions options = decode_options(in);
    const std::vector<Cloud> frames = decode_frames(in);
    const FrameSource source{frames.size(), [](std::size_t k) { return std::to_string(k); },
                             [&](std::size_t k) { return frames[k]; }};
    const SequenceResult r = sequence(source, options, fuzz::one_thread());
    check(r);
    fuzz::require(!sequence_json(r, {}).empty() && !sequence_text(r).empty(), "there is a report");
  });
  return 0;
}
