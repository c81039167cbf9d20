// Residuals: how far the nodes of each scan lie from the surface of the other at a motion, and the normal equations of
// the weighted problem there.
//
// Residual of a node: its distance along the normal of the facet above or below it, n = (z − f̂(x, y)) / √(1 + |∇f̂|²):
// the vertical distance of the measure times the cosine of the slope, which does not depend on who is tilted. The nodes
// of the moving scan are located in T of the fixed scan, those of the fixed scan, moved back, in T of the moving one:
// neither triangulation ever changes. A node is located from the triangle that it was in before (a visibility walk with
// exact predicates, one or two triangles after a small step).
#pragma once
#include <array>
#include <vector>

#include "isopach/match/equations.hpp"
#include "isopach/match/motion.hpp"
#include "isopach/match/surface/surface.hpp"

namespace isopach {

/// The loss of one residual. huber: quadratic, from 1.345 scales on linear. tukey: bounded, from 4.685 scales on
/// constant [Beaton1974], so that what is really different does not pull. Both have 95 % of the efficiency of
/// least squares on normal residuals [Huber1981], [Holland1977].
struct Loss {
  enum class Kind { huber, tukey } kind = Kind::huber;
  double scale = 1;  ///< standard deviation of the residuals that are noise
};

/// What a motion makes of a node, whatever it weighs: kept for new weights at the same motion.
struct ResidualRow {
  double vertical;             ///< distance
  float arm_x, arm_y, arm_z;   ///< from the centre, over Residuals::length
  float smooth_gx, smooth_gy;  ///< slope of the facet
};

/// What is asked of an evaluation.
struct Evaluation {
  Loss loss;
  bool again = false;     ///< at the motion of the last one
  bool equations = true;  ///< with h and b
};

/// Nodes of one scan against the surface of the other.
struct ResidualSide {
  const MatchSurface* nodes = nullptr;   ///< whose nodes
  const MatchSurface* target = nullptr;  ///< in whose triangulation
  bool moving_nodes = true;
  Array<Index> hint;       ///< by node: triangle or ghost where it was last
  Array<double> n;         ///< by node: residual, NaN where the target has no surface
  Array<ResidualRow> row;  ///< by node, where n is a number
  Array<double> trust;     ///< by patch of `patch` nodes in a row: weight from 0 to 1
  Array<double> bend;      ///< by patch: its mean times the derivative of its trust over that mean
  Array<float> balance;    ///< by node: what its weight is multiplied with; empty: 1
  Array<float> factor;     ///< by facet of target: what a vertical distance is multiplied with; empty: its cosine

  [[nodiscard]] double weight(std::size_t i) const {
    return balance.empty() ? nodes->weight[i] : nodes->weight[i] * static_cast<double>(balance[i]);
  }
  [[nodiscard]] const float* factors() const { return factor.empty() ? target->cosine.data() : factor.data(); }
};

struct ResidualSums {
  Symmetric7 h;               ///< Σ w JᵀJ, in the scaled parameters
  Vector7 b{};                ///< −Σ w Jᵀn: the step solves h · step = b
  double area = 0;            ///< Σ of the areas of all nodes over a surface
  double trusted = 0;         ///< … times trust
  double loss = 0;            ///< Σ area · trust · loss(n)
  double fitted = 0;          ///< Σ area · trust · (loss weight)
  double volume = 0;          ///< Σ area · trust · (loss weight > 0) · |vertical distance|
  double within = 0;          ///< its Σ area · trust
  double squares = 0;         ///< Σ area · trust · (loss weight) · (vertical distance)²
  double curvature = 0;       ///< Σ area · trust · (second derivative of the loss)
  double bend = 0;            ///< Σ area · bend · (loss weight): what trust adds to it, if it follows the motion
  std::uint64_t nodes = 0;    ///< with a residual
  std::uint64_t visited = 0;  ///< triangles
};

class Residuals {
 public:
  static constexpr std::size_t largest_patch = 32;

  Residuals(const MatchSurface& moving, const MatchSurface& fixed, const Point3& centre, double length);

  /// From now on only every `stride`-th patch takes part: a sample of the nodes, against all facets.
  void sample(std::size_t stride);

  /// All residuals at `motion`, their sums with the weights of `loss` and of the patches' trust.
  /// Cost O(nodes); the same bits for any number of threads.
  /// `equations` false: without h and b, which stay 0.
  [[nodiscard]] ResidualSums evaluate(const Motion& motion, const Loss& loss, const Context& context,
                                      bool equations = true) {
    return evaluate(motion, {loss, false, equations}, context);
  }
  /// The same at `motion` of the last evaluation, with other weights: no node is looked for again.
  /// Test: Residuals.NewWeightsAtTheSameMotion.
  [[nodiscard]] ResidualSums reweighed(const Motion& motion, const Loss& loss, const Context& context) {
    return evaluate(motion, {loss, true, true}, context);
  }

  /// Standard deviation of the residuals of the last evaluation, from their median absolute value.
  [[nodiscard]] double spread() const;
  /// Noise depends on the slope: along the normal that of a raster's heights is less where it is steep, that of a
  /// scanner may be more. From now on residuals are divided by the spread of their like (classes of the cosine) over
  /// that of all, as the last evaluation has them: each counts by what it knows.
  void even_out();
  /// From now on the noise of all nodes counts alike: match/balance.hpp. `motion` of the last evaluation.
  void balance(const Motion& motion);
  /// Trust of all patches: 1.
  void trust_all();
  /// Bounded by the spread of the patches' means: what is different over a patch is a change and not noise, be it less
  /// than the noise of one node.
  void trust_by_mean();
  /// Trust 1 to the patches with the least means, up to `share` of the area; else 0.
  void trust_share(double share);

  /// At the motion of the last evaluation, by smoothed slopes; `noise`: standard deviations of the heights of the
  /// moving and of the fixed scan.
  [[nodiscard]] Information information(const Motion& motion, const Loss& loss, const std::array<double, 2>& noise,
                                        const Context& context) const;
  /// At the motion of the last evaluation: the pulls by eight nodes in a row of the moving scan, or more where it is
  /// the denser one or has very many, over these nodes and those of the fixed scan that lie over its facets: the two
  /// directions share their noise. For clustered_scores. Test: MatchQuality.CovarianceTellsTheErrors.
  [[nodiscard]] std::vector<ScoreCell> score_cells(const Motion& motion, const Loss& loss,
                                                   const Context& context) const;

  /// A twist of the scaled parameters: all lengths.
  [[nodiscard]] Twist twist(const Vector7& step) const;
  [[nodiscard]] const Point3& centre() const { return centre_; }
  [[nodiscard]] double length() const { return length_; }
  /// Whether node i of the moving scan takes part.
  [[nodiscard]] bool fitted(std::size_t i, const Loss& loss) const;

 private:
  struct PatchMean {
    double mean = 0, area = 0;
    std::size_t side = 0, patch = 0;
  };
  [[nodiscard]] ResidualSums evaluate(const Motion& motion, const Evaluation& what, const Context& context);
  [[nodiscard]] std::vector<PatchMean> patch_means() const;
  /// Sizes of the residuals of trusted patches, of at most so many nodes of each side: (node's facet, |n|).
  template <class Visit>
  void sizes_of(const Visit& visit) const;

  std::array<ResidualSide, 2> sides_;
  Point3 centre_;
  double length_;
  std::size_t patch_, stride_ = 1;
};

}  // namespace isopach
