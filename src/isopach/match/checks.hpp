// The small print of match.cpp: what is refused, and how the search's result is put into input coordinates.
#pragma once
#include <array>
#include <string>

#include "isopach/match/matching.hpp"
#include "isopach/match/surface/search.hpp"

namespace isopach {

/// UsageError for options that are no numbers in their range or leave nothing to search.
void check_options(const MatchOptions& options);

/// Whether a scan may turn and shift as it likes; scale does not count.
[[nodiscard]] bool all_rigid_motions(const Freedom& f);

/// Names of the frame's axes: x, y, z of the input where it only permutes them, else u, v, w.
[[nodiscard]] std::array<std::string, 3> axis_names(const Frame& frame);

/// Pose, covariance, centre, words and stable points of the search, in input coordinates, into `m`.
void take(const SearchResult& found, const Frame& frame, const Array<Index>& node_of_point, Matching& m);

/// Covariance and undetermined motions in input axes: NaN where an undetermined motion has a part.
void take_covariance(const SearchResult& found, const Frame& frame, Matching& m);

/// Inputs, unit and warnings of a comparison.
void describe(const Comparison& c, Matching& m);

/// Warnings about the search itself.
void warn(Matching& m);

}  // namespace isopach
