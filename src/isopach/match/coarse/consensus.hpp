// Consensus: motions that many pairs of similar landmarks agree on.
#pragma once
#include <vector>

#include "isopach/match/coarse/landmarks.hpp"
#include "isopach/match/motion.hpp"

namespace isopach {

/// A landmark of MOVING that looks like one of FIXED.
struct Likeness {
  Point3 moving, fixed, moving_normal, fixed_normal;
  float difference;  ///< of the two images, over how different the landmark is from most of FIXED
};

/// For each landmark of MOVING the one of FIXED that looks most like it; the `most` that stand out best. `turned`: the
/// normals of MOVING point to the other side. Cost: landmarks of one times those of the other.
[[nodiscard]] std::vector<Likeness> likenesses(const Landmarks& moving, const Landmarks& fixed, bool turned,
                                               std::size_t most, const Context& context);

struct Agreement {
  Motion motion;
  std::size_t support = 0;  ///< likenesses that it brings together
};

/// Motions that bring many likenesses together, best first, no two alike. Two likenesses are compatible if a rigid
/// motion could make both: equal distances, equal angles to the normals. Seeds are the likenesses with the most
/// second-order support, the number of others that are compatible with both of a pair (SC²-PCR [Chen2022]), which false
/// ones hardly have. Nothing is drawn at random. Cost: cube of their number over 64. Test: tests/match/coarse_test.cpp.
[[nodiscard]] std::vector<Agreement> agreements(const std::vector<Likeness>& pairs, double side, std::size_t most,
                                                const Context& context);

}  // namespace isopach
