// Pairs of ICP: nearest points, which of them are believed, and how much.
#pragma once
#include "isopach/match/motion.hpp"
#include "isopach/match/options.hpp"
#include "isopach/match/pairs/oriented.hpp"

namespace isopach {

/// What a pair is asked for, by the objective. point: the length of moving − fixed, (1); plane: its part along the
/// normal, (3); planes: its length in the metric of both points' planes together [Segal2009], see precision().
enum class PairKind { point, plane, planes };
[[nodiscard]] constexpr PairKind pair_kind(Objective objective) {
  return objective == Objective::icp_point   ? PairKind::point
         : objective == Objective::icp_plane ? PairKind::plane
                                             : PairKind::planes;
}

/// A pair that takes part: a point of MOVING at its present place, its partner in FIXED, the unit normal of the one
/// that was found, and the weight.
struct Link {
  Point3 moving, fixed, normal;
  double weight = 1;
  Index query = no_index;    ///< which point asked
  Index partner = no_index;  ///< … and which one it found
  Point3 asking{0, 0, 0};    ///< unit normal of the one that asked, where MOVING is now
};

/// Looks from the points of one cloud into the other. A nearest point is looked for anew only if the point has moved so
/// far since that another one could be nearer; the answers are those of a full search.
class PairSearch {
 public:
  /// `inverse`: the queries are points of FIXED and the target is MOVING.
  PairSearch(const OrientedCloud& queries, const OrientedCloud& target, bool inverse);

  /// Pairs of every `stride`-th query at this place of MOVING, after all rejections, with the areas of the queries as
  /// weights (uniform: 1). `overlap`: share of the queries to keep, 0: chosen by the least FRMSD [Phillips2007]. Test:
  /// tests/match/icp_test.cpp.
  [[nodiscard]] Array<Link> find(const Motion& motion, std::size_t stride, const IcpOptions& options, double overlap);

 private:
  struct Memory {
    Point3 place{0, 0, 0};  ///< of the query when it was last looked for
    double second = -1;     ///< distance of the second nearest then
    Index partner = no_index;
  };
  struct Candidate {
    Index query, partner;
    double length2;
  };
  Point3 place_of(std::size_t query, const Motion& motion) const;
  void look(std::size_t query, const Point3& place, Index begin);
  Array<Candidate> candidates(const Motion& motion, std::size_t stride, const IcpOptions& options);

  const OrientedCloud& queries_;
  const OrientedCloud& target_;
  std::unique_ptr<BoxTree> made_;  ///< where the target has none
  const BoxTree* boxes_;
  bool inverse_;
  Array<Memory> memory_;
};

/// Upper triangle of a symmetric matrix.
struct Symmetric3 {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
};
[[nodiscard]] inline Point3 operator*(const Symmetric3& m, const Point3& v) {
  return {m.xx * v.x + m.xy * v.y + m.xz * v.z, m.xy * v.x + m.yy * v.y + m.yz * v.z,
          m.xz * v.x + m.yz * v.y + m.zz * v.z};
}

/// Variance across a plane over that along it, of a point of a scan: the value of [Segal2009].
inline constexpr double plane_flatness = 1e-3;

/// 2ε (C + D)⁻¹ with C = I − (1 − ε) n nᵀ of either normal, ε = plane_flatness: where the normals agree, n nᵀ + ε (I −
/// n nᵀ), so that residuals are lengths as in (3); the less they agree, the less it holds. A normal of length 0 (a
/// point on a line) is of any direction: C = I. The same bits for exchanged and for negated normals.
[[nodiscard]] Symmetric3 precision(const Link& link);

/// What draws the pair together: half the derivative of its squared residual by the place of the moving point.
[[nodiscard]] Point3 pull(const Link& link, PairKind kind);

[[nodiscard]] double residual(const Link& link, PairKind kind);

/// Where Tukey's biweight of these residuals ends: 4.685 standard deviations by their median (MAD).
[[nodiscard]] double residual_width(const Array<Link>& links, PairKind kind);

/// Multiplies the weights by what the residuals say; drops links of weight 0.
void set_weights(Array<Link>& links, IcpOptions::Weights weights, PairKind kind);

}  // namespace isopach
