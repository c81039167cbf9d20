// Clouds, polygons and options of the verbs out of bytes. A few bytes make a whole surface, so that a short input gets
// far; every coordinate can become one that arithmetic stumbles over.
#pragma once
#include "isopach/cloud/cloud.hpp"
#include "isopach/compare/options.hpp"
#include "isopach/match/options.hpp"
#include "tests/fuzz/input.hpp"

namespace isopach::fuzz {

/// At most some 260 points: a grid, scattered places, a line, any numbers, hills; scaled, shifted, with single
/// coordinates replaced, points doubled, and now and then attributes ("classification", "sigma", "weight") and faces,
/// of which one may name a point that is not there.
[[nodiscard]] Cloud decode_cloud(Input& in);

/// Single coordinates and points of a cloud replaced, doubled or dropped, as decode_cloud does at the end.
void damage(Input& in, Cloud& cloud);

/// Identity, a small motion, or any sixteen numbers whose last row is 0 0 0 1.
[[nodiscard]] Pose decode_pose(Input& in);

/// At most three polygons with rings on a small lattice, so that sides cross, touch and coincide.
[[nodiscard]] PolygonSet decode_polygons(Input& in);

/// Direction, duplicates, classes, crop.
[[nodiscard]] ProjectOptions decode_projection(Input& in);

/// What the verbs of two scans have in common: projection, pose, border, folds, unit, CRS.
void decode_scans(Input& in, CompareOptions& options);

/// All options of a comparison.
[[nodiscard]] CompareOptions decode_comparison(Input& in);

/// All options of a matching; few iterations.
[[nodiscard]] MatchOptions decode_matching(Input& in);

}  // namespace isopach::fuzz
