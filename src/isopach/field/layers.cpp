// layered_share: does the scan have one height per place? Asked cell by cell, on squares of the curve's quadtree.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "isopach/field/filter.hpp"
#include "isopach/field/height_field.hpp"

namespace isopach {
namespace {

// The rule, tuned on the scenes and scans of tests/field/layers_test.cpp.
constexpr std::size_t least_points = 12;    // a cell with fewer is not judged
constexpr std::size_t most_points = 128;    // of a fuller cell an even sample is judged
constexpr double least_mean = 24;           // points per occupied cell, on average: from this to 4 times this
constexpr double least_group = 0.2;         // share of the cell's points that a layer must have
constexpr double least_separation = 6;      // layers apart, in standard deviations about their planes. One normal layer
                                            // cut in two shows 2.7, a uniform one 3.5.
constexpr double least_height = 0.25;       // layers apart, in point spacings: steps of rounding are no layers
constexpr std::size_t enough_cells = 4096;  // of more cells an even sample is judged: the share is then right to 1 %
constexpr double least_mixing = 0.5;        // neighbours in the other layer, relative to layers mixed at random

struct Slope {
  double x = 0, y = 0;
};

// Second moments of points about their mean.
struct Scatter {
  double xx = 0, xy = 0, yy = 0, xz = 0, yz = 0, zz = 0;

  // Least squares for z. The tiny ridge decides for points on a line.
  [[nodiscard]] Slope slope() const {
    const double ridge = 1e-9 * (xx + yy), a = xx + ridge, b = yy + ridge;
    const double determinant = a * b - xy * xy;
    if (!(determinant > 0)) return {};
    return {(xz * b - yz * xy) / determinant, (yz * a - xz * xy) / determinant};
  }
  [[nodiscard]] double squares_about(const Slope& s) const { return std::max(0.0, zz - s.x * xz - s.y * yz); }
};

struct Group {
  double n = 0;
  Point3 mean{0, 0, 0};
  Scatter scatter;
};

// Points of one cell, about the mean of all. Each belongs to the lower (0) or upper (1) group.
struct Cell {
  std::vector<Point3> points;
  std::vector<char> group_of;
  std::array<Group, 2> groups;
  std::vector<double> residual, sorted;  // room to work in
};

void sum_groups(Cell& cell) {
  cell.groups = {};
  for (std::size_t i = 0; i < cell.points.size(); ++i) {
    Group& g = cell.groups[static_cast<std::size_t>(cell.group_of[i])];
    const Point3& p = cell.points[i];
    g.n += 1, g.mean.x += p.x, g.mean.y += p.y, g.mean.z += p.z;
  }
  for (Group& g : cell.groups)
    if (g.n > 0) g.mean = {g.mean.x / g.n, g.mean.y / g.n, g.mean.z / g.n};
  for (std::size_t i = 0; i < cell.points.size(); ++i) {
    Group& g = cell.groups[static_cast<std::size_t>(cell.group_of[i])];
    const double x = cell.points[i].x - g.mean.x, y = cell.points[i].y - g.mean.y, z = cell.points[i].z - g.mean.z;
    Scatter& s = g.scatter;
    s.xx += x * x, s.xy += x * y, s.yy += y * y, s.xz += x * z, s.yz += y * z, s.zz += z * z;
  }
}

// Cuts the cell at the widest gap of height above the slope that leaves least_group on either side.
void cut_at_gap(Cell& cell, const Slope& slope) {
  const std::size_t n = cell.points.size();
  cell.residual.resize(n);
  for (std::size_t i = 0; i < n; ++i)
    cell.residual[i] = cell.points[i].z - slope.x * cell.points[i].x - slope.y * cell.points[i].y;
  cell.sorted = cell.residual;
  std::sort(cell.sorted.begin(), cell.sorted.end());
  const auto least = static_cast<std::size_t>(std::ceil(least_group * static_cast<double>(n)));
  std::size_t cut = least;
  const auto gap = [&](std::size_t k) { return cell.sorted[k] - cell.sorted[k - 1]; };
  for (std::size_t k = least; k + least <= n; ++k)
    if (gap(k) > gap(cut)) cut = k;
  for (std::size_t i = 0; i < n; ++i) cell.group_of[i] = cell.residual[i] >= cell.sorted[cut];
}

// Are the groups two layers, and not one with noise? Their planes, each of its own, are compared at the cell's mean.
bool far_apart(const std::array<Group, 2>& groups, double spacing) {
  std::array<double, 2> height{};
  double squares = 0;
  for (std::size_t g = 0; g < 2; ++g) {
    const Group& group = groups[g];
    const Slope slope = group.scatter.slope();
    height[g] = group.mean.z - slope.x * group.mean.x - slope.y * group.mean.y;
    squares += group.scatter.squares_about(slope);
  }
  const double spread = std::sqrt(squares / (groups[0].n + groups[1].n - 6));
  const double apart = std::fabs(height[1] - height[0]);
  return apart > least_separation * spread && apart > least_height * spacing;
}

// Do the groups lie among each other? Two sides of a cliff, or a block on the ground, do not: there a point's nearest
// neighbour in the plane is mostly of its own group. Of points mixed at random, 2 k (n − k) / (n (n − 1)) have theirs
// in the other.
bool mixed(const Cell& cell) {
  const std::size_t n = cell.points.size();
  double across = 0;
  for (std::size_t i = 0; i < n; ++i) {
    std::array<double, 2> nearest{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    for (std::size_t j = 0; j < n; ++j) {
      if (j == i) continue;
      const double dx = cell.points[j].x - cell.points[i].x, dy = cell.points[j].y - cell.points[i].y;
      double& best = nearest[cell.group_of[j] == cell.group_of[i] ? 0 : 1];
      best = std::min(best, dx * dx + dy * dy);
    }
    across += nearest[1] < nearest[0] ? 1 : nearest[1] == nearest[0] ? 0.5 : 0;
  }
  const double k = cell.groups[0].n, m = cell.groups[1].n;
  return across >= least_mixing * 2 * k * m / (k + m - 1);
}

// `all` is sorted, so the answer is a function of the set.
bool layered(const std::vector<Point3>& all, double width, Cell& cell) {
  const std::size_t n = std::min(all.size(), most_points);
  cell.points = all;
  if (n < all.size())
    for (std::size_t i = 0; i < n; ++i) cell.points[i] = all[i * all.size() / n];
  cell.points.resize(n);
  cell.group_of.assign(n, 0);
  sum_groups(cell);
  const Point3 mean = cell.groups[0].mean;
  for (Point3& p : cell.points) p = {p.x - mean.x, p.y - mean.y, p.z - mean.z};
  cut_at_gap(cell, cell.groups[0].scatter.slope());
  sum_groups(cell);
  if (cell.groups[0].n == 0) return false;  // no gap at all: all residuals are equal
  return far_apart(cell.groups, width / std::sqrt(static_cast<double>(n))) && mixed(cell);
}

// Of each node how many levels of squares of the quadtree it shares with the one before it on the curve, 0 to 32.
// Squares of level l are runs of nodes that share l levels or more: of equal first l digits of the key.
Array<unsigned char> shared_levels(const Array<std::uint64_t>& keys) {
  Array<unsigned char> shared(keys.size());
  for_each_index(keys.size(), [&](std::size_t k) {
    shared[k] = static_cast<unsigned char>(k == 0 ? 0 : std::countl_zero(keys[k] ^ keys[k - 1]) / 2);
  });
  return shared;
}

// The deepest level of the quadtree whose occupied squares hold least_mean points or more on average.
struct Level {
  int level;
  std::size_t cells;  // occupied
};
using Counts = std::array<std::uint64_t, 33>;

Counts counts_of(const Array<unsigned char>& shared) {
  return reduce_blocks<Counts>(
      shared.size(), default_block,
      [&](std::size_t begin, std::size_t end) {
        Counts part{};
        for (std::size_t k = std::max<std::size_t>(begin, 1); k < end; ++k) ++part[shared[k]];
        return part;
      },
      [](Counts& total, const Counts& part) {
        for (std::size_t i = 0; i < total.size(); ++i) total[i] += part[i];
      });
}

Level cell_level(const Counts& counts, std::size_t points) {
  std::size_t cells = 1;
  for (int level = 0; level < 32; ++level) {
    const std::size_t finer = cells + counts[static_cast<std::size_t>(level)];
    if (static_cast<double>(points) < least_mean * static_cast<double>(finer)) return {level, cells};
    cells = finer;
  }
  return {32, cells};
}

// One cell in a power of two, told by the bits of its key, well mixed: a function of the place, spread evenly.
class Sample {
 public:
  explicit Sample(const Level& level) : Sample(level.level, mask_of(level.cells)) {}
  Sample(int level, std::uint64_t mask) : shift_(64 - 2 * level), mask_(mask) {}
  static std::uint64_t mask_of(std::size_t cells) {
    return std::bit_floor(std::max<std::size_t>(1, cells / enough_cells)) - 1;
  }
  [[nodiscard]] std::uint64_t cell(std::uint64_t key) const { return shift_ >= 64 ? 0 : key >> shift_; }
  [[nodiscard]] bool holds(std::uint64_t key) const { return ((cell(key) * 0x9e3779b97f4a7c15ULL >> 32) & mask_) == 0; }

 private:
  int shift_;
  std::uint64_t mask_;
};

// The heights of the points of each node. Only where points were merged: else they are those of the nodes.
class Heights {
 public:
  Heights(const CloudView& cloud, const Pose& pose, const Frame& frame, const HeightField& field) : field_(field) {
    if (field.cleaning.duplicates == 0) return;
    const std::size_t n = cloud.points.size();
    const auto for_kept = [&](const auto& work) {
      for (std::size_t i = 0; i < n; ++i)
        if (field.node_of_point[i] != no_index) work(i, field.node_of_point[i]);
    };
    end_.assign(field.xy.size(), 0);
    for_kept([&](std::size_t, Index node) { ++end_[node]; });
    Index sum = 0;
    for (Index& end : end_) sum += std::exchange(end, sum);
    z_.resize(sum);
    for_kept([&](std::size_t i, Index node) { z_[end_[node]++] = frame.to_field(pose.apply(cloud.points[i])).z; });
  }

  void add_points(std::size_t node, std::vector<Point3>& points) const {
    const auto& [x, y] = field_.xy[node];
    if (end_.empty()) {
      points.push_back({x, y, field_.z[node]});
    } else {
      for (Index i = node > 0 ? end_[node - 1] : 0; i < end_[node]; ++i) points.push_back({x, y, z_[i]});
    }
  }

 private:
  const HeightField& field_;
  Array<Index> end_;  // of the heights of each node
  Array<double> z_;
};

struct Tally {
  std::size_t judged = 0, layered = 0;

  // The points of one cell, in any order.
  void judge(std::vector<Point3>& points, double width, Cell& cell) {
    if (points.size() < least_points) return;
    std::sort(points.begin(), points.end(), [](const Point3& a, const Point3& b) {
      return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
    });
    ++judged;
    layered += isopach::layered(points, width, cell);
  }
  [[nodiscard]] double share() const {
    return judged == 0 ? 0 : static_cast<double>(layered) / static_cast<double>(judged);
  }
};

double width_of(const CurveBox& box, int level) { return std::ldexp(1 / box.scale, 32 - level); }

}  // namespace

double layered_share(const HeightField& field, const CloudView& cloud, const Pose& pose, const Frame& frame,
                     const Context& context) {
  context.check();
  const Array<unsigned char> shared = shared_levels(field.keys);
  const Level found = cell_level(counts_of(shared), count_kept(field.cleaning));
  const Sample sample(found);
  const double width = width_of(frame.curve, found.level);
  const auto begins_cell = [&](std::size_t node) { return node == 0 || shared[node] < found.level; };
  const Heights heights(cloud, pose, frame, field);
  // A cell is judged by the block in which it begins.
  const Tally tally = reduce_blocks<Tally>(
      field.xy.size(), default_block,
      [&](std::size_t begin, std::size_t end) {
        Tally part;
        Cell cell;
        std::vector<Point3> points;
        for (std::size_t k = begin; k < end; ++k) {
          if (!begins_cell(k) || !sample.holds(field.keys[k])) continue;
          points.clear();
          std::size_t node = k;
          do heights.add_points(node++, points);
          while (node < field.xy.size() && !begins_cell(node));
          part.judge(points, width, cell);
        }
        return part;
      },
      [](Tally& total, const Tally& part) {
        total.judged += part.judged;
        total.layered += part.layered;
      });
  return tally.share();
}

void LayerCheck::add_nodes(std::span<const std::uint64_t> keys) {
  if (keys.empty()) return;
  State part{counts_of(shared_levels(Array<std::uint64_t>(keys.begin(), keys.end()))), keys.front(), keys.back(),
             keys.size()};
  add(LayerCheck(part));
}

void LayerCheck::add(const LayerCheck& behind) {
  const State& other = behind.state_;
  if (other.nodes == 0) return;
  if (state_.nodes == 0)
    state_.first = other.first;
  else
    ++state_.counts[static_cast<std::size_t>(std::countl_zero(other.first ^ state_.last) / 2)];
  for (std::size_t i = 0; i < other.counts.size(); ++i) state_.counts[i] += other.counts[i];
  state_.last = other.last;
  state_.nodes += other.nodes;
}

void LayerCheck::begin(std::size_t points, const CurveBox& box) {
  const Level found = cell_level(state_.counts, points);
  box_ = box, level_ = found.level, mask_ = Sample::mask_of(found.cells);
}

void LayerCheck::add_points(std::span<const Point3> in_frame) {
  const Sample sample(level_, mask_);
  const auto some =
      gather_blocks<Array<Sampled>>(in_frame.size(), default_block, [&](std::size_t begin, std::size_t end) {
        Array<Sampled> part;
        for (std::size_t i = begin; i < end; ++i) {
          const std::uint64_t key = curve_key(box_, {in_frame[i].x, in_frame[i].y});
          if (sample.holds(key)) part.push_back({sample.cell(key), in_frame[i]});
        }
        return part;
      });
  sampled_.insert(sampled_.end(), some.begin(), some.end());
}

double LayerCheck::share(const Context& context) {
  context.check();
  std::sort(sampled_.begin(), sampled_.end(), [](const Sampled& a, const Sampled& b) { return a.key < b.key; });
  Tally tally;
  Cell cell;
  std::vector<Point3> points;
  for (std::size_t i = 0; i < sampled_.size();) {
    points.clear();
    const std::size_t first = i;
    do points.push_back(sampled_[i++].at);
    while (i < sampled_.size() && sampled_[i].key == sampled_[first].key);
    tally.judge(points, width_of(box_, level_), cell);
  }
  return tally.share();
}

double layered_share(const CloudView& cloud, const Pose& pose, const Frame& frame, const ProjectOptions& options,
                     const Context& context) {
  ProjectOptions merging = options;
  merging.duplicates = DuplicatePolicy::min;  // which, does not matter; an error would
  return layered_share(project(cloud, pose, frame, merging, context), cloud, pose, frame, context);
}

}  // namespace isopach
