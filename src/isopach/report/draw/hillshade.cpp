#include "isopach/report/draw/hillshade.hpp"

#include <algorithm>
#include <cmath>

#include "isopach/base/parallel.hpp"

namespace isopach {
namespace {

constexpr double darkest = 0.35;
constexpr double flat_grey = 0.92;         // level ground is nearly white, so that colours keep their meaning
constexpr double wanted_slope = 0.33;      // of the 80th percentile after exaggeration
constexpr double least = 0.02, most = 30;  // bounds of the exaggeration: more would paint noise only
constexpr std::size_t slope_samples = 200000;

struct Gradient {
  double x, y;
};

class Slopes {
 public:
  explicit Slopes(const CellRaster& raster) : r_(raster) {}

  [[nodiscard]] bool known(int column, int row) const {
    if (column < 0 || row < 0 || column >= r_.view.columns || row >= r_.view.rows) return false;
    return r_.cover[at(column, row)] == CellRaster::Cover::domain;
  }

  /// Central difference; one-sided at the rim; 0 for a lone pixel.
  [[nodiscard]] Gradient operator()(int column, int row) const {
    return {along(column, row, 1, 0), along(column, row, 0, -1)};
  }

 private:
  [[nodiscard]] std::size_t at(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(r_.view.columns) + static_cast<std::size_t>(column);
  }
  [[nodiscard]] double along(int column, int row, int step_column, int step_row) const {
    const bool ahead = known(column + step_column, row + step_row),
               behind = known(column - step_column, row - step_row);
    if (!ahead && !behind) return 0;
    const double here = r_.z[at(column, row)];
    const double z1 = ahead ? r_.z[at(column + step_column, row + step_row)] : here;
    const double z0 = behind ? r_.z[at(column - step_column, row - step_row)] : here;
    return (z1 - z0) * r_.view.scale / (ahead && behind ? 2 : 1);
  }
  const CellRaster& r_;
};

double choose_exaggeration(const CellRaster& raster, const Slopes& slopes) {
  const std::size_t n = raster.cover.size(), stride = std::max<std::size_t>(1, n / slope_samples) | 1;
  std::vector<double> sample;
  for (std::size_t i = 0; i < n; i += stride) {
    if (raster.cover[i] != CellRaster::Cover::domain) continue;
    const std::size_t columns = static_cast<std::size_t>(raster.view.columns);
    const Gradient g = slopes(static_cast<int>(i % columns), static_cast<int>(i / columns));
    sample.push_back(std::hypot(g.x, g.y));
  }
  if (sample.empty()) return 1;
  const auto at80 = sample.begin() + static_cast<std::ptrdiff_t>(sample.size() * 4 / 5);
  std::nth_element(sample.begin(), at80, sample.end());
  return *at80 > 0 ? std::clamp(wanted_slope / *at80, least, most) : 1;
}

}  // namespace

Hillshade hillshade(const CellRaster& raster) {
  const Slopes slopes(raster);
  Hillshade shade;
  shade.exaggeration = choose_exaggeration(raster, slopes);
  shade.grey.resize(raster.cover.size());
  const double flat = std::sqrt(0.5);  // cosine of the light on level ground
  for_blocks(static_cast<std::size_t>(raster.view.rows), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row)
      for (int column = 0; column < raster.view.columns; ++column) {
        const std::size_t i = row * static_cast<std::size_t>(raster.view.columns) + static_cast<std::size_t>(column);
        if (raster.cover[i] != CellRaster::Cover::domain) {
          shade.grey[i] = 1;
          continue;
        }
        const Gradient g = slopes(column, static_cast<int>(row));
        const double x = -g.x * shade.exaggeration, y = -g.y * shade.exaggeration;
        const double cosine = (-0.5 * x + 0.5 * y + flat) / std::sqrt(x * x + y * y + 1);
        // Two straight pieces: 0 … flat … 1 becomes darkest … flat_grey … 1.
        const double grey = cosine < flat ? darkest + (flat_grey - darkest) * std::max(0.0, cosine) / flat
                                          : flat_grey + (1 - flat_grey) * (cosine - flat) / (1 - flat);
        shade.grey[i] = static_cast<float>(grey);
      }
  });
  return shade;
}

}  // namespace isopach
