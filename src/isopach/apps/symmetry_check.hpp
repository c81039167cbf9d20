// What vouches for a symmetry plane where no face does: whether both sides agree about it, in place and in shape, and
// how far it moves when parts of the scan are left out.
#pragma once
#include <optional>

#include "isopach/apps/mirror.hpp"
#include "isopach/match/verdict/pose_evidence.hpp"

namespace isopach {

struct AsymmetryOptions;

/// A plane is doubted where less than `least_symmetric` of what both sides show agrees, or the shapes of the sides by
/// less than `alike_needed` less that share: shape is worth less where the points are few. Of five real faces, whole
/// and cropped in up to 15 ways each, right planes have 0.60 and a sum of 1.37 or more; wrong ones (23 to 58 degrees
/// off) at most 0.44 and 0.89. Lower than the limits of a pose of two scans of one surface: the sides of a face differ.
inline constexpr double least_symmetric = 0.5, alike_needed = 1.1;

/// What the two sides of a scan, upright before its plane, say about the plane. Cost: that of two judged_scan() and
/// evidence_at(), some 0.1 s. Test: SymmetryCheck.* in tests/apps/symmetry_check_test.cpp.
[[nodiscard]] PoseEvidence symmetry_evidence(const CloudView& upright, const Context& context);

/// Of scans without detail, or of too few points for a judgement, the shape says nothing.
[[nodiscard]] bool is_symmetric(const PoseEvidence& e);

/// "of what both sides show, 40 % agrees within noise (needs 50 %), …"
[[nodiscard]] std::string sides_sentence(const PoseEvidence& e);

/// The plane that a search over all motions of the mirror image in space finds, in the coordinates that `place` is in;
/// nothing where that is doubted as well, or its normal lies more than 52 degrees away from `towards`. Cost: that of a
/// coarse search. Test: test_a_crop_just_beyond_the_plane of tests/cli/asymmetry_test.py.
[[nodiscard]] std::optional<Upright> other_plane(const Array<Point3>& points, const Upright& place,
                                                 const Point3& towards, const AsymmetryOptions& o,
                                                 const Context& context);

/// Standard deviations of the plane; degrees, length.
struct PlaneSigma {
  double angle = 0, offset = 0;
};

/// Jackknife of the plane over six parts of what lies on both sides: by height into thirds, by distance from the plane
/// into halves. Unlike residuals that are taken for independent it knows that two sides differ coherently over large
/// parts: [Efron1981]. On some 8000 means of neighbouring points. 0 where fewer than four parts can be left out. Cost:
/// six matchings. Test: SymmetryCheck.SigmaGrowsWhereTheSidesDiffer.
[[nodiscard]] PlaneSigma plane_sigma(const Array<Point3>& points, const Upright& place, const AsymmetryOptions& o,
                                     const Context& context);

}  // namespace isopach
