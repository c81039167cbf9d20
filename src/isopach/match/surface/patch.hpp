// One patch of nodes against the surface of the other scan: where they lie, how far, how much they count, and the sums
// of the normal equations. The hot loop of matching: pass by pass over a few dozen nodes in the order of their columns,
// so that the compiler can use vector registers.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "isopach/base/prefetch.hpp"
#include "isopach/match/surface/residuals.hpp"
#include "isopach/overlay/localise.hpp"

namespace isopach {

// Facets lie in memory nearly as the nodes that are looked up in them: nearly. So many nodes ahead they are fetched.
inline constexpr std::size_t ahead = 16;

inline constexpr double huber_bound = 1.345, tukey_bound = 4.685;

/// The weight of a residual: the derivative of its loss over n.
[[nodiscard]] inline double weight_of(const Loss& loss, double n) {
  if (loss.kind == Loss::Kind::huber) {
    const double k = huber_bound * loss.scale, a = std::fabs(n);
    return a <= k ? 1 : k / a;
  }
  const double c = tukey_bound * loss.scale, v = 1 - n * n / (c * c);
  return v > 0 ? v * v : 0;
}

/// What the user says a facet weighs.
[[nodiscard]] inline double facet_weight(const MatchSurface& s, Index triangle) {
  return s.facet_weight.empty() ? 1 : s.facet_weight[triangle];
}

/// Nodes of one side as the other surface sees them, and back; the derivatives of residuals there.
struct View {
  View(const ResidualSide& side, const Motion& motion, const Point3& middle, double length);

  [[nodiscard]] Point3 there(const Point3& p) const {
    return {m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3], m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
            m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]};
  }
  [[nodiscard]] Point3 arm(const Point3& place) const {
    return {(place.x - centre.x) * inverse_length, (place.y - centre.y) * inverse_length,
            (place.z - centre.z) * inverse_length};
  }
  /// By the scaled parameters, of the residual n of a node at `own`, `there` in the other surface's coordinates, over a
  /// facet with this normal.
  template <bool moving_nodes>
  [[nodiscard]] Vector7 derivative(const Point3& own, const Point3& there, const Point3& normal, double n) const {
    if constexpr (moving_nodes) {
      return along(arm(there), normal, 1);
    } else {  // the surface moves under the node; what grows is the surface
      const auto& r = turn;
      const Point3 turned{r[0] * normal.x + r[1] * normal.y + r[2] * normal.z,
                          r[3] * normal.x + r[4] * normal.y + r[5] * normal.z,
                          r[6] * normal.x + r[7] * normal.y + r[8] * normal.z};
      Vector7 j = along(arm(own), turned, -1);
      j[6] += n * inverse_length;
      return j;
    }
  }

  Point3 centre;
  double inverse_length, size = 1;  // size: of lengths in the fixed scan over those in the surface's own
  std::array<double, 9> turn;
  std::array<double, 12> m;

 private:
  static Vector7 along(const Point3& arm, const Point3& normal, double sign) {
    return {sign * (arm.y * normal.z - arm.z * normal.y),
            sign * (arm.z * normal.x - arm.x * normal.z),
            sign * (arm.x * normal.y - arm.y * normal.x),
            sign * normal.x,
            sign * normal.y,
            sign * normal.z,
            sign * (arm.x * normal.x + arm.y * normal.y + arm.z * normal.z)};
  }
};

/// The rows of one patch. Their products are made in single precision: a derivative that is wrong in its seventh digit
/// changes a step as little. What decides, the residual and its loss, is in double precision, but for the slope of the
/// facet: it spans one facet alone.
class PatchRows {
 public:
  /// `skipped`: nodes between one patch and the next.
  explicit PatchRows(std::size_t skipped) : skipped_(skipped) {}

  /// Residuals of the nodes begin … end − 1. Nodes of weight 0 and those beyond the surface are left out.
  template <bool moving_nodes>
  void gather(ResidualSide& side, const View& view, std::size_t begin, std::size_t end, Index& last,
              std::uint64_t& visited);
  /// The same at the motion that `gather` was last called for, with the weights and factors of now.
  void recall(const ResidualSide& side, std::size_t begin, std::size_t end);
  /// What they count; adds all sums but the equations.
  void weigh(ResidualSide& side, const Loss& loss, std::size_t patch, ResidualSums& sums);
  template <bool moving_nodes>
  void add_equations(const View& view, ResidualSums& sums);

 private:
  static constexpr std::size_t most = Residuals::largest_patch;
  static constexpr std::size_t lanes = 4;
  static_assert(most % lanes == 0);
  using Column = std::array<double, most>;
  using FloatColumn = std::array<float, most>;

  /// Where the nodes are: one after the other where they are still in their triangles; those that left them wait until
  /// memory has answered for all.
  void find(ResidualSide& side, const View& view, std::size_t begin, std::size_t end, Index& last,
            std::uint64_t& visited);
  /// Row k: node i.
  void take(const ResidualSide& side, std::size_t k, Index i, const ResidualRow& row);
  void pad();
  template <std::size_t row>
  void add_row(double*& out, ResidualSums& sums) const;

  /// Which node is so far ahead of node i of the patch that ends before `end`.
  [[nodiscard]] std::size_t ahead_of(std::size_t i, std::size_t end) const {
    return i + ahead < end ? i + ahead : i + ahead + skipped_;
  }

  std::size_t skipped_, count_ = 0, padded_ = 0;
  std::array<Index, most> node_;
  std::array<Point3, most> there_;
  std::array<bool, most> is_over_;
  std::array<std::size_t, most> moved_;
  alignas(32) Column vertical_, area_, n_, loss_, weight_, curvature_;
  alignas(32) FloatColumn arm_x_, arm_y_, arm_z_, gx_, gy_, factor_, pull_;
  alignas(32) std::array<FloatColumn, parameters + 1> column_;  // the last: residuals
};

extern template void PatchRows::gather<true>(ResidualSide&, const View&, std::size_t, std::size_t, Index&,
                                             std::uint64_t&);
extern template void PatchRows::gather<false>(ResidualSide&, const View&, std::size_t, std::size_t, Index&,
                                              std::uint64_t&);
extern template void PatchRows::add_equations<true>(const View&, ResidualSums&);
extern template void PatchRows::add_equations<false>(const View&, ResidualSums&);

}  // namespace isopach
