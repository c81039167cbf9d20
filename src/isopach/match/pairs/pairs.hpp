// Pairs of ICP: nearest points, which of them are believed, and how much.
#pragma once
#include "isopach/match/motion.hpp"
#include "isopach/match/options.hpp"
#include "isopach/match/pairs/oriented.hpp"

namespace isopach {

/// A pair that takes part: a point of MOVING at its present place, its partner in FIXED, the unit normal of the one
/// that was found, and the weight. Residual of (1): the length of moving − fixed; of (3): its part along the normal.
struct Link {
  Point3 moving, fixed, normal;
  double weight = 1;
  Index query = no_index;    ///< which point asked
  Index partner = no_index;  ///< … and which one it found
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
  void look(std::size_t query, const Point3& place);
  Array<Candidate> candidates(const Motion& motion, std::size_t stride, const IcpOptions& options);

  const OrientedCloud& queries_;
  const OrientedCloud& target_;
  bool inverse_;
  Array<Memory> memory_;
};

/// Length of the pair, or its part along the normal (plane).
[[nodiscard]] double residual(const Link& link, bool plane);

/// Where Tukey's biweight of these residuals ends: 4.685 standard deviations by their median (MAD).
[[nodiscard]] double residual_width(const Array<Link>& links, bool plane);

/// Multiplies the weights by what the residuals of the objective (plane: (3), else (1)) say; drops links of weight 0.
void set_weights(Array<Link>& links, IcpOptions::Weights weights, bool plane);

}  // namespace isopach
