// Fuzz target: `isopach distance` in memory, with its summary and its JSON.
#include "isopach/distance/distance.hpp"
#include "isopach/report/distance.hpp"
#include "tests/fuzz/decode.hpp"

namespace {

using namespace isopach;

DistanceOptions decode_options(fuzz::Input& in) {
  DistanceOptions options;
  options.project = fuzz::decode_projection(in);
  options.pose = fuzz::decode_pose(in);
  DistanceMeasures& m = options.measures;
  for (bool* const asked : {&m.c2c, &m.c2s, &m.normal, &m.vertical, &m.hausdorff, &m.m3c2}) *asked = in.flag();
  m.surface = in.below(8) == 7;  // 20 000 samples
  options.mesh = in.choice({MeshSource::automatic, MeshSource::delaunay, MeshSource::faces});
  options.border = in.choice({BorderRule::trim, BorderRule::hull});
  if (in.below(8) == 7) options.max_edge = in.length();
  options.tolerance = in.flag() ? in.length() : 0.5;
  options.samples = 1 + in.below(3);
  options.m3c2 = {in.length(), in.length(), in.length(), in.flag() ? in.length() : 0};
  return options;
}

void check(const Figures& f) {
  fuzz::require_finite("figures", {f.mean, f.rms, f.max, f.median, f.p95, f.signed_mean, f.signed_std});
}

void check(const Distances& d) {
  for (const auto* both : {&d.c2c, &d.c2s, &d.normal, &d.vertical})
    if (*both) check((*both)->a_to_b), check((*both)->b_to_a);
  if (d.surface) fuzz::require_finite("surface", {d.surface->a_to_b.mean, d.surface->b_to_a.rms});
  if (d.hausdorff) {
    const HausdorffBound &there = d.hausdorff->a_to_b, &back = d.hausdorff->b_to_a;
    fuzz::require_finite("hausdorff", {there.lower, there.upper, back.lower, back.upper});
    fuzz::require(there.lower <= there.upper && back.lower <= back.upper, "bounds are in order");
  }
  if (d.m3c2) check(d.m3c2->figures);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input in(data, size);
  fuzz::only_errors([&] {
    const Cloud a = fuzz::decode_cloud(in);
    const Cloud b = fuzz::decode_cloud(in);
    const DistanceOptions options = decode_options(in);
    const bool own_cores = in.below(4) == 3;
    const Cloud cores = own_cores ? fuzz::decode_cloud(in) : Cloud{};
    const Distances d =
        distance(a, b, own_cores ? std::optional<CloudView>(cores) : std::nullopt, options, fuzz::one_thread());
    check(d);
    fuzz::require(!distance_json(d, {}).empty() && !distance_text(d).empty(), "there is a report");
  });
  return 0;
}
