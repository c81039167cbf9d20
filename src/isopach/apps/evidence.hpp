// Evidence: what the frames say of each point of the model: does it move with the one part, with the other, or between?
//
// A point p of the model is tried at (1 − b) still(p) + b moving(p) for a few values of the blend b. How far each place
// is from the frame's surface is added up from frame to frame, squared and bounded, so that memory does not grow. The
// blend is then the field that is as near as possible to each point's own best value, by how well that is known, and
// smooth over the surface where it is not (a screened Poisson equation on the graph of neighbours): where both motions
// are alike, or slide along the surface, a point has no say of its own.
#pragma once
#include <array>
#include <span>

#include "isopach/apps/part_fit.hpp"
#include "isopach/base/context.hpp"

namespace isopach {

class Evidence {
 public:
  static constexpr std::size_t levels = 5;      ///< values of the blend that are tried: 0, 1/4, …, 1
  static constexpr std::size_t neighbours = 8;  ///< edges of the graph: from each point to its nearest ones

  /// `model` is kept by reference and has a tree.
  explicit Evidence(const OrientedCloud& model);

  /// `sigma`: standard deviation of distances that are noise; `reach` as above. Cost: `levels` nearest points a point.
  void add(const OrientedCloud& frame, const Motion& still, const Motion& moving, double sigma, double reach);

  [[nodiscard]] std::size_t frames() const { return frames_; }
  void clear();
  /// The neighbours of point i; no_index where there are fewer.
  [[nodiscard]] const std::array<Index, neighbours>& near(std::size_t i) const { return near_[i]; }

  /// The blend of each point, in [0, 1]. Cost: a sparse factorisation. Oracle: tests/apps/evidence_test.cpp.
  [[nodiscard]] Array<double> blend() const;

 private:
  const OrientedCloud& model_;
  Array<std::array<Index, neighbours>> near_;
  Array<std::array<double, levels>> cost_;
  std::size_t frames_ = 0;
};

/// The field w that minimises Σ certainty (w − own)² + stiffness Σ over edges (w_i − w_j)². Points of a connected piece
/// without any certainty get `lonely`.
[[nodiscard]] Array<double> smooth_field(std::span<const std::array<Index, Evidence::neighbours>> near,
                                         std::span<const double> own, std::span<const double> certainty,
                                         double stiffness, double lonely);

}  // namespace isopach
