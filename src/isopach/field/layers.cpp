// layered_share: does the scan have one height per place? Asked cell by cell, on squares of the curve's quadtree.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "isopach/base/error.hpp"
#include "isopach/field/filter.hpp"
#include "isopach/field/height_field.hpp"

namespace isopach {
namespace {

// The rule, tuned on the scenes and scans of tests/field/layers_test.cpp.
constexpr std::size_t least_points = 8;  // a cell with fewer is not judged
constexpr std::size_t most_points = 48;  // of a fuller cell an even sample is judged
constexpr double points_per_cell = 24;   // wanted, on average over the occupied cells
constexpr double least_group = 0.2;      // share of the cell's points that a layer must have
constexpr double least_separation = 6;   // layers apart, in standard deviations about their planes. One normal layer
                                         // cut in two shows 2.7, a uniform one 3.5.
constexpr double least_height = 0.25;    // layers apart, in point spacings: steps of rounding are no layers
constexpr double least_mixing = 0.5;     // neighbours in the other layer, relative to layers mixed at random

// Points of one cell about their mean, split in two: in_upper[i].
struct Cell {
  std::vector<Point3> points;
  std::vector<double> residual, sorted;
  std::vector<char> in_upper;
  std::size_t upper = 0;
};

struct Slope {
  double x = 0, y = 0;
};

// Least squares for z = slope · (x, y) + one constant per group. The tiny ridge decides for points on a line.
Slope common_slope(const Cell& cell) {
  std::array<Point3, 2> mean{};
  const std::array<double, 2> count{static_cast<double>(cell.points.size() - cell.upper),
                                    static_cast<double>(cell.upper)};
  for (std::size_t i = 0; i < cell.points.size(); ++i) {
    Point3& m = mean[static_cast<std::size_t>(cell.in_upper[i])];
    m.x += cell.points[i].x, m.y += cell.points[i].y, m.z += cell.points[i].z;
  }
  for (std::size_t g = 0; g < 2; ++g)
    if (count[g] > 0) mean[g] = {mean[g].x / count[g], mean[g].y / count[g], mean[g].z / count[g]};
  double xx = 0, xy = 0, yy = 0, xz = 0, yz = 0;
  for (std::size_t i = 0; i < cell.points.size(); ++i) {
    const Point3& m = mean[static_cast<std::size_t>(cell.in_upper[i])];
    const double x = cell.points[i].x - m.x, y = cell.points[i].y - m.y, z = cell.points[i].z - m.z;
    xx += x * x, xy += x * y, yy += y * y, xz += x * z, yz += y * z;
  }
  const double ridge = 1e-9 * (xx + yy);
  xx += ridge, yy += ridge;
  const double determinant = xx * yy - xy * xy;
  if (!(determinant > 0)) return {};
  return {(xz * yy - yz * xy) / determinant, (yz * xx - xz * xy) / determinant};
}

// Splits the cell at the widest gap of height over the slope that leaves least_group on either side.
void split_at_gap(Cell& cell, const Slope& slope) {
  const std::size_t n = cell.points.size();
  cell.residual.resize(n);
  for (std::size_t i = 0; i < n; ++i)
    cell.residual[i] = cell.points[i].z - slope.x * cell.points[i].x - slope.y * cell.points[i].y;
  cell.sorted = cell.residual;
  std::sort(cell.sorted.begin(), cell.sorted.end());
  const auto least = static_cast<std::size_t>(std::ceil(least_group * static_cast<double>(n)));
  std::size_t cut = least;
  for (std::size_t k = least; k + least <= n; ++k)
    if (cell.sorted[k] - cell.sorted[k - 1] > cell.sorted[cut] - cell.sorted[cut - 1]) cut = k;
  cell.upper = 0;
  for (std::size_t i = 0; i < n; ++i) {
    cell.in_upper[i] = cell.residual[i] >= cell.sorted[cut];
    cell.upper += static_cast<std::size_t>(cell.in_upper[i]);
  }
}

// Are the groups so far apart that they are two layers and not one with noise?
bool far_apart(const Cell& cell, const Slope& slope, double spacing) {
  const std::size_t n = cell.points.size();
  std::array<double, 2> mean{};
  for (std::size_t i = 0; i < n; ++i) {
    const double r = cell.points[i].z - slope.x * cell.points[i].x - slope.y * cell.points[i].y;
    mean[static_cast<std::size_t>(cell.in_upper[i])] += r;
  }
  mean[0] /= static_cast<double>(n - cell.upper), mean[1] /= static_cast<double>(cell.upper);
  double squares = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double r = cell.points[i].z - slope.x * cell.points[i].x - slope.y * cell.points[i].y -
                     mean[static_cast<std::size_t>(cell.in_upper[i])];
    squares += r * r;
  }
  const double spread = std::sqrt(squares / static_cast<double>(n - 4));
  const double apart = mean[1] - mean[0];
  return apart > least_separation * spread && apart > least_height * spacing;
}

// Do the groups lie among each other? Two sides of a cliff, or a block on the ground, do not: there a point's nearest
// neighbour in the plane is mostly of its own group. Of points mixed at random, 2 k (n − k) / (n (n − 1)) have theirs
// in the other.
bool mixed(const Cell& cell) {
  const std::size_t n = cell.points.size();
  double across = 0;
  for (std::size_t i = 0; i < n; ++i) {
    double nearest[2] = {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    for (std::size_t j = 0; j < n; ++j) {
      if (j == i) continue;
      const double dx = cell.points[j].x - cell.points[i].x, dy = cell.points[j].y - cell.points[i].y;
      double& best = nearest[cell.in_upper[j] == cell.in_upper[i] ? 0 : 1];
      best = std::min(best, dx * dx + dy * dy);
    }
    across += nearest[1] < nearest[0] ? 1 : nearest[1] == nearest[0] ? 0.5 : 0;
  }
  const auto k = static_cast<double>(cell.upper), m = static_cast<double>(n);
  return across / m >= least_mixing * 2 * k * (m - k) / (m * (m - 1));
}

bool layered(Cell& cell, double spacing) {
  cell.in_upper.assign(cell.points.size(), 0);
  cell.upper = 0;
  Slope slope = common_slope(cell);
  for (int round = 0; round < 3;
       ++round) {  // layers mixed unevenly tilt the first plane; the next ones know the layers
    split_at_gap(cell, slope);
    slope = common_slope(cell);
  }
  if (cell.upper == 0 || cell.upper == cell.points.size()) return false;
  return far_apart(cell, slope, spacing) && mixed(cell);
}

// The level of the quadtree whose occupied squares hold about points_per_cell: squares of level l are runs of keys that
// share 2 l bits, so their number is one more than the neighbours in the order that part by then.
int cell_level(const Array<std::uint64_t>& keys) {
  using Parted = std::array<std::size_t, 33>;
  const Parted parted = reduce_blocks<Parted>(
      keys.size(), default_block,
      [&](std::size_t begin, std::size_t end) {
        Parted part{};
        for (std::size_t k = std::max<std::size_t>(begin, 1); k < end; ++k)
          if (keys[k] != keys[k - 1]) ++part[static_cast<std::size_t>(std::countl_zero(keys[k] ^ keys[k - 1]) / 2 + 1)];
        return part;
      },
      [](Parted& total, const Parted& part) {
        for (std::size_t i = 0; i < total.size(); ++i) total[i] += part[i];
      });
  std::size_t cells = 1;
  int level = 0;
  while (level < 32) {
    cells += parted[static_cast<std::size_t>(level + 1)];
    // levels are a factor 4 apart: the next one is nearer to the wanted number while it holds half of it or more
    if (static_cast<double>(keys.size()) < points_per_cell / 2 * static_cast<double>(cells)) break;
    ++level;
  }
  return level;
}

}  // namespace

double layered_share(const Cloud& cloud, const Pose& pose, const Frame& frame, const ProjectOptions& options,
                     const Context& context) {
  context.check();
  const Filter filter(cloud, pose, options);
  Array<Point2> xy;
  Array<Index> ids;
  for (std::size_t i = 0; i < filter.size(); ++i) {
    const Point3 p = filter.posed(i);
    if (filter.fate(i, p) != Filter::Fate::kept) continue;
    const Point3 q = frame.to_field(p);
    xy.push_back({q.x, q.y});
    ids.push_back(static_cast<Index>(i));
  }
  Array<std::uint64_t> keys;
  const Array<Index> order = curve_order(xy, frame.curve, &keys);
  context.check();
  const int level = cell_level(keys);
  const auto same_cell = [&](std::size_t i, std::size_t j) {
    return level == 0 || (keys[i] ^ keys[j]) >> (64 - 2 * level) == 0;
  };
  const double width = std::ldexp(1.0 / frame.curve.scale, 32 - level);
  struct Tally {
    std::size_t judged = 0, layered = 0;
  };
  const Tally tally = reduce_blocks<Tally>(
      keys.size(), default_block,
      [&](std::size_t begin, std::size_t end) {
        Tally part;
        Cell cell;
        std::vector<Point3> all;
        for (std::size_t k = begin; k < end; ++k) {
          if (k > 0 && same_cell(k - 1, k)) continue;
          all.clear();
          for (std::size_t i = k; i < keys.size() && same_cell(k, i); ++i) {
            const Point3 q = frame.to_field(filter.posed(ids[order[i]]));
            all.push_back({q.x, q.y, q.z});
          }
          if (all.size() < least_points) continue;
          std::sort(all.begin(), all.end(), [](const Point3& a, const Point3& b) {
            return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
          });
          const std::size_t n = std::min(all.size(), most_points);
          cell.points.resize(n);
          for (std::size_t i = 0; i < n; ++i) cell.points[i] = all[i * all.size() / n];
          ++part.judged;
          part.layered += layered(cell, width / std::sqrt(static_cast<double>(n)));
        }
        return part;
      },
      [](Tally& total, const Tally& part) {
        total.judged += part.judged;
        total.layered += part.layered;
      });
  return tally.judged == 0 ? 0 : static_cast<double>(tally.layered) / static_cast<double>(tally.judged);
}

}  // namespace isopach
