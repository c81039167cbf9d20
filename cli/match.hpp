// What match and compare --match ask alike.
#pragma once
#include "cli/command.hpp"
#include "isopach/match/options.hpp"

namespace isopach::cli {

/// auto (0) or a share above 0 and up to 1.
[[nodiscard]] double parse_overlap(const std::string& text);

/// --overlap, --freedom, --max-iterations, --tolerance under the heading "Matching".
void add_match_options(Command& command, MatchOptions& options);

}  // namespace isopach::cli
