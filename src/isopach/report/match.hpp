// What `isopach match` writes and prints. Computes nothing that is not in Matching already.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "isopach/match/matching.hpp"

namespace isopach {

/// Schema isopach.match/1: no NaN, shortest round-trip numbers, two-space indent; null for what is not known.
[[nodiscard]] std::string match_json(const Matching& m, const std::vector<std::string>& outputs);

/// Aligned lines with units, warnings last. Ends with a newline; no colours.
[[nodiscard]] std::string match_text(const Matching& m);

/// pose.txt: the bare matrix, four lines of four numbers, row-major, shortest round-trip digits.
[[nodiscard]] std::string pose_text(const Pose& pose);

/// How the pose moves the middle of the moving scan.
[[nodiscard]] Point3 shift_of_centre(const Matching& m);

/// report.html: one file that opens from disk without a network: the pose, its precision in words, the search, and the
/// maps of what agrees, before and after (PNG files that are written already; empty: none). `json` is the text of
/// match_json: numbers are read from it.
struct MatchPictures {
  std::string agreement, before, after;
  std::optional<std::size_t> vertices = {};  ///< as of MapOptions, for before and after together
};
void write_match_html(const std::string& path, const Matching& m, const MatchPictures& pictures,
                      const std::string& json, const Context& context);

/// The points of MOVING where they are after the matching, with the attribute `stable`: 1 where they took part in the
/// fit; and `agreement` where m.agreement is known: 0 not in view, 1 agrees, 2 in front, 3 behind. Format by extension
/// (see write_cloud).
void write_moved(const std::string& path, const CloudView& moving, const Matching& m, const Context& context);

}  // namespace isopach
