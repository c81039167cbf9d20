// What match and compare --match ask alike.
#pragma once
#include "cli/command.hpp"
#include "isopach/match/options.hpp"

namespace isopach::cli {

/// auto (0) or a share above 0 and up to 1.
[[nodiscard]] double parse_overlap(const std::string& text);

/// --accept-doubt alone.
void add_accept_doubt(Command& command, bool& accept_doubt);

/// --overlap, --freedom, --max-iterations, --tolerance, --accept-doubt under the heading "Matching".
void add_match_options(Command& command, MatchOptions& options);

/// UsageError naming the first of them that was given, where there is no matching: `without` is the option that asks
/// for one.
void refuse_match_options(const MatchOptions& options, const std::string& without);

}  // namespace isopach::cli
