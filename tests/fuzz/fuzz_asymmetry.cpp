// Fuzz target: `isopach asymmetry` in memory, with its summary and its JSON, of any cloud and of a simulated face.
#include "isopach/apps/asymmetry.hpp"
#include "isopach/report/asymmetry.hpp"
#include "isopach/simulate/scene.hpp"
#include "tests/fuzz/decode.hpp"

namespace {

using namespace isopach;

AsymmetryOptions decode_options(fuzz::Input& in) {
  AsymmetryOptions options;
  fuzz::decode_scans(in, options.compare);
  options.compare.pose = {};
  options.orientation = in.choice({FaceOrientation::given, FaceOrientation::given, FaceOrientation::found});
  if (in.below(4) == 3) {
    const double x = in.number(), y = in.number();
    options.across = Point3{x, y, in.number()};
  }
  if (options.orientation == FaceOrientation::found && in.below(4) == 3)
    options.stable = {in.choice({StablePart::forehead, StablePart::nose, StablePart::chin})};
  if (in.below(4) == 3) options.rim = in.length();
  if (in.below(4) == 3) options.depth = in.length();
  options.visible = in.flag();
  options.parts = in.choice({FaceParts::thirds, FaceParts::halves});
  if (in.below(8) == 7) options.polygons = fuzz::decode_polygons(in);
  if (in.flag()) options.overlap = in.share();
  options.max_iterations = 1 + static_cast<int>(in.below(8));
  options.accept_doubt = in.flag();
  return options;
}

Cloud decode_face(fuzz::Input& in) {
  if (in.flag()) return fuzz::decode_cloud(in);
  SceneOptions scene;
  scene.points_a = 300 + in.byte(), scene.points_b = 100;
  scene.noise_a = in.byte() / 64.0;
  Cloud face = make_scene("face", scene, fuzz::one_thread()).a;
  fuzz::damage(in, face);
  return face;
}

void check(const Asymmetry& a) {
  const Point3 &n = a.plane.normal, &p = a.plane.point;
  fuzz::require_finite("plane", {n.x, n.y, n.z, p.x, p.y, p.z, a.plane.offset, a.plane.twist, a.plane.glide});
  fuzz::require_finite("index", {a.index.percent, a.index.raw, a.index.floor, a.index.size});
  for (const SideDifference& side : a.regions)
    fuzz::require_finite("side", {side.area, side.directional, side.absolute, side.rms, side.largest});
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input in(data, size);
  fuzz::only_errors([&] {
    const AsymmetryOptions options = decode_options(in);
    const Asymmetry a = asymmetry(decode_face(in), options, fuzz::one_thread());
    check(a);
    fuzz::require(!asymmetry_json(a, {}).empty() && !asymmetry_text(a).empty(), "there is a report");
  });
  return 0;
}
