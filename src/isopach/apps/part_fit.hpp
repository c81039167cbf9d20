// Rigid fits of a part of one scan to another scan, to the noise of planes through neighbours instead of points.
#pragma once
#include <optional>
#include <span>

#include "isopach/base/context.hpp"
#include "isopach/match/pairs/icp_search.hpp"

namespace isopach {

/// Fit of one part of the model to one frame.
struct PartFit {
  Motion motion;
  double rms = 0;      ///< of the distances to the frame's planes that take part
  double support = 0;  ///< share of the part's points that lie on the frame, within the roughness of both
  PairInformation information;
  double scale = 0;  ///< standard deviation of a distance, from the median of all pairs
};

/// Why a frame is skipped, and what can be done.
[[nodiscard]] std::string not_on_frame(bool moving);

/// The points of `model` with `flag` 1: what a part is fitted by.
[[nodiscard]] OrientedCloud part_of(const OrientedCloud& model, std::span<const unsigned char> flag);

/// Least squares of distances to planes from the best of `starts`, with bounded weights. Nothing where hardly a point
/// has a partner. Cost: some nearest points of each point of the part.
[[nodiscard]] std::optional<PartFit> fit_part(const OrientedCloud& part, const OrientedCloud& frame,
                                              std::span<const Motion> starts, const Context& context);

/// Distance of a place from the surface of a frame: to the plane at the nearest point where that is near, else to the
/// point. `reach`: near.
[[nodiscard]] double surface_distance(const OrientedCloud& frame, const Point3& place, double reach);

/// Median distance of some points of the part from the nearest of the frame, squared.
[[nodiscard]] double misfit(const OrientedCloud& part, const OrientedCloud& frame, const Motion& motion);

/// Covariance of the fit's turn (rad) and shift about information.centre, 6×6 row-major, axes of the frame. Points of
/// flattened clouds err like their neighbours: so many count as one.
[[nodiscard]] std::array<double, 36> covariance_of(const PartFit& fit, double floor,
                                                   std::vector<std::string>& weak_directions);

/// Puts every point of an oriented cloud on the plane of its neighbours, so that noise of single points neither picks
/// partners nor shifts planes. Where points lie on a curved surface this shifts them alike in every scan of it.
void flatten(OrientedCloud& cloud);

/// Every k-th point along the curve, about `most` of them: spread like the points themselves. Without a tree.
[[nodiscard]] OrientedCloud thinned(const OrientedCloud& cloud, std::size_t most);

/// What tells noise from misfit in a frame.
struct FrameScale {
  double sigma = 0;  ///< standard deviation of the distances of points that fit
  double reach = 0;  ///< distance of a nearest point that is still on the surface
};
[[nodiscard]] FrameScale frame_scale(const OrientedCloud& model, const OrientedCloud& frame, const PartFit& fit);

}  // namespace isopach
