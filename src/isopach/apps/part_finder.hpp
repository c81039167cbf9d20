// PartFinder: the first reading of a sequence: which points of the reference frame move together.
//
// Frame by frame. At first the whole model is fitted (robustly: the larger part wins), until a connected patch of it does
// not lie on the frame any more; that patch is the seed of the second part, which from then on is followed too. Evidence
// of both motions is gathered from every frame, and the parts are drawn anew from it after 1, 2, 4, 8, … frames.
#pragma once
#include <optional>
#include <string>

#include "isopach/apps/evidence.hpp"
#include "isopach/match/icp_search.hpp"

namespace isopach {

/// Fit of one part of the model to one frame.
struct PartFit {
  Motion motion;
  double rms = 0;      ///< of the distances to the frame's planes that take part
  double support = 0;  ///< share of the part's points that lie on the frame (within its noise)
  PairInformation information;
  double scale = 0;    ///< standard deviation of a distance, from the median of all pairs
};

/// The points of `model` with `flag` 1: what a part is fitted by.
[[nodiscard]] OrientedCloud part_of(const OrientedCloud& model, std::span<const unsigned char> flag);

/// Least squares of distances to planes from the best of `starts`, with bounded weights. Nothing where hardly a point has
/// a partner. Cost: some nearest points of each point of the part.
[[nodiscard]] std::optional<PartFit> fit_part(const OrientedCloud& part, const OrientedCloud& frame,
                                              std::span<const Motion> starts, const Context& context);

/// What tells noise from misfit in a frame.
struct FrameScale {
  double sigma = 0;  ///< standard deviation of the distances of points that fit
  double reach = 0;  ///< distance of a nearest point that is still on the surface
};
[[nodiscard]] FrameScale frame_scale(const OrientedCloud& model, const OrientedCloud& frame, const PartFit& fit);

class PartFinder {
 public:
  /// `model` is kept by reference, oriented. `least_share`: of its points, that the smaller part has at least.
  PartFinder(const OrientedCloud& model, double least_share);

  /// Takes a frame in. False, with the reason, where it does not show the model.
  [[nodiscard]] bool add(const OrientedCloud& frame, std::string& reason, const Context& context);

  [[nodiscard]] bool found() const { return relative_.has_value(); }

  /// By point of the model, 0: the part that was found first, 1: the other. Call when found().
  [[nodiscard]] Array<double> blend() const;

  /// How far each part went over the sequence, RMS over the frames: the one that went less stays.
  [[nodiscard]] double travel(bool second) const;

 private:
  void look_for_seed(const OrientedCloud& frame, const PartFit& still, const FrameScale& scale, const Context& context);
  void draw_parts();
  void forget_second();
  void set_parts(const Array<unsigned char>& second, const Array<unsigned char>& first);
  [[nodiscard]] Array<unsigned char> largest_patch(const Array<unsigned char>& flag) const;

  const OrientedCloud& model_;
  std::size_t least_;
  Evidence evidence_;
  OrientedCloud first_, second_;
  Motion still_;
  std::optional<Motion> relative_;  ///< of the second part, seen from the first
  std::optional<Motion> relative_before_;
  std::size_t next_drawing_ = 1;
  double travelled_[2] = {0, 0};
  std::size_t frames_ = 0;
};

}  // namespace isopach
