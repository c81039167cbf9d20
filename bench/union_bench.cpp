// The three ways to make the common triangulation T: union_bench [N [THREADS]]. Prints the table of
// docs/method/localisation.md: two sets, T from scratch in ns per node of the union, and linear merging, insertion and
// what isopach chooses as shares of that. Medians, the ways taking turns; one thread by its CPU time, two by the wall
// clock.
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/support/inputs.hpp"
#include "bench/support/pair.hpp"
#include "bench/support/timer.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/overlay/insert.hpp"
#include "isopach/overlay/localise.hpp"
#include "isopach/overlay/merge.hpp"
#include "isopach/overlay/triangulate_union.hpp"
#include "isopach/simulate/scene.hpp"

namespace {

using namespace isopach;
using namespace isopach::bench;

struct Sets {
  std::string name;
  bench::Points a, b;
};

bench::Points moved(bench::Points points, double factor, double dx, double dy) {
  for (Point2& p : points) p = {factor * p.x + dx, factor * p.y + dy};
  return points;
}

bench::Points every_second(const bench::Points& points, std::size_t first) {
  bench::Points some;
  for (std::size_t i = first; i < points.size(); i += 2) some.push_back(points[i]);
  return some;
}

bench::Points nodes_of(const Cloud& cloud) {
  bench::Points xy;
  for (const Point3& p : cloud.points) xy.push_back({p.x, p.y});
  return xy;
}

Sets zigzag(std::size_t n) {
  SceneOptions options;
  options.points_a = options.points_b = n;
  const Scene scene = make_scene("worst-case", options, {});
  return {"the paper's zigzag", nodes_of(scene.a), nodes_of(scene.b)};
}

std::vector<Sets> all_sets(std::size_t n) {
  return {{"uniform", uniform(n, 1), uniform(n, 2)},
          {"scan lines", scan_lines(n, 1), scan_lines(n, 2)},
          {"clusters, the same", every_second(clustered(2 * n, 1), 0), every_second(clustered(2 * n, 1), 1)},
          {"clusters, others", clustered(n, 1), clustered(n, 2)},
          {"grid, and turned by 30°", grid(n, 1), rotated_grid(n, 1)},
          {"grid, and moved by half a cell", grid(n, 1), moved(grid(n, 1), 1, 0.5, 0.5)},
          {"grid, and every second node of it", grid(n, 1), moved(grid(n / 4, 1), 2, 0, 0)},
          {"the same set twice", uniform(n, 1), uniform(n, 1)},
          {"1/4 of the nodes", uniform(n, 1), uniform(n / 4, 2)},
          {"1/16 of the nodes", uniform(n, 1), uniform(n / 16, 2)},
          {"1/256 of the nodes", uniform(n, 1), uniform(n / 256, 2)},
          {"0.98 of the ground shared", uniform(n, 1), moved(uniform(n, 2), 1, 0.02, 0)},
          {"0.9 of the ground shared", uniform(n, 1), moved(uniform(n, 2), 1, 0.1, 0)},
          {"half the ground shared", uniform(n, 1), moved(uniform(n, 2), 1, 0.5, 0)},
          {"a tenth of the ground shared", uniform(n, 1), moved(uniform(n, 2), 1, 0.9, 0)},
          {"side by side", uniform(n, 1), moved(uniform(n, 2), 1, 1.05, 0)},
          {"side by side, 1/16", uniform(n, 1), moved(uniform(n / 16, 2), 1, 1.05, 0)},
          {"one in a triangle of the other", uniform(n, 1), moved(uniform(n, 2), 1e-5, 0.5, 0.5)},
          {"… with 1/16 of the nodes", uniform(n, 1), moved(uniform(n / 16, 2), 1e-5, 0.5, 0.5)},
          {"one in a hundredth of the other", uniform(n, 1), moved(uniform(n, 2), 0.1, 0.5, 0.5)},
          zigzag(n / 50)};
}

struct Ready {
  bench::Pair pair;
  UnitedNodes g;
  Located where;
};

std::optional<Triangulation> by_insertion(const Ready& r) {
  const bool first = is_first_extended(r.g, r.pair.a.xy.size(), r.pair.b.xy.size());
  const MeshToExtend mesh{(first ? r.pair.a : r.pair.b).t, first ? r.g.of_1 : r.g.of_2};
  return insert(mesh, {first ? r.g.of_2 : r.g.of_1, first ? r.where.b_in_a : r.where.a_in_b}, r.g.xy, {});
}

const char* name_of(UnionMethod method) {
  return method == UnionMethod::insertion ? "insertion" : (method == UnionMethod::merging ? "merging" : "scratch");
}

void run(const Sets& sets, int threads) {
  Ready r{make_pair_of(sets.a, sets.b), {}, {}};
  r.g = unite(r.pair.a.xy, r.pair.b.xy, r.pair.box);
  r.where = localise_in_order_both(r.pair);
  const double nodes = static_cast<double>(r.g.xy.size());
  Triangulation t, t1, t2;
  std::optional<Triangulation> inserted;
  const auto copies = [&] { t1 = r.pair.a.t, t2 = r.pair.b.t; };
  const auto free_all = [&] { t = {}, t1 = {}, t2 = {}, inserted.reset(); };
  const auto merging = [&] {
    t = isopach::merge({std::move(t1), r.pair.a.xy, &r.where.a_in_b}, {std::move(t2), r.pair.b.xy, &r.where.b_in_a},
                       r.g, r.pair.box, {});
  };
  const auto chosen = [&] {
    t = triangulate_union({std::move(t1), r.pair.a.xy, &r.where.a_in_b}, {std::move(t2), r.pair.b.xy, &r.where.b_in_a},
                          r.g, r.pair.box, {});
  };
  const std::vector<double> seconds =
      take_turns({{"scratch", threads, [&] { t = triangulate(r.g.xy, r.pair.box, {}); }, [] {}, free_all},
                  {"merging", threads, merging, copies, free_all},
                  {"insertion", threads, [&] { inserted = by_insertion(r); }, [] {}, free_all},
                  {"chosen", threads, chosen, copies, free_all}},
                 nodes > 1e5 ? 5 : 9);
  const UnionShape shape = shape_of({{}, r.pair.a.xy, &r.where.a_in_b}, {{}, r.pair.b.xy, &r.where.b_in_a}, r.g);
  const bool gave_up = !by_insertion(r);
  fmt::print("| {} | {} + {} | {:.3f} | {:.0f} | {:.2f} | {:.2f}{} | {}, {:.2f} |\n", sets.name, r.pair.a.xy.size(),
             r.pair.b.xy.size(), static_cast<double>(shape.runs) / nodes, 1e9 * seconds[0] / nodes,
             seconds[1] / seconds[0], seconds[2] / seconds[0], gave_up ? " (given up)" : "", name_of(cheapest(shape)),
             seconds[3] / seconds[0]);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const std::size_t n = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 1'000'000;
  isopach::bench::keep_heap();
  for (const int threads : {1, 2}) {
    if (argc > 2 && threads != std::atoi(argv[2])) continue;
    fmt::print(
        "\n{}:\n\n| sets | nodes | runs per node | from scratch, ns per node | merging | insertion | chosen |\n"
        "|---|---|--:|--:|--:|--:|---|\n",
        threads == 1 ? "One thread" : "Two threads");
    for (const Sets& sets : all_sets(n)) run(sets, threads);
  }
  return 0;
}
