// Rigid fit of an object to a scan of it, points to quadrics: the last step of a pose that fit_part() has found, and
// its covariance.
//
// A point of a scan that was put on the plane of its neighbours lies off a curved surface by curvature × radius² / 4,
// where radius is that of the neighbourhood. In two scans of like density this is alike and falls out; where one of
// them is sparse it is a bias, and the denser the other one, the larger. Here nothing is put on planes: points of the
// sparser of the two clouds, as they are, are compared with the quadric through their neighbours in the denser one
// (moving least squares of second order [Levin1998]).
#pragma once
#include <array>
#include <optional>
#include <string>

#include "isopach/base/context.hpp"
#include "isopach/match/pairs/least_squares.hpp"
#include "isopach/match/pairs/oriented.hpp"

namespace isopach {

struct QuadricFit {
  Motion motion;                ///< takes the object to the scan, frame coordinates
  PairInformation information;  ///< of the pairs at `motion`
  std::size_t pairs = 0;        ///< that take part
  double scale = 0;             ///< standard deviation of a distance, from the median of all pairs
  double rms = 0;               ///< of the weighted distances
  bool object_asks = true;  ///< the pairs were sought from the object's points (it is the sparser); false: the scan's
  /// Of the motion: turn (rad), then shift, about information.centre, axes of the frame, row-major. The noise of both
  /// clouds is carried through the fit: that of a point of the denser cloud through every pair whose quadric it helps
  /// to hold, so that pairs which share points are not counted as independent. `correlation` is part of it.
  std::array<double, 36> covariance{};
  /// By how much the distances, summed over cells of a few neighbourhoods each, vary more than independent noise of the
  /// points would: noise with a memory, or a shape that differs. 1 where they do not.
  double correlation = 1;
  /// By how many standard deviations distances rise (RMS) where the object slips by 1 % of its extent along the motion
  /// that its shape holds least [Gelfand2003].
  double slip = 0;
  std::string least_held;  ///< that motion, in words
};

/// `object` and `scan` are oriented and flattened (part_fit.hpp), in one frame; `start` is near, its distances have
/// about the standard deviation `start_scale`. Iteratively reweighted least squares with Tukey's biweight; pairs at
/// boundaries, of normals more than 45° apart, and on neighbourhoods that no quadric fits (they cross an edge) are left
/// out. Nothing where fewer than 24 pairs are left, or the steps do not end. The same bits for any number of threads
/// and any order of the points. At most 60 000 queries, every k-th. Cost: one small least squares a pair. Test:
/// tests/apps/quadric_fit_test.cpp (exact on quadrics; chi² of many draws); tests/apps/combine_test.cpp (error against
/// density).
[[nodiscard]] std::optional<QuadricFit> fit_quadrics(const OrientedCloud& object, const OrientedCloud& scan,
                                                     const Motion& start, double start_scale, const Context& context);

}  // namespace isopach
