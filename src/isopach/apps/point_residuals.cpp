#include "isopach/apps/point_residuals.hpp"

#include <algorithm>
#include <cmath>

#include "isopach/apps/patches.hpp"
#include "isopach/base/median.hpp"
#include "isopach/base/sum.hpp"

namespace isopach {
namespace {

struct Entry {
  Index node;
  double d;
};

/// Residuals in the order of the curve, whatever that of the points.
std::vector<Entry> in_order(const HeightField& field, const Array<double>& d) {
  std::vector<Entry> entries;
  for (std::size_t i = 0; i < d.size(); ++i)
    if (std::isfinite(d[i]) && field.node_of_point[i] != no_index) entries.push_back({field.node_of_point[i], d[i]});
  std::sort(entries.begin(), entries.end(),
            [](const Entry& a, const Entry& b) { return a.node != b.node ? a.node < b.node : a.d < b.d; });
  return entries;
}

}  // namespace

PointResiduals point_residuals(const CloudView& cloud, const Pose& pose, const Frame& frame,
                               const ProjectOptions& options, const Array<double>& field, const Context& context) {
  const HeightField nodes = project(cloud, pose, frame, options, context);
  const std::vector<Entry> entries = in_order(nodes, field);
  PointResiduals r;
  r.count = entries.size();
  if (entries.empty()) return r;
  const auto n = static_cast<double>(entries.size());
  Sum total, squares;
  for (const Entry& e : entries) total.add(e.d), squares.add(e.d * e.d);
  r.bias = total.value() / n;
  r.rms = std::sqrt(squares.value() / n);
  Sum about;
  for (const Entry& e : entries) about.add((e.d - r.bias) * (e.d - r.bias));
  r.std = std::sqrt(about.value() / n);

  std::vector<double> variances;
  Sum of_means;
  for (std::size_t begin = 0; begin + patch <= entries.size(); begin += patch) {
    PatchValues<2> xy;
    PatchValues<1> d;
    for (int k = 0; k < patch; ++k) {
      const Entry& e = entries[begin + static_cast<std::size_t>(k)];
      xy.row(k) << nodes.xy[e.node].x, nodes.xy[e.node].y;
      d[k] = e.d;
    }
    const double mean = d.mean();
    of_means.add((mean - r.bias) * (mean - r.bias));
    variances.push_back(patch_variance(xy, d));
  }
  if (variances.empty()) {
    r.noise = r.std;
    return r;
  }
  const double variance = median(variances);
  r.noise = std::sqrt(variance);
  r.form = std::sqrt(std::max(0.0, of_means.value() / static_cast<double>(variances.size()) - variance / patch));
  return r;
}

}  // namespace isopach
