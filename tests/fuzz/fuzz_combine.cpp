// Fuzz target: `isopach combine` in memory, with its summary and its JSON: any clouds, and a simulated face and jaw
// with their object, damaged.
#include "isopach/apps/combine.hpp"
#include "isopach/report/combine.hpp"
#include "isopach/simulate/face_and_jaw.hpp"
#include "tests/fuzz/decode.hpp"

namespace {

using namespace isopach;

struct Scans {
  Cloud face, jaw, reference;
};

Scans decode_scans(fuzz::Input& in, CombineOptions& options) {
  if (in.below(4) != 0) {
    Scans scans{fuzz::decode_cloud(in), {}, {}};
    scans.jaw = in.flag() ? scans.face : fuzz::decode_cloud(in);
    scans.reference = in.flag() ? scans.face : fuzz::decode_cloud(in);
    return scans;
  }
  FaceAndJawOptions simulated;
  simulated.points = 3000 + in.byte();  // fewer do not hold the object
  simulated.noise = in.byte() / 256.0;
  simulated.held = in.below(8) != 7;
  FaceAndJaw made = make_face_and_jaw(simulated, 1);
  if (!options.start_face) options.start_face = made.face_reference;  // a search takes seconds
  if (!options.start_jaw) options.start_jaw = made.jaw_reference;
  for (Cloud* const cloud : {&made.face, &made.jaw, &made.reference}) fuzz::damage(in, *cloud);
  return {std::move(made.face), std::move(made.jaw), std::move(made.reference)};
}

CombineOptions decode_options(fuzz::Input& in) {
  CombineOptions options;
  if (in.flag()) options.least_share = in.share();
  if (in.below(4) == 3) options.start_face = fuzz::decode_pose(in);
  if (in.below(4) == 3) options.start_jaw = fuzz::decode_pose(in);
  if (in.flag()) options.unit = "mm";
  return options;
}

void check(const Combination& c) {
  for (const Pose* const pose : {&c.face.pose, &c.jaw.pose, &c.face_jaw})
    for (const double entry : pose->m) fuzz::require_finite("pose", {entry});
  fuzz::require_finite("combination", {c.face.rms, c.face.share, c.jaw.rms, c.jaw.share, c.sigma_angle, c.sigma_middle,
                                       c.sigma_farthest, c.centre.x, c.jaw_middle.x});
  fuzz::require(c.points.size() == c.part.size(), "a point has a part");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input in(data, size);
  fuzz::only_errors([&] {
    CombineOptions options = decode_options(in);
    const Scans scans = decode_scans(in, options);
    const Combination c = combine(scans.face, scans.jaw, scans.reference, options, fuzz::one_thread());
    check(c);
    fuzz::require(!combine_json(c, {}).empty() && !combine_text(c).empty(), "there is a report");
  });
  return 0;
}
