// Whole processes: from two binary PLY files to numbers; and the memory of one triangulation.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <string>

#include "bench/experiments/experiments.hpp"
#include "bench/rivals/rival.hpp"
#include "bench/support/inputs.hpp"
#include "bench/support/process.hpp"
#include "bench/support/timer.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/io/write.hpp"

namespace isopach::bench {
namespace {

/// What is wanted of a program; 0: nothing.
struct Wanted {
  double share = 0, goal_share = 0;  ///< of the rival's time
  double seconds = 0, goal_seconds = 0, bytes_a_point = 0;
};

struct Program {
  std::string name;
  std::vector<std::string> words;
  int threads = 1;
  Wanted wanted;
};

struct Outcome {
  double seconds = 0, cpu = 0;
  std::size_t peak = 0;
  bool ok = true;
};

/// Programs take turns, as in take_turns. Medians of time, largest peak.
std::vector<Outcome> run_in_turns(const std::vector<Program>& programs, int repeats) {
  std::vector<std::vector<double>> wall(programs.size()), cpu(programs.size());
  std::vector<Outcome> outcomes(programs.size());
  for (int turn = 0; turn < repeats; ++turn)
    for (std::size_t i = 0; i < programs.size(); ++i) {
      const ProcessRun run = run_process(programs[i].words);
      wall[i].push_back(run.seconds);
      cpu[i].push_back(run.cpu_seconds);
      outcomes[i].peak = std::max(outcomes[i].peak, run.peak_bytes);
      outcomes[i].ok = outcomes[i].ok && run.ok;
    }
  for (std::size_t i = 0; i < programs.size(); ++i)
    outcomes[i].seconds = median(wall[i]), outcomes[i].cpu = median(cpu[i]);
  return outcomes;
}

void write_pair(const std::filesystem::path& folder, std::size_t n) {
  write_cloud((folder / "a.ply").string(), surface_scan(n, 1, 1), {});
  write_cloud((folder / "b.ply").string(), surface_scan(n, 2, 2), {});
}

std::vector<Program> contestants(const Setup& setup, std::size_t n, const std::string& a, const std::string& b) {
  const std::string isopach = (setup.programs / "isopach").string();
  Wanted one, two;
  if (n == 1000) two = {0, 0, 0.020, 0.012, 0};
  if (n == 1'000'000) one = {0.40, 0.32, 0, 0, 0}, two = {0.22, 0.18, 0, 0, 0};
  if (n == 10'000'000) two = {0, 0, 0, 0, 130};
  std::vector<Program> programs;
  if (rival::available() && n < 10'000'000)
    programs.push_back({rival::name(), {(setup.programs / "cgal_compare").string(), a, b}, 1, {}});
  programs.push_back({"isopach compare", {isopach, "compare", a, b, "--threads", "1", "--quiet"}, 1, one});
  programs.push_back({"isopach compare", {isopach, "compare", a, b, "--threads", "2", "--quiet"}, 2, two});
  return programs;
}

std::string wanted_of(double found, double target) { return target > 0 ? against(found, target) : number(found); }

/// One thread by its CPU time, two by the wall clock.
double judged(const Outcome& o, int threads) { return threads == 1 ? o.cpu : o.seconds; }

void whole_process(const Setup& setup, std::size_t n, int repeats, Page& page) {
  const std::string a = (setup.scratch / "a.ply").string(), b = (setup.scratch / "b.ply").string();
  write_pair(setup.scratch, n);
  const std::vector<Program> programs = contestants(setup, n, a, b);
  const std::vector<Outcome> outcomes = run_in_turns(programs, repeats);
  const bool has_rival = programs[0].words.front().find("cgal") != std::string::npos;
  std::vector<std::vector<std::string>> rows = {{count(n) + " + " + count(n) + " points", "threads", "CPU s", "wall s",
                                                 "of CGAL", "target", "goal", "peak MiB", "bytes a point"}};
  for (std::size_t i = 0; i < programs.size(); ++i) {
    const auto& [name, words, threads, wanted] = programs[i];
    const Outcome& o = outcomes[i];
    const auto peak = static_cast<double>(o.peak);
    const double share = has_rival ? judged(o, threads) / judged(outcomes[0], 1) : 0;
    const bool by_time = wanted.seconds > 0;
    rows.push_back({name + (o.ok ? "" : ": FAILED"), std::to_string(threads), number(o.cpu),
                    by_time ? against(o.seconds, wanted.seconds) : number(o.seconds),
                    has_rival ? wanted_of(share, wanted.share) : "",
                    by_time                    ? number(wanted.seconds) + " s"
                    : wanted.share > 0         ? number(wanted.share)
                    : wanted.bytes_a_point > 0 ? number(wanted.bytes_a_point) + " B"
                                               : "",
                    by_time            ? number(wanted.goal_seconds) + " s"
                    : wanted.share > 0 ? number(wanted.goal_share)
                                       : "",
                    number(peak / 0x1p20), wanted_of(peak / (2 * static_cast<double>(n)), wanted.bytes_a_point)});
  }
  page.table(rows);
  for (const std::string& file : {a, b}) std::filesystem::remove(file);
}

double probe(const Setup& setup, const std::string& whose) {
  const ProcessRun run = run_process({setup.self.string(), "--probe", whose, "--n", std::to_string(setup.n)});
  return run.ok ? std::stod(run.output) : 0;
}

}  // namespace

void processes(const Setup& setup, Page& page) {
  page.heading("Whole process: two binary PLY files to numbers");
  page.paragraph(
      "Uniform points on a hilly surface; files are in the page cache. A program on one thread is judged by its CPU "
      "time, system included, one on two threads by the wall clock against CGAL's on one. isopach compares as by "
      "default, layer check "
      "included. Peak is the resident size that the kernel reports. CGAL: two triangulations, every node located in "
      "the other "
      "one from its neighbour, the union triangulated from scratch, a sum.");
  whole_process(setup, 1000, 15, page);
  whole_process(setup, setup.n, setup.slow_repeats, page);
  if (!setup.four_million) return;
  whole_process(setup, 4'000'000, 1, page);
  whole_process(setup, 10'000'000, 1, page);
}

int memory_probe(const std::string& whose, std::size_t n) {
  const Points points = uniform(n, 1);
  const auto used = [&](const auto& work) {
    const std::size_t before = own_memory("VmRSS:");
    run_with_threads(1, work);
    fmt::print("{:.1f}\n", static_cast<double>(own_memory("VmHWM:") - before) / static_cast<double>(n));
  };
  if (whose == "unsorted") {
    used([&] { (void)triangulate_unsorted(points, {}); });
  } else if (whose == "sorted") {
    Box2 box;
    for (const Point2& p : points) box.add(p);
    const CurveBox curve = curve_box(box);
    Points nodes;
    {
      const Array<Index> order = curve_order(points, curve);
      nodes.reserve(n);
      for (const Index i : order) nodes.push_back(points[i]);
    }
    // The peak so far is that of the sort; a fresh count starts here.
    if (std::FILE* file = std::fopen("/proc/self/clear_refs", "w"); file != nullptr) {
      std::fputs("5", file);
      std::fclose(file);
    }
    used([&] { (void)triangulate(nodes, curve, {}); });
  } else if (whose == "rival") {
    const auto input = rival::input(points);
    used([&] { (void)rival::triangulate(*input); });
  } else {
    return 2;
  }
  return 0;
}

void memory(const Setup& setup, Page& page) {
  page.heading("Memory of a triangulation above its input");
  page.paragraph("Largest resident size less the one before, " + count(setup.n) +
                 " uniform points, each in a process of its own, one thread.");
  const double bytes = static_cast<double>(2 * sizeof(Triangle));
  std::vector<std::vector<std::string>> rows = {{"", "bytes per point", "target", "goal"}};
  rows.push_back({"isopach, from points in curve order", against(probe(setup, "sorted"), 110), "110", "90"});
  rows.push_back({"isopach, from points in any order (sorted copy and both maps of ids in the result)",
                  against(probe(setup, "unsorted"), 110), "110", "90"});
  rows.push_back({"of which the triangles themselves", number(bytes), "", ""});
  if (rival::available())
    rows.push_back({rival::name() + " (its own points included)", number(probe(setup, "rival")), "", ""});
  page.table(rows);
}

}  // namespace isopach::bench
