// PartFinder: the first reading of a sequence: which points of the reference frame move together.
//
// Frame by frame. At first the whole model is fitted, and each of a dozen overlapping regions of it on its own: where
// parts move apart little by little, a robust fit of the whole settles between them, and its own scale grows with the
// gap, so that nothing ever lies off it. The motion that takes most of the model to within the noise of the regions'
// fits is that of the larger part. A connected patch that does not lie on the frame there is the seed of the second
// part, which from then on is followed too.
// Evidence of both motions is gathered from every frame, and the parts are drawn anew from it after 1, 2, 4, 8, …
// frames.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "isopach/apps/evidence.hpp"
#include "isopach/apps/part_fit.hpp"

namespace isopach {

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
  /// The larger part of the whole model, while the second one is not known. `others`: motions of regions.
  [[nodiscard]] std::optional<PartFit> fit_larger(const OrientedCloud& frame, std::vector<Motion>& others,
                                                  const Context& context);
  void look_for_seed(const OrientedCloud& frame, const PartFit& still, const FrameScale& scale,
                     const std::vector<Motion>& others, const Context& context);
  void make_regions();
  void draw_parts();
  void forget_second();
  void set_parts(const Array<unsigned char>& second, const Array<unsigned char>& first);
  [[nodiscard]] Array<unsigned char> largest_patch(const Array<unsigned char>& flag) const;

  const OrientedCloud& model_;
  std::size_t least_;
  Evidence evidence_;
  std::vector<OrientedCloud> regions_;
  OrientedCloud first_, second_;
  Motion still_;
  std::optional<Motion> relative_;  ///< of the second part, seen from the first
  std::optional<Motion> relative_before_;
  std::size_t next_drawing_ = 1;
  double travelled_[2] = {0, 0};
  std::size_t frames_ = 0;
};

}  // namespace isopach
