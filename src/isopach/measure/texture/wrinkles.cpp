#include "isopach/measure/texture/wrinkles.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include <fmt/format.h>

#include "isopach/base/error.hpp"
#include "isopach/base/median.hpp"
#include "isopach/base/sum.hpp"

namespace isopach {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double default_depth = 3;    // NMADs
constexpr double default_length = 10;  // spacings
constexpr double slender = 3;          // least length ÷ width
constexpr double stretch = 3;          // spacings a stretch of the line
constexpr std::size_t least_nodes = 3;
constexpr double most_stretches = 64;  // of the line, a node: a spike of 1e38 makes no more of them than that

class Valleys {
 public:
  Valleys(const Triangulation& t, std::span<const Point2> xy, std::span<const double> z, std::span<const double> relief,
          std::span<const unsigned char> kept, std::span<const double> area, double depth)
      : t_(t),
        xy_(xy),
        z_(z),
        relief_(relief),
        kept_(kept),
        area_(area),
        depth_(depth),
        leaving_(xy.size(), no_index),
        valley_(xy.size(), no_index),
        place_(xy.size(), 0) {
    for (Index i = t.real; i-- > 0;)
      for (Index k = 0; k < 3; ++k)
        if (is_kept(i)) leaving_[t.triangles[i].v[k]] = half_edge(i, k);
  }

  /// Connected sets, each by ascending node.
  [[nodiscard]] std::vector<Array<Index>> connected() {
    std::vector<Array<Index>> out;
    for (Index i = 0; i < xy_.size(); ++i) {
      if (!is_deep(i) || valley_[i] != no_index) continue;
      const auto number = static_cast<Index>(out.size());
      Array<Index> nodes{i};
      valley_[i] = number;
      for (std::size_t next = 0; next < nodes.size(); ++next)
        for_neighbours(nodes[next], [&](Index n) {
          if (is_deep(n) && valley_[n] == no_index) valley_[n] = number, nodes.push_back(n);
        });
      std::sort(nodes.begin(), nodes.end());
      out.push_back(std::move(nodes));
    }
    return out;
  }

  [[nodiscard]] Wrinkle measured(Array<Index> nodes, double step) {
    Wrinkle w;
    w.nodes = std::move(nodes);
    for (std::size_t k = 0; k < w.nodes.size(); ++k) place_[w.nodes[k]] = static_cast<Index>(k);
    Sum area, volume;
    for (const Index i : w.nodes) {
      area.add(area_[i]), volume.add(area_[i] * -relief_[i]);
      if (w.deepest == no_index || relief_[i] < relief_[w.deepest]) w.deepest = i;
    }
    w.area = area.value(), w.volume = volume.value();
    w.depth = -relief_[w.deepest];
    draw_line(w, step);
    w.width = w.length > 0 ? w.area / w.length : 0;
    w.mean_depth = depth_along(w, relief_of(w)).mean_depth;
    return w;
  }

  [[nodiscard]] bool runs_along_rim(const Wrinkle& w) const {
    const auto there = std::count_if(w.nodes.begin(), w.nodes.end(), [&](Index i) { return is_at_rim(i); });
    return 2 * static_cast<std::size_t>(there) >= w.nodes.size();
  }

 private:
  [[nodiscard]] bool is_at_rim(Index node) const {
    const HalfEdge start = leaving_[node];
    HalfEdge h = start;
    do {
      if (!is_kept(triangle_of(h))) return true;
      h = t_.next_leaving(h);
    } while (h != start);
    return false;
  }

  struct Middle {
    double weight = 0, x = 0, y = 0, z = 0;
  };

  [[nodiscard]] bool is_kept(Index triangle) const {
    return !t_.is_ghost(triangle) && (kept_.empty() || kept_[triangle] != 0);
  }
  [[nodiscard]] bool is_deep(Index i) const { return leaving_[i] != no_index && relief_[i] <= -depth_; }

  /// Over sides of kept triangles; a side between two of them is met once, one at the rim from whichever it has.
  template <class F>
  void for_neighbours(Index of, F&& f) const {
    const HalfEdge start = leaving_[of];
    HalfEdge h = start;
    do {
      const Index here = triangle_of(h), before = triangle_of(t_.twin(h));
      if (t_.target(h) != no_index && (is_kept(here) || is_kept(before))) f(t_.target(h));
      h = t_.next_leaving(h);
    } while (h != start);
  }

  [[nodiscard]] double length(Index a, Index b) const {
    return std::hypot(xy_[a].x - xy_[b].x, xy_[a].y - xy_[b].y, z_[a] - z_[b]);
  }

  /// Distances along sides inside the valley from one of its nodes, by place in `nodes`.
  [[nodiscard]] std::vector<double> distances(const Wrinkle& w, Index from) const {
    std::vector<double> d(w.nodes.size(), std::numeric_limits<double>::infinity());
    using Entry = std::pair<double, Index>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    d[place_[from]] = 0;
    queue.emplace(0.0, from);
    const Index valley = valley_[from];
    while (!queue.empty()) {
      const double so_far = queue.top().first;
      const Index i = queue.top().second;
      queue.pop();
      if (so_far > d[place_[i]]) continue;
      for_neighbours(i, [&](Index n) {
        if (valley_[n] != valley) return;
        const double there = so_far + length(i, n);
        if (there < d[place_[n]]) d[place_[n]] = there, queue.emplace(there, n);
      });
    }
    return d;
  }
  [[nodiscard]] static Index farthest(const Wrinkle& w, const std::vector<double>& d) {
    return w.nodes[static_cast<std::size_t>(std::max_element(d.begin(), d.end()) - d.begin())];
  }

  /// From one end to the other through the middles, by depth and area, of the stretches between.
  void draw_line(Wrinkle& w, double step) const {
    const Index one = farthest(w, distances(w, w.deepest));
    const std::vector<double> d = distances(w, one);
    const Index other = farthest(w, d);
    const double reach = d[place_[other]];
    const double most = most_stretches * static_cast<double>(w.nodes.size());
    const auto count = static_cast<std::size_t>(std::clamp(std::floor(reach / step), 1.0, most));
    std::vector<Middle> middle(count);
    w.step.resize(w.nodes.size());
    for (std::size_t k = 0; k < w.nodes.size(); ++k) {
      const Index i = w.nodes[k];
      const std::size_t s =
          reach > 0 ? std::min(count - 1, static_cast<std::size_t>(d[k] / reach * static_cast<double>(count))) : 0;
      w.step[k] = static_cast<Index>(s);
      const double weight = area_[i] * -relief_[i];
      Middle& m = middle[s];
      m.weight += weight, m.x += weight * xy_[i].x, m.y += weight * xy_[i].y, m.z += weight * z_[i];
    }
    std::vector<Point3> points{{xy_[one].x, xy_[one].y, z_[one]}};
    for (const Middle& m : middle)
      if (m.weight > 0) points.push_back({m.x / m.weight, m.y / m.weight, m.z / m.weight});
    points.push_back({xy_[other].x, xy_[other].y, z_[other]});
    w.part.assign(count, reach / static_cast<double>(count));
    for (std::size_t k = 0; k < points.size(); ++k) {
      w.line.push_back({points[k].x, points[k].y});
      if (k > 0)
        w.length +=
            std::hypot(points[k].x - points[k - 1].x, points[k].y - points[k - 1].y, points[k].z - points[k - 1].z);
    }
  }

  [[nodiscard]] std::vector<double> relief_of(const Wrinkle& w) const {
    std::vector<double> out;
    for (const Index i : w.nodes) out.push_back(relief_[i]);
    return out;
  }

  const Triangulation& t_;
  std::span<const Point2> xy_;
  std::span<const double> z_, relief_;
  std::span<const unsigned char> kept_;
  std::span<const double> area_;
  double depth_;
  Array<HalfEdge> leaving_;
  Array<Index> valley_, place_;
};

}  // namespace

double nmad(std::span<const double> relief, std::span<const double> area) {
  std::vector<double> values;
  for (std::size_t i = 0; i < relief.size(); ++i)
    if (area[i] > 0) values.push_back(relief[i]);
  if (values.empty()) return 0;
  const double middle = median(values);
  for (double& v : values) v = std::fabs(v - middle);
  return mad_to_sigma * median(values);
}

Wrinkles find_wrinkles(const Triangulation& t, std::span<const Point2> xy, std::span<const double> z,
                       std::span<const double> relief, std::span<const unsigned char> kept,
                       std::span<const double> area, const WrinkleOptions& options, const Context& context) {
  for (const double limit : {options.depth, options.length})
    if (!(limit >= 0) || !std::isfinite(limit))
      throw UsageError(fmt::format("{} is no limit of a wrinkle: give a length above 0", limit));
  context.check();
  Wrinkles out;
  Sum total;
  std::size_t nodes = 0;
  for (const double a : area)
    if (a > 0) total.add(a), ++nodes;
  if (nodes == 0) return out;
  out.spacing = std::sqrt(total.value() / static_cast<double>(nodes));
  out.depth = options.depth > 0 ? options.depth : default_depth * nmad(relief, area);
  out.length = options.length > 0 ? options.length : default_length * out.spacing;
  if (!(out.depth > 0)) return out;  // flat
  Valleys valleys(t, xy, z, relief, kept, area, out.depth);
  for (Array<Index>& valley : valleys.connected()) {
    if (valley.size() < least_nodes) continue;
    context.check();
    Wrinkle w = valleys.measured(std::move(valley), stretch * out.spacing);
    if (w.length < out.length || w.length < slender * w.width)
      ++out.pits;
    else if (valleys.runs_along_rim(w))
      ++out.at_rim;
    else if (w.mean_depth > steepest * w.width)
      ++out.steep;
    else
      out.all.push_back(std::move(w));
  }
  std::stable_sort(out.all.begin(), out.all.end(),
                   [](const Wrinkle& a, const Wrinkle& b) { return a.depth > b.depth; });
  return out;
}

LineDepth depth_along(const Wrinkle& w, std::span<const double> relief) {
  std::vector<double> deepest(w.part.size(), nan);
  for (std::size_t k = 0; k < w.nodes.size(); ++k) {
    if (std::isnan(relief[k])) continue;
    double& d = deepest[w.step[k]];
    d = std::isnan(d) ? std::max(0.0, -relief[k]) : std::max(d, -relief[k]);
  }
  LineDepth out{nan, nan};
  Sum length, weighted;
  for (std::size_t s = 0; s < deepest.size(); ++s) {
    if (std::isnan(deepest[s])) continue;
    out.depth = std::isnan(out.depth) ? deepest[s] : std::max(out.depth, deepest[s]);
    length.add(w.part[s]), weighted.add(w.part[s] * deepest[s]);
  }
  if (length.value() > 0) out.mean_depth = weighted.value() / length.value();
  return out;
}

}  // namespace isopach
