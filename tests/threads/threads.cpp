// What runs side by side, for the thread sanitizer to watch: every verb of the core on small scenes, by one thread and
// by several, which must give the same bits. Built by --preset tsan, where threads are plain ones (base/parallel.hpp);
// needs the core alone. Exit code 1 where results differ; 66, the sanitizer's, where threads race.
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "isopach/apps/asymmetry.hpp"
#include "isopach/apps/roughness.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/distance/distance.hpp"
#include "isopach/match/match.hpp"
#include "isopach/simulate/scene.hpp"

using namespace isopach;

namespace {

bool failed = false;

/// f(context), by one thread and by four.
template <class F>
void same(const std::string& name, F&& f) {
  Context one, four;
  one.threads = 1, four.threads = 4;
  const auto first = f(one), second = f(four);
  const bool equal = first == second;
  std::printf("%s: %s\n", name.c_str(), equal ? "the same" : "DIFFERS with the number of threads");
  std::fflush(stdout);
  failed = failed || !equal;
}

std::vector<double> numbers(const Comparison& c) {
  const Volume& v = c.measures.volume;
  return {c.measures.area, c.measures.rho, v.above, v.below, c.measures.difference.median, c.coverage, c.trimmed_area};
}
std::vector<double> numbers(const Pose& pose) { return {pose.m.begin(), pose.m.end()}; }

Scene scene(const std::string& name, std::size_t points, double noise) {
  SceneOptions o;
  o.points_a = points, o.points_b = points + points / 5;
  o.noise_a = o.noise_b = noise;
  return make_scene(name, o, {});
}

void comparisons(const Scene& s) {
  for (const LocateMethod locate : {LocateMethod::tree, LocateMethod::order, LocateMethod::interface})
    same("compare", [&](const Context& context) {
      CompareOptions o;
      o.locate = locate;
      o.noise_floor = true;
      o.uncertainty.model = UncertaintyModel::correlated;
      o.uncertainty.sigma1 = o.uncertainty.sigma2 = {SigmaSource::Kind::constant, 0.05, ""};
      o.uncertainty.correlation_range = 20;
      return numbers(compare(s.a, s.b, o, context));
    });
  same("compare, overlay", [&](const Context& context) {
    CompareOptions o;
    o.surface = Surface::overlay;
    return numbers(compare(s.a, s.b, o, context));
  });
  same("compare, cubic", [&](const Context& context) {
    CompareOptions o;
    o.interpolation = Interpolation::cubic;
    return numbers(compare(s.a, s.b, o, context));
  });
  same("compare, currents", [&](const Context& context) {
    CompareOptions o;
    o.measure = MeasureKind::currents;
    o.currents.sigma = 30;
    return numbers(compare(s.a, s.b, o, context));
  });
}

void matchings(const Scene& s) {
  for (const Objective objective : {Objective::measure, Objective::icp_plane, Objective::icp_point})
    same("match", [&](const Context& context) {
      MatchOptions o;
      o.objective = objective;
      return numbers(match(s.b, s.a, o, context).pose);
    });
  same("match, coarse", [&](const Context& context) {
    MatchOptions o;
    o.coarse = true;
    return numbers(match(s.b, s.a, o, context).pose);
  });
}

}  // namespace

int main() {
  const Scene relief = scene("relief", 3000, 0.05), face = scene("face", 4000, 0.05), skin = scene("skin", 4000, 0.01);
  comparisons(relief);
  matchings(relief);
  same("distance", [&](const Context& context) {
    DistanceOptions o;
    o.measures = {};
    o.measures.c2s = o.measures.hausdorff = true;
    const Distances d = distance(relief.a, relief.b, std::nullopt, o, context);
    return std::vector<double>{d.c2s->a_to_b.mean, d.c2s->b_to_a.rms, d.hausdorff->a_to_b.upper};
  });
  same("asymmetry", [&](const Context& context) {
    AsymmetryOptions o;
    o.orientation = FaceOrientation::given;  // along z
    o.accept_doubt = true;
    return std::vector<double>{asymmetry(face.a, o, context).index.percent};
  });
  same("roughness", [&](const Context& context) {
    const Roughness r = roughness(skin.a, std::nullopt, std::nullopt, {}, context);
    return std::vector<double>{r.scan.parameters.sq, r.scan.parameters.sa};
  });
  return failed ? 1 : 0;
}
