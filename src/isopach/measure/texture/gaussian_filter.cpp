#include "isopach/measure/texture/gaussian_filter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "isopach/base/error.hpp"
#include "isopach/base/median.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/measure/gaussian_sums.hpp"

namespace isopach {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double most_boxes = 1e9;  // a side
constexpr double singular = 1e-6;   // of the variance of places, ½ in the open: no slope is seen in that direction
constexpr double tuning = 4.4478;   // of the biweight, in medians: 3 standard deviations of normal heights
constexpr int most_passes = 10;
constexpr double settled = 1e-3;

/// √δ of the kernel exp(−r²/δ): α λc / √π.
double kernel_width(double cutoff) { return cutoff * std::sqrt(std::numbers::ln2) / std::numbers::pi; }

double fitted(const GaussianMoments& m, unsigned degree) {
  const double mean = m.z00 / m.a00;
  if (degree == 0) return mean;
  const double u = m.a10 / m.a00, v = m.a01 / m.a00;
  const double uu = m.a20 / m.a00 - u * u, uv = m.a11 / m.a00 - u * v, vv = m.a02 / m.a00 - v * v;
  const double zu = m.z10 / m.a00 - u * mean, zv = m.z01 / m.a00 - v * mean, determinant = uu * vv - uv * uv;
  if (!(determinant > singular * (uu + vv))) return mean;
  return mean - u * (vv * zu - uv * zv) / determinant - v * (uu * zv - uv * zu) / determinant;
}

/// Heights relative to a middle one, so that the error of the sums is one of the range of heights.
double middle_of(std::span<const double> area, std::span<const double> z) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (std::size_t i = 0; i < z.size(); ++i)
    if (area[i] > 0) low = std::min(low, z[i]), high = std::max(high, z[i]);
  return low <= high ? low + (high - low) / 2 : 0;
}

GaussianBoxes sorted(std::span<const Point2> xy, std::span<const double> area, double cutoff) {
  if (!(cutoff > 0) || !std::isfinite(cutoff))
    throw UsageError(fmt::format("a cut-off of {} makes no sense: give a length above 0", cutoff));
  Box2 box;
  for (std::size_t i = 0; i < xy.size(); ++i)
    if (area[i] > 0) box.add(xy[i]);
  const double width = kernel_width(cutoff);
  if (!box.empty() && !(std::max(box.max.x - box.min.x, box.max.y - box.min.y) / width < most_boxes))
    throw UsageError(fmt::format("a cut-off of {} is too short for a scan of this extent: give a longer one", cutoff));
  return {xy, area, width};
}

/// `weight` may be 0 where the boxes have a node; `mean` keeps its value where nothing near has weight.
void filter(const GaussianBoxes& boxes, std::span<const double> weight, std::span<const double> z, double width,
            unsigned degree, double middle, Array<double>& mean, const Context& context) {
  Array<double> unit_weight(z.size()), weighted(z.size());
  for_each_index(z.size(), [&](std::size_t i) {
    unit_weight[i] = weight[i] / (width * width);
    weighted[i] = weight[i] > 0 ? unit_weight[i] * (z[i] - middle) : 0;
  });
  const Array<GaussianMoments> moments =
      gaussian_moments(boxes, unit_weight, weighted, degree, GaussianMethod::automatic, context);
  for_each_index(boxes.nodes.size(), [&](std::size_t k) {
    const double value = fitted(moments[k], degree);
    if (std::isfinite(value)) mean[boxes.nodes[k]] = middle + value;
  });
}

double median_size(const GaussianBoxes& boxes, std::span<const double> z, std::span<const double> mean) {
  std::vector<double> sizes(boxes.nodes.size());
  for (std::size_t k = 0; k < sizes.size(); ++k) sizes[k] = std::fabs(z[boxes.nodes[k]] - mean[boxes.nodes[k]]);
  return median(sizes);
}

}  // namespace

double gaussian_transmission(double cutoff, double wavelength) {
  const double ratio = cutoff / wavelength;
  return std::exp(-std::numbers::ln2 * ratio * ratio);
}

Array<double> gaussian_mean(std::span<const Point2> xy, std::span<const double> area, std::span<const double> z,
                            const GaussianOptions& options, const Context& context) {
  const GaussianBoxes boxes = sorted(xy, area, options.cutoff);
  Array<double> mean(z.size());
  std::fill(mean.begin(), mean.end(), nan);
  filter(boxes, area, z, kernel_width(options.cutoff), options.degree, middle_of(area, z), mean, context);
  return mean;
}

Array<double> robust_gaussian_mean(std::span<const Point2> xy, std::span<const double> area, std::span<const double> z,
                                   const GaussianOptions& options, const Context& context) {
  const GaussianBoxes boxes = sorted(xy, area, options.cutoff);
  Array<double> mean(z.size()), weight(area.begin(), area.end());
  std::fill(mean.begin(), mean.end(), nan);
  if (boxes.nodes.empty()) return mean;
  const double middle = middle_of(area, z), width = kernel_width(options.cutoff);
  double before = std::numeric_limits<double>::infinity();
  for (int pass = 0; pass < most_passes; ++pass) {
    filter(boxes, weight, z, width, options.degree, middle, mean, context);
    const double c = tuning * median_size(boxes, z, mean);
    if (!(c > 0) || std::fabs(before - c) < settled * c) break;
    before = c;
    for_each_index(boxes.nodes.size(), [&](std::size_t k) {
      const Index i = boxes.nodes[k];
      const double t = (z[i] - mean[i]) / c, rest = 1 - t * t;
      weight[i] = rest > 0 ? area[i] * rest * rest : 0;
    });
  }
  return mean;
}

}  // namespace isopach
