// The stages, one by one, beside CGAL's.
#include <fmt/format.h>

#include <atomic>
#include <optional>
#include <thread>

#include "bench/experiments/experiments.hpp"
#include "bench/rivals/rival.hpp"
#include "bench/support/check.hpp"
#include "bench/support/inputs.hpp"
#include "bench/support/machine.hpp"
#include "bench/support/pair.hpp"
#include "bench/support/timer.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/overlay/common.hpp"
#include "isopach/overlay/localise.hpp"

namespace isopach::bench {
namespace {

/// One family triangulated by everyone, and whether the result is right.
struct Triangulated {
  std::size_t points = 0;
  double one = 0, two = 0, cgal = 0;  ///< seconds
  std::string verdict;
};

Triangulated triangulate_family(const Family& family, std::size_t n, int repeats, bool two_threads) {
  const Points points = family.make(n, 1);
  std::optional<SortedTriangulation> ours;
  std::shared_ptr<rival::Mesh> theirs;
  std::shared_ptr<rival::Input> input;
  std::vector<Contestant> contestants;
  const auto drop = [&] { ours.reset(), theirs.reset(); };
  contestants.push_back({"one", 1, [&] { ours = triangulate_unsorted(points, {}); }, drop, [] {}});
  if (rival::available()) {
    input = rival::input(points);
    contestants.push_back({"cgal", 1, [&] { theirs = rival::triangulate(*input); }, drop, [] {}});
  }
  if (two_threads) contestants.push_back({"two", 2, [&] { ours = triangulate_unsorted(points, {}); }, drop, [] {}});
  const std::vector<double> seconds = take_turns(contestants, repeats);
  Triangulated result;
  result.points = points.size();
  for (std::size_t i = 0; i < contestants.size(); ++i) {
    if (contestants[i].name == "one") result.one = seconds[i];
    if (contestants[i].name == "two") result.two = seconds[i];
    if (contestants[i].name == "cgal") result.cgal = seconds[i];
  }
  ours = triangulate_unsorted(points, {});
  result.verdict = rival::available() ? verdict(*ours, rival::edges(*rival::triangulate(*input))) : verdict(*ours);
  return result;
}

std::string ratio(double ours, double theirs) { return theirs > 0 ? number(ours / theirs) : ""; }
std::string ratio(double ours, double theirs, double target) {
  return theirs > 0 ? against(ours / theirs, target) : "";
}

}  // namespace

void contention(const Setup& setup, Page& page) {
  const Points points = uniform(setup.n, 1), others = uniform(setup.n, 2);
  const auto work = [&] { (void)triangulate_unsorted(points, {}); };
  const double alone = time_of(1, setup.repeats, work);
  std::atomic<bool> stop{false};
  std::thread neighbour([&] {
    while (!stop) run_with_threads(1, [&] { (void)triangulate_unsorted(others, {}); });
  });
  const double beside = time_of(1, setup.repeats, work);
  stop = true;
  neighbour.join();
  page.heading("Contention");
  std::string text = fmt::format(
      "The same one-thread triangulation of {} uniform points takes {} ns of CPU per point alone and {} while the "
      "other "
      "core triangulates too: a factor of {}.",
      count(setup.n), nanoseconds(alone, setup.n), nanoseconds(beside, setup.n), number(beside / alone));
  if (beside > alone)
    text += fmt::format(" Two threads can therefore not be more than {} times as fast as one here.",
                        number(2 * alone / beside));
  if (machine_load() > 1) text += " Other work was going on, so that alone was not alone.";
  page.paragraph(text);
}

void delaunay(const Setup& setup, Page& page) {
  constexpr double targets[4] = {0.38, 0.38, 0.22, 0.45}, goals[4] = {0.30, 0.30, 0.15, 0.35};
  constexpr double targets_two[4] = {0.22, 0.22, 0.13, 0.27};
  page.heading("Delaunay triangulation");
  page.paragraph(
      "Unsorted doubles in, triangles and neighbours out; ns per point, medians of " + std::to_string(setup.repeats) +
      ", " + count(setup.n) +
      " points. Ratios are to CGAL on one thread. Right: the exact validator finds no fault, and CGAL has as "
      "many edges.");
  std::vector<std::vector<std::string>> rows = {
      {"", "isopach", "CGAL", "ratio", "target", "goal", "2 threads", "ratio", "target", "result"}};
  for (std::size_t i = 0; i < 4; ++i) {
    const Family& family = main_families()[i];
    const Triangulated t = triangulate_family(family, setup.n, setup.repeats, true);
    rows.push_back({family.name, nanoseconds(t.one, t.points), nanoseconds(t.cgal, t.points),
                    ratio(t.one, t.cgal, targets[i]), number(targets[i]), number(goals[i]),
                    nanoseconds(t.two, t.points), ratio(t.two, t.cgal, targets_two[i]), number(targets_two[i]),
                    t.verdict});
  }
  page.table(rows);
}

void cliffs(const Setup& setup, Page& page) {
  constexpr double target = 1.6;
  page.heading("No cliffs");
  page.paragraph("Time per point against uniform points, one thread, medians of 3; target 1.6.");
  const Triangulated base = triangulate_family({"uniform", uniform}, setup.n, 3, false);
  const auto per_point = [](double seconds, const Triangulated& t) { return seconds / static_cast<double>(t.points); };
  std::vector<std::vector<std::string>> rows = {
      {"", "isopach ns", "against uniform", "CGAL ns", "against uniform", "result"}};
  rows.push_back(
      {"uniform", nanoseconds(base.one, base.points), "1", nanoseconds(base.cgal, base.points), "1", base.verdict});
  for (const Family& family : cliff_families()) {
    const Triangulated t = triangulate_family(family, setup.n, 3, false);
    rows.push_back({family.name, nanoseconds(t.one, t.points),
                    against(per_point(t.one, t) / per_point(base.one, base), target), nanoseconds(t.cgal, t.points),
                    ratio(per_point(t.cgal, t), per_point(base.cgal, base)), t.verdict});
  }
  page.table(rows);
}

void stages(const Setup& setup, Page& page) {
  const Points a = uniform(setup.n, 1), b = uniform(setup.n, 2);
  const Pair pair = make_pair_of(a, b);
  const std::size_t n = pair.a.xy.size();
  std::vector<Contestant> contestants;
  Locations located;
  Merged merged, scratch;
  ToMerge parts;
  SpanningTree tree;
  for (const int threads : {1, 2}) {
    contestants.push_back({"tree", threads, [&] { tree = spanning_tree(pair.a.t, pair.a.xy, {}); }});
    contestants.push_back(
        {"localise", threads, [&] { located = localise(pair.a.xy, pair.a.tree, pair.b.t, pair.b.xy, {}); }});
    contestants.push_back(
        {"merge", threads, [&] { merged = merge(pair, std::move(parts)); }, [&] { parts = ready_to_merge(pair); }});
  }
  std::shared_ptr<rival::Input> sorted, both_sets;
  std::shared_ptr<rival::Mesh> mesh, work;
  std::size_t inside = 0;
  if (rival::available()) {
    sorted = rival::hilbert_sorted(a);
    mesh = rival::triangulate(*rival::input(b));
    Points all = a;
    all.insert(all.end(), b.begin(), b.end());
    both_sets = rival::input(all);
    contestants.push_back({"cgal locate", 1, [&] { inside = rival::locate(*mesh, *sorted); }});
    contestants.push_back({"cgal insert", 1, [&] { rival::insert(*work, *sorted); }, [&] { work = rival::copy(*mesh); },
                           [&] { work.reset(); }});
    contestants.push_back(
        {"cgal scratch", 1, [&] { work = rival::triangulate(*both_sets); }, [] {}, [&] { work.reset(); }});
  }
  std::vector<double> s = take_turns(contestants, setup.repeats);
  s.resize(9, 0);
  Locations in_order;
  const auto locate_in_order = [&] { in_order = localise_in_order(pair.a.xy, pair.b.t, pair.b.xy, {}); };
  const auto from_scratch = [&] { scratch = merge_from_scratch(pair); };
  const std::vector<double> o = take_turns({{"in order", 1, locate_in_order},
                                            {"in order", 2, locate_in_order},
                                            {"from scratch", 1, from_scratch},
                                            {"from scratch", 2, from_scratch}},
                                           setup.repeats);
  const std::size_t united = pair.nodes();
  page.heading("Tree, localisation, merge");
  page.paragraph("Uniform in uniform, " + count(n) + " + " + count(n) +
                 " nodes, meshes as built; ns per node (merge: of "
                 "the union), medians of " +
                 std::to_string(setup.repeats) +
                 ". CGAL: location with hint in Hilbert order (sort not timed); "
                 "insertion of the one set, presorted along the Hilbert curve (sort not timed), into the mesh of the "
                 "other, with hint. Merge: both node lists united, T with neighbours, list of interface triangles; "
                 "locations given. From scratch: the same by triangulating all nodes anew, presorted (CGAL: not).");
  const auto ns = [](double seconds, std::size_t nodes) { return 1e9 * seconds / static_cast<double>(nodes); };
  const auto cgal = [&](double seconds, std::size_t nodes) { return seconds > 0 ? nanoseconds(seconds, nodes) : ""; };
  page.table({{"", "isopach", "CGAL", "ratio", "target", "goal", "2 threads", "target"},
              {"spanning tree with walking order", against(ns(s[0], n), 150), "", "", "150", "100",
               against(ns(s[3], n), 90), "90"},
              {"localisation", against(ns(s[1], n), 70), cgal(s[6], n), ratio(s[1], s[6]), "70", "50",
               against(ns(s[4], n), 40), "40"},
              {"localisation in curve order, no tree", against(ns(o[0], n), 70), cgal(s[6], n), ratio(o[0], s[6]), "70",
               "50", against(ns(o[1], n), 40), "40"},
              {"linear merge", against(ns(s[2], united), 150), cgal(s[7], united), ratio(s[2], s[7]), "150", "110",
               against(ns(s[5], united), 90), "90"},
              {"the same from scratch", against(ns(o[2], united), 150), cgal(s[8], united), ratio(o[2], s[8]), "150",
               "110", against(ns(o[3], united), 90), "90"}});
  page.paragraph(
      "Triangles visited per node: " + number(static_cast<double>(located.visited) / static_cast<double>(n)) +
      " along the tree (target 3), " + number(static_cast<double>(in_order.visited) / static_cast<double>(n)) +
      " in curve order. The merged triangulation is " + verdict_on_merge(pair, merged.t) + "; " +
      number(static_cast<double>(merged.interface.size()) / static_cast<double>(merged.t.real)) +
      " of its triangles are interface triangles.");
}

void whole(const Setup& setup, Page& page) {
  const Cloud a = surface_scan(setup.n, 1, 1), b = surface_scan(setup.n, 2, 2);
  CompareOptions bare;
  bare.check_layers = false;
  bare.border = BorderRule::hull;  // what the rivals triangulate
  std::optional<Comparison> found, checked;
  rival::Volume theirs;
  const auto drop = [&] { found.reset(), checked.reset(); };
  std::vector<Contestant> contestants = {{"one", 1, [&] { found = compare(a, b, bare, {}); }, drop, [] {}},
                                         {"one with check", 1, [&] { checked = compare(a, b, {}, {}); }, drop, [] {}},
                                         {"two", 2, [&] { found = compare(a, b, bare, {}); }, drop, [] {}}};
  if (rival::available())
    contestants.push_back({"cgal", 1, [&] { theirs = rival::compare(a.points, b.points); }, drop, [] {}});
  std::vector<double> s = take_turns(contestants, setup.slow_repeats);
  s.resize(4, 0);
  run_with_threads(1, [&] { found = compare(a, b, bare, {}); });
  page.heading("Whole comparison in memory");
  page.paragraph(
      "compare() of two clouds of " + count(setup.n) +
      " points: projection and sort, T1 and T2, trees, localisation both ways, T, "
      "all measures, statistics and point fields; seconds. CGAL: the straightforward program on one thread.");
  page.table({{"", "isopach", "CGAL", "ratio", "target", "goal", "2 threads", "ratio", "target"},
              {"without the layer check", number(s[0]), number(s[3]), ratio(s[0], s[3], 1.0 / 3), "0.33", "0.25",
               number(s[2]), ratio(s[2], s[3], 0.2), "0.20"},
              {"as by default", number(s[1]), number(s[3]), ratio(s[1], s[3]), "", "", "", "", ""}});
  std::vector<std::vector<std::string>> rows = {{"stage, one thread (one run, wall)", "seconds", "share"}};
  for (const auto& [stage, seconds] : found->timing.stages)
    rows.push_back(
        {stage, fmt::format("{:.3f}", seconds), fmt::format("{:.0f} %", 100 * seconds / found->timing.total)});
  page.table(rows);
  if (rival::available())
    page.paragraph(
        fmt::format("Both find the same: area {:.9f} and {:.9f}, above {:.9f} and {:.9f}, below {:.9f} and {:.9f}.",
                    found->measures.area, theirs.area, found->measures.volume.above, theirs.above,
                    found->measures.volume.below, theirs.below));
}

}  // namespace isopach::bench
