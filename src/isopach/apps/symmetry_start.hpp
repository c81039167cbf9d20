// Where the search for the symmetry plane begins, of a scan in which no face was found or whose direction is given.
#pragma once
#include <vector>

#include "isopach/apps/asymmetry.hpp"
#include "isopach/apps/mirror.hpp"
#include "isopach/apps/symmetry_planes.hpp"

namespace isopach {

/// Cosine: a plane whose normal is farther (52 degrees) from the direction across is another one. Those that are left
/// stand steeper than Upright::after asks for.
inline constexpr double least_across = 0.61;

/// Options of a comparison of two clouds that are in face coordinates already.
[[nodiscard]] CompareOptions upright_options(const CompareOptions& given);

/// Of a matching of a face, upright, to its mirror image. `plane_only`: with the motions that move the plane alone.
[[nodiscard]] MatchOptions mirror_match_options(const AsymmetryOptions& o, bool plane_only);

/// The stages within many matchings say nothing to the user.
[[nodiscard]] Context without_progress(const Context& context);

/// The plane to begin with, in coordinates of `frame`, of the starts that are tried: turns and shifts of the plane
/// through the middle of the scan, and `planes` of symmetry found in space (input coordinates). The former lie alike in
/// every frame; of a scan that ends near its plane on one side all of them may lead astray. There a plane found in
/// space is far more symmetric, and taken. `thin`: some thousand points of the scan in the frame; `across`: from side
/// to side. Cost: some 35 matchings of these points. Errors: OverlapError where no part of the scan lies over its
/// mirror image; UsageError naming --across where it is the direction of projection. Test:
/// tests/apps/asymmetry_test.cpp, test_a_plane_far_from_the_middle_of_the_scan of tests/cli/asymmetry_test.py.
[[nodiscard]] Upright symmetry_start(const Array<Point3>& thin, const Frame& frame, const Point3& across,
                                     const std::vector<MirrorPlane>& planes, const AsymmetryOptions& o,
                                     const Context& context);

}  // namespace isopach
