// Inside currents.cpp and currents_gradient.cpp: the triangles of two currents, sorted into cubes, and the Chebyshev
// grids that stand for those of full cubes. Lengths are in σ; places are relative to the corner of their cube.
//
// The side of a cube is 2 σ rounded to 8 bits, so that the corners are exact numbers and what is far from the origin is
// as precise as what is near it.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "isopach/measure/currents/currents.hpp"

namespace isopach::currents_parts {

inline constexpr int most_nodes = 24;             ///< along one side of a grid
inline constexpr std::size_t cubes_a_block = 16;  ///< of parallel work
inline constexpr double pair_rounding = 1e-13;    ///< of one pair, relative to |n_i| |n_j| times its kernel
using Vector = std::array<double, 3>;

/// Places with a normal of each scan (zero where a place is of the other): sources of cubes, or nodes of grids.
struct Points {
  std::array<std::vector<double>, 3> at;
  std::array<std::array<std::vector<double>, 3>, 2> normal;  ///< by scan

  void resize(std::size_t n);
};

struct Range {
  const Points* points;
  std::size_t begin, end;
  [[nodiscard]] std::size_t size() const { return end - begin; }
};

struct Cube {
  std::array<std::int64_t, 3> key;  ///< corner, in sides
  std::size_t begin, middle, end;   ///< sources; before middle those of scan 1
  Vector low{}, high{};             ///< of the sources
  std::array<double, 2> weight{};   ///< Σ |n| by scan
  std::array<int, 3> p{};           ///< nodes of the grid; 0: none
  Vector error{};                   ///< of interpolation along each side, where the kernel is largest
  std::size_t first_node = 0;       ///< of its grid among all grids

  [[nodiscard]] std::size_t sources() const { return end - begin; }
  [[nodiscard]] bool has_grid() const { return p[0] > 0; }
  [[nodiscard]] std::size_t nodes() const {
    return static_cast<std::size_t>(p[0]) * static_cast<std::size_t>(p[1]) * static_cast<std::size_t>(p[2]);
  }
  /// Chebyshev node `a` along a side.
  [[nodiscard]] double node(std::size_t side, int a) const;
};

/// Bound of the Lebesgue constant of p Chebyshev nodes.
[[nodiscard]] double lebesgue(int p);

class Cubes {
 public:
  /// Sorts both currents, in each cube in the order given. Cost near-linear: triangles that follow one another in one
  /// cube are moved as one. Throws UsageError naming --sigma for coordinates of 2^44 cubes and more.
  Cubes(const Current& a, const Current& b, double sigma);

  /// Grids that keep the kernel's error of a pair below `share`, for cubes with enough sources to need one; and the
  /// reach beyond which pairs are left out.
  void make_grids(double share);

  [[nodiscard]] const std::vector<Cube>& cubes() const { return cubes_; }
  [[nodiscard]] const Points& sources() const { return sources_; }
  [[nodiscard]] const Points& grids() const { return grids_; }
  [[nodiscard]] Range sources_of(const Cube& c) const { return {&sources_, c.begin, c.end}; }
  [[nodiscard]] Range grid_of(const Cube& c) const { return {&grids_, c.first_node, c.first_node + c.nodes()}; }
  [[nodiscard]] double share() const { return share_; }

  /// Corner of `to` less that of `from`.
  [[nodiscard]] Vector offset(const Cube& from, const Cube& to) const;
  /// Corner of `c` less `origin` (in the unit of the centroids).
  [[nodiscard]] Vector corner(const Cube& c, const Point3& origin) const;

  /// Σ |n| of each scan, and what pairs never looked at can add to a product with them, by scan.
  [[nodiscard]] const std::array<double, 2>& total() const { return total_; }
  [[nodiscard]] std::array<double, 2> beyond_reach() const;

  /// f(other) for every cube within reach after number i: with i itself, each pair is met once.
  template <class F>
  void for_each_after(std::size_t i, F&& f) const;
  /// f(other) for every cube within reach of number i, i among them.
  template <class F>
  void for_each_near(std::size_t i, F&& f) const;

 private:
  /// Of one column of cubes, from `first` up.
  template <class F>
  void for_each_in(const std::array<std::int64_t, 3>& first, std::int64_t last_z, F&& f) const;
  void describe(Cube& cube) const;
  void fill(const Cube& cube);

  double sigma_, side_, width_ = 2;  // width_: side in σ
  double share_ = 0;
  std::int64_t reach_ = 1;
  Points sources_, grids_;
  std::vector<Cube> cubes_;
  std::array<double, 2> total_{}, heaviest_{};
};

template <class F>
void Cubes::for_each_in(const std::array<std::int64_t, 3>& first, std::int64_t last_z, F&& f) const {
  auto other =
      std::lower_bound(cubes_.begin(), cubes_.end(), first, [](const Cube& c, const auto& k) { return c.key < k; });
  for (; other != cubes_.end() && other->key[0] == first[0] && other->key[1] == first[1] && other->key[2] <= last_z;
       ++other)
    f(*other);
}

template <class F>
void Cubes::for_each_after(std::size_t i, F&& f) const {
  const auto& key = cubes_[i].key;
  for (std::int64_t dx = 0; dx <= reach_; ++dx)
    for (std::int64_t dy = dx == 0 ? 0 : -reach_; dy <= reach_; ++dy)
      for_each_in({key[0] + dx, key[1] + dy, key[2] + (dx == 0 && dy == 0 ? 1 : -reach_)}, key[2] + reach_, f);
}

template <class F>
void Cubes::for_each_near(std::size_t i, F&& f) const {
  const auto& key = cubes_[i].key;
  for (std::int64_t dx = -reach_; dx <= reach_; ++dx)
    for (std::int64_t dy = -reach_; dy <= reach_; ++dy)
      for_each_in({key[0] + dx, key[1] + dy, key[2] - reach_}, key[2] + reach_, f);
}

}  // namespace isopach::currents_parts
