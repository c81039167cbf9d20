// How cost grows: figure 3 of the paper on uniform nodes and on real scans, the merge, and the constructed worst case.
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <span>

#include "bench/experiments/experiments.hpp"
#include "bench/support/inputs.hpp"
#include "bench/support/pair.hpp"
#include "bench/support/plot.hpp"
#include "bench/support/timer.hpp"
#include "isopach/io/read.hpp"
#include "isopach/io/write.hpp"
#include "isopach/simulate/scene.hpp"

namespace isopach::bench {
namespace {

struct Measured {
  double nodes = 0;  ///< of one mesh; the mean where they differ
  double locate_seconds = 0, merge_seconds = 0;
  double visited = 0;  ///< triangles per node
};

int repeats_for(std::size_t nodes, const Setup& setup) {
  if (setup.quick) return 3;
  return nodes > 3'000'000 ? 3 : 5;
}

enum class Way { tree, order, interface };

/// Mean of the pairs, which are of one kind and size. By interface: the common triangulation is there, off the clock.
Measured localisation(std::span<const Pair> pairs, int repeats, Way way = Way::tree) {
  std::vector<Union> common;
  if (way == Way::interface)
    for (const Pair& pair : pairs) common.push_back(united(pair));
  const auto locate_both = [&](std::size_t i) {
    if (way == Way::interface) return localise_by_interface_both(pairs[i], common[i]);
    return way == Way::order ? localise_in_order_both(pairs[i]) : localise_both(pairs[i]);
  };
  Measured m;
  std::uint64_t visited = 0;
  std::size_t nodes = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Located located = locate_both(i);
    visited += located.a_in_b.visited + located.b_in_a.visited;
    nodes += pairs[i].nodes();
  }
  const auto count = static_cast<double>(pairs.size());
  m.nodes = 0.5 * static_cast<double>(nodes) / count;
  m.visited = static_cast<double>(visited) / static_cast<double>(nodes);
  const double seconds = time_of(1, repeats, [&] {
    for (std::size_t i = 0; i < pairs.size(); ++i) (void)locate_both(i);
  });
  m.locate_seconds = seconds / count;
  return m;
}

/// Uniform pairs of n + n nodes. Small ones come in numbers: a walk that is repeated alone and unchanged is learnt by
/// caches and branch predictor, and would be measured at half its cost.
std::vector<Pair> uniform_pairs(std::size_t n) {
  constexpr std::size_t enough = 500'000;
  std::vector<Pair> pairs(std::max<std::size_t>(1, enough / n));
  for (std::size_t i = 0; i < pairs.size(); ++i) pairs[i] = make_pair_of(uniform(n, 2 * i + 1), uniform(n, 2 * i + 2));
  return pairs;
}

/// Nodes of one mesh per microsecond: the paper's N/t, t being the mutual localisation.
double rate(const Measured& m) { return 1e-6 * m.nodes / m.locate_seconds; }

struct RealPair {
  std::string name, a, b;
};
const std::vector<RealPair>& real_pairs() {
  static const std::vector<RealPair> pairs = {
      {"two flight strips (Santa Cruz)", "santacruz/blanca_strip8706_120m.las", "santacruz/blanca_strip8707_120m.las"},
      {"volcano, two dates (St. Helens)", "msh-dome/msh_2004-10-04.xyz", "msh-dome/msh_2004-10-11.xyz"},
      {"one grid, two years (St. Helens)", "msh-dome/2.tif", "msh-dome/27.tif"},
      {"grids of two steps (Copernicus)", "demcompare/Copernicus_DSM_10_N45_00_E005_00_DEM.tif",
       "demcompare/Copernicus_blurred_and_shifted.tif"},
      {"face, two expressions", "probreg/face-x.txt", "probreg/face-y.txt"}};
  return pairs;
}

/// Whole and thinned by chance, the smallest first; nothing if the files are not there.
std::vector<Measured> measure_real(const Setup& setup, const RealPair& pair) {
  const auto a = setup.shared / pair.a, b = setup.shared / pair.b;
  if (!std::filesystem::exists(a) || !std::filesystem::exists(b)) return {};
  const Cloud cloud_a = read_cloud(a.string(), {}, {}), cloud_b = read_cloud(b.string(), {}, {});
  std::vector<Measured> found;
  for (const std::uint64_t keep : {8, 4, 2, 1}) {
    const Pair meshes = make_pair_of(cloud_a, cloud_b, keep);
    if (meshes.nodes() >= 10000) found.push_back(localisation({&meshes, 1}, setup.quick ? 3 : 11));
  }
  return found;
}

Series series_of(const std::string& name, const std::vector<Measured>& measured, double (*value)(const Measured&)) {
  Series s;
  s.name = name;
  for (const Measured& m : measured) s.x.push_back(m.nodes), s.y.push_back(value(m));
  return s;
}

void write_plot(const Setup& setup, const std::string& name, const Plot& plot) {
  std::filesystem::create_directories(setup.docs);
  write_atomically((setup.docs / name).string(), [&](const std::string& temporary) {
    const std::string text = svg(plot);
    std::FILE* file = std::fopen(temporary.c_str(), "wb");
    if (file == nullptr || std::fwrite(text.data(), 1, text.size(), file) != text.size())
      throw std::runtime_error(name + ": cannot be written");
    std::fclose(file);
  });
}

struct Uniform {
  std::vector<Measured> tree, order, interface;  ///< merge_seconds: linear merge in `tree`, from scratch in `order`
};
Uniform measure_uniform(const Setup& setup) {
  Uniform found;
  for (const std::size_t n : setup.sizes) {
    const std::vector<Pair> pairs = uniform_pairs(n);
    const int repeats = repeats_for(n, setup);
    found.tree.push_back(localisation(pairs, repeats));
    found.order.push_back(localisation(pairs, repeats, Way::order));
    found.interface.push_back(localisation(pairs, repeats, Way::interface));
    Merged merged;
    ToMerge parts;
    const auto merge_parts = [&] { merged = merge(pairs[0], std::move(parts)); };
    const auto prepare = [&] { parts = ready_to_merge(pairs[0]); };
    const auto from_scratch = [&] { merged = merge_from_scratch(pairs[0]); };
    const std::vector<double> seconds =
        take_turns({{"merge", 1, merge_parts, prepare}, {"from scratch", 1, from_scratch}}, std::min(repeats, 5));
    found.tree.back().merge_seconds = seconds[0];
    found.order.back().merge_seconds = seconds[1];
  }
  return found;
}

std::string per_node(double seconds, double nodes) { return number(1e9 * seconds / nodes); }

}  // namespace

void growth(const Setup& setup, Page& page) {
  const Uniform found = measure_uniform(setup);
  const std::vector<Measured>& measured = found.tree;
  page.heading("Growth with the number of nodes");
  page.paragraph(
      "Uniform nodes, N in each mesh, one thread, medians; mutual localisation along the trees, along the "
      "curve and by the common triangulation (2N nodes located; building trees and triangulation is not in it), merge "
      "per node of the union.");
  std::vector<std::vector<std::string>> rows = {{"N", "tree: visited per node", "ns per node", "N/t, nodes per µs",
                                                 "order: visited", "ns per node", "interface: visited", "ns per node",
                                                 "linear merge, ns per node", "from scratch"}};
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const Measured &m = measured[i], &o = found.order[i], &f = found.interface[i];
    rows.push_back({count(static_cast<std::size_t>(m.nodes)), number(m.visited),
                    per_node(m.locate_seconds, 2 * m.nodes), number(rate(m)), number(o.visited),
                    per_node(o.locate_seconds, 2 * o.nodes), number(f.visited), per_node(f.locate_seconds, 2 * f.nodes),
                    per_node(m.merge_seconds, 2 * m.nodes), per_node(o.merge_seconds, 2 * o.nodes)});
  }
  page.table(rows);
  const auto base = std::find_if(measured.begin(), measured.end(), [](const Measured& m) { return m.nodes >= 1e5; });
  if (base != measured.end() && base->nodes < measured.back().nodes) {
    const Measured& last = measured.back();
    const double more = last.nodes / base->nodes;
    page.paragraph(fmt::format("ns per node at {} against {} (target 1.25, goal 1.1): localisation {}, merge {}.",
                               count(static_cast<std::size_t>(last.nodes)),
                               count(static_cast<std::size_t>(base->nodes)),
                               against(last.locate_seconds / base->locate_seconds / more, 1.25),
                               against(last.merge_seconds / base->merge_seconds / more, 1.25)));
  }
  Plot growth_plot{"Cost per node, uniform nodes, one thread", "N, nodes of one mesh", "ns per node", {}};
  growth_plot.series.push_back(series_of("localisation along the tree", measured,
                                         [](const Measured& m) { return 0.5e9 * m.locate_seconds / m.nodes; }));
  const auto ns = [](const Measured& m) { return 0.5e9 * m.locate_seconds / m.nodes; };
  growth_plot.series.push_back(series_of("localisation along the curve", found.order, ns));
  growth_plot.series.push_back(series_of("localisation by interface", found.interface, ns));
  growth_plot.series.push_back(
      series_of("linear merge", measured, [](const Measured& m) { return 0.5e9 * m.merge_seconds / m.nodes; }));
  growth_plot.series.push_back(
      series_of("T from scratch", found.order, [](const Measured& m) { return 0.5e9 * m.merge_seconds / m.nodes; }));
  write_plot(setup, "benchmark-growth.svg", growth_plot);
  page.picture("benchmark-growth.svg", "ns per node against N for localisation and merge");

  page.heading("Figure 3 of the paper: N/t against N");
  page.paragraph(
      "t is the time of the mutual localisation, N the number of nodes of one mesh (the mean of both). Level is linear "
      "cost. Real scans "
      "are taken whole and with a half, a quarter, an eighth of their nodes, drawn by chance; those of fewer than 10⁵ "
      "nodes gain from caches and branch predictor, as they are repeated unchanged.");
  Plot figure{
      "Mutual localisation: N/t against N, one thread", "N, nodes of one mesh", "N/t, nodes per microsecond", {}};
  figure.series.push_back(series_of("uniform", measured, rate));
  figure.series.push_back(series_of("uniform, along the curve", found.order, rate));
  figure.series.push_back(series_of("uniform, by interface", found.interface, rate));
  std::vector<std::vector<std::string>> real_rows = {
      {"real scans", "N", "visited per node", "ns per node", "N/t, nodes per µs"}};
  std::string absent;
  for (const RealPair& pair : real_pairs()) {
    const std::vector<Measured> real = measure_real(setup, pair);
    if (real.empty()) {
      absent += (absent.empty() ? "" : ", ") + pair.name;
      continue;
    }
    figure.series.push_back(series_of(pair.name, real, rate));
    const Measured& m = real.back();
    real_rows.push_back({pair.name, count(static_cast<std::size_t>(m.nodes)), number(m.visited),
                         per_node(m.locate_seconds, 2 * m.nodes), number(rate(m))});
  }
  write_plot(setup, "benchmark-figure3.svg", figure);
  page.picture("benchmark-figure3.svg", "N/t against N for uniform nodes and real scans");
  if (real_rows.size() > 1) page.table(real_rows);
  if (!absent.empty()) page.paragraph("Not measured, the data are not there: " + absent + ".");
}

namespace {

Pair worst_case_pair(std::size_t n) {
  SceneOptions options;
  options.points_a = options.points_b = n;
  const Scene scene = make_scene("worst-case", options, {});
  return make_pair_of(scene.a, scene.b, 1);
}

/// The counterexample of docs/method/localisation.md: in the same bundle of long thin triangles, nodes at heights of
/// chance.
Pair bundle_pair(std::size_t n) {
  SceneOptions options;
  options.points_a = options.points_b = n;
  const Cloud columns = make_scene("worst-case", options, {}).b;
  Points between, around;
  const Points chance = uniform(n, 1);
  for (std::size_t i = 0; i < n; ++i)
    between.push_back({0.8 * (static_cast<double>(i) - 0.5 * static_cast<double>(n)), 0.2 * chance[i].y - 0.1});
  for (const Point3& p : columns.points) around.push_back({p.x, p.y});
  return make_pair_of(between, around);
}

}  // namespace

void worst_case(const Setup& setup, Page& page) {
  const std::size_t largest_for_tree = setup.worst_sizes.back(), largest_bundle = 4000;
  std::vector<std::size_t> sizes = setup.worst_sizes;
  for (const std::size_t n : {30'000, 100'000})
    if (n > sizes.back()) sizes.push_back(n);
  std::vector<Measured> tree, interface, bundle_tree, bundle_interface;
  for (const std::size_t n : sizes) {
    const Pair pair = worst_case_pair(n);
    interface.push_back(localisation({&pair, 1}, 3, Way::interface));
    if (n <= largest_for_tree) tree.push_back(localisation({&pair, 1}, 3));
    if (n > largest_bundle) continue;
    const Pair bundle = bundle_pair(n);
    bundle_tree.push_back(localisation({&bundle, 1}, 1));
    bundle_interface.push_back(localisation({&bundle, 1}, 1, Way::interface));
  }
  page.heading("The constructed worst case");
  page.paragraph(
      "A zigzag whose tree crosses, with every edge, all the long edges of the other mesh. Along the tree the cost is "
      "quadratic: the visited triangles per node grow with N. By the common triangulation (theorem 3) it is linear "
      "here (target: at most 20 triangles per node). Last columns: nodes at heights of chance in the same bundle of "
      "long thin triangles, where no walk from neighbour to neighbour is short, whatever leads it "
      "([why](../method/localisation.md)).");
  std::vector<std::vector<std::string>> rows = {{"N", "tree: visited per node", "seconds",
                                                 "interface: visited per node", "seconds", "by chance, tree: visited",
                                                 "by chance, interface: visited"}};
  for (std::size_t i = 0; i < interface.size(); ++i) {
    const bool with_tree = i < tree.size(), with_bundle = i < bundle_tree.size();
    rows.push_back({count(static_cast<std::size_t>(interface[i].nodes)), with_tree ? number(tree[i].visited) : "",
                    with_tree ? fmt::format("{:.4f}", tree[i].locate_seconds) : "", against(interface[i].visited, 20),
                    fmt::format("{:.4f}", interface[i].locate_seconds),
                    with_bundle ? number(bundle_tree[i].visited) : "",
                    with_bundle ? number(bundle_interface[i].visited) : ""});
  }
  page.table(rows);
  Plot plot{"Worst case: triangles visited per node", "N, nodes of one mesh", "visited triangles per node", {}};
  const auto visited = [](const Measured& m) { return m.visited; };
  plot.series.push_back(series_of("zigzag, tree", tree, visited));
  plot.series.push_back(series_of("zigzag, interface", interface, visited));
  plot.series.push_back(series_of("by chance, tree", bundle_tree, visited));
  plot.series.push_back(series_of("by chance, interface", bundle_interface, visited));
  write_plot(setup, "benchmark-worst-case.svg", plot);
  page.picture("benchmark-worst-case.svg", "visited triangles per node against N");
}

}  // namespace isopach::bench
