// SciPy (Qhull) as rival: a process, because it is not a library of ours.
#include <fmt/format.h>

#include <cstdlib>
#include <optional>
#include <sstream>

#include "bench/experiments/experiments.hpp"
#include "bench/support/inputs.hpp"
#include "bench/support/pair.hpp"
#include "bench/support/process.hpp"
#include "bench/support/timer.hpp"
#include "isopach/overlay/interpolate.hpp"
#include "isopach/overlay/localise.hpp"

namespace isopach::bench {

void scipy(const Setup& setup, Page& page) {
  constexpr std::size_t n = 100'000;
  page.heading("SciPy");
  const char* named = std::getenv("ISOPACH_PYTHON");
  const std::string script = (setup.self.parent_path() / "scipy_rival.py").string();
  const ProcessRun run =
      run_process({named != nullptr ? named : "python3", "-B", script, std::to_string(n), setup.quick ? "1" : "3"});
  std::string version;
  double delaunay_seconds = 0, interpolate_seconds = 0;
  if (!run.ok || !(std::istringstream(run.output) >> version >> delaunay_seconds >> interpolate_seconds)) {
    page.paragraph("Not measured: numpy and scipy cannot be imported by python3 (or by $ISOPACH_PYTHON).");
    return;
  }
  const Points a = uniform(n, 1), b = uniform(n, 2);
  const Pair pair = make_pair_of(a, b);
  Array<double> heights(pair.b.xy.size(), 1.0), values;
  const double ours = time_of(1, 5, [&] { (void)triangulate_unsorted(a, {}); });
  const double ours_interpolated = time_of(1, 5, [&] {
    const SpanningTree tree = spanning_tree(pair.a.t, pair.a.xy, {});
    const Locations where = localise(pair.a.xy, tree, pair.b.t, pair.b.xy, {});
    values = interpolate(where, pair.a.xy, pair.b.t, pair.b.xy, heights, {});
  });
  page.paragraph("SciPy " + version + " (Qhull) on " + count(n) +
                 " uniform points, CPU time of one thread, ns per point. Interpolation of as many other "
                 "points: isopach's tree, localisation and interpolation of a mesh; SciPy's LinearNDInterpolator.");
  page.table({{"", "isopach", "SciPy", "ratio"},
              {"Delaunay", nanoseconds(ours, n), nanoseconds(delaunay_seconds, n),
               fmt::format("{:.3f}", ours / delaunay_seconds)},
              {"linear interpolation", nanoseconds(ours_interpolated, n), nanoseconds(interpolate_seconds, n),
               fmt::format("{:.3f}", ours_interpolated / interpolate_seconds)}});
}

}  // namespace isopach::bench
