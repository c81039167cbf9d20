// What `isopach sequence` writes and prints. Computes nothing that is not in SequenceResult already.
#pragma once
#include <string>
#include <vector>

#include "isopach/apps/sequence.hpp"

namespace isopach {

/// Schema isopach.sequence/1: no NaN, shortest round-trip numbers; null for what is not known.
[[nodiscard]] std::string sequence_json(const SequenceResult& r, const std::vector<std::string>& outputs);

/// Aligned lines with units, warnings last. Ends with a newline; no colours.
[[nodiscard]] std::string sequence_text(const SequenceResult& r);

/// motion.csv: a line a frame that was used, the matrix of the motion row by row at its end.
[[nodiscard]] std::string sequence_csv(const SequenceResult& r);

/// report.html: opening and excursion against time, paths, the parts, and an animation; opens from disk without a
/// network and without a script. `json` is the text of sequence_json.
[[nodiscard]] std::string sequence_html(const SequenceResult& r, const std::string& json, const Context& context);

/// parts.ply: the points of the reference frame with `part` (0 stays, 1 moves, 2 between) and `blend` (0 to 1).
void write_parts(const std::string& path, const SequenceResult& r, const Context& context);

}  // namespace isopach
