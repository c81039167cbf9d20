// One step of ICP: the motion that makes the pairs fit best, in the closed form of (1) or the linear form of (3).
#pragma once
#include <array>
#include <span>
#include <string>
#include <vector>

#include "isopach/match/motion.hpp"
#include "isopach/match/options.hpp"
#include "isopach/match/pairs/pairs.hpp"

namespace isopach {

/// What the pairs say about each motion, in units of the scans' own size.
struct PairInformation {
  Point3 centre{0, 0, 0};            ///< weighted mean of the points; rotations are about it
  double radius = 1;                 ///< their RMS distance from it; turns and scale are counted in radius · angle
  double weight = 0;                 ///< sum of the weights
  double error = 0;                  ///< E: weighted mean of the squared residuals of the objective
  std::array<double, 49> normal{};   ///< of (3), over `weight`; turn x, y, z, shift x, y, z, scale
  std::array<double, 49> planes{};   ///< kind planes: Σ w JᵀPJ of the precisions, over `weight`
  std::array<double, 7> gradient{};  ///< of (3), or of planes, over `weight`
};
[[nodiscard]] PairInformation pair_information(std::span<const Link> links, PairKind kind);

/// Motions whose eigenvalue is below `floor` are not moved along. Frozen motions stay out.
[[nodiscard]] Twist plane_step(const PairInformation& information, const Freedom& freedom, double floor);

/// The Gauss–Newton step of kind planes, along the motions that (3) holds: precisions also draw each point to its
/// partner, by plane_flatness, which holds what the surfaces leave free, where only the sampling of the scans decides.
[[nodiscard]] Twist planes_step(const PairInformation& information, const Freedom& freedom, double floor);

/// The rigid motion (and scale, if free) that minimises Σ w |motion(p) − q|², closed form [Horn1987], [Umeyama1991],
/// from where MOVING is now. For links on a line or in one point the turn is not determined: the smallest is taken.
[[nodiscard]] Motion point_step(std::span<const Link> links, const PairInformation& information, bool scale);

/// The same for fewer freedoms: one Gauss–Newton step of (1).
[[nodiscard]] Twist point_twist(std::span<const Link> links, const PairInformation& information,
                                const Freedom& freedom);

/// Turn and shift, 6×6 row-major, axes of the frame: σ² times the inverse of the normal matrix, with σ² from the
/// residuals as if the pairs were independent. Along motions that are not determined the deviation is that of the
/// radius itself, no more. `directions` receives the weak ones, in words.
[[nodiscard]] std::array<double, 36> pair_covariance(const PairInformation& information, double sigma2, double count,
                                                     double floor, const std::array<std::string, 3>& axes,
                                                     std::vector<std::string>& directions);

}  // namespace isopach
