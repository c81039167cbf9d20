// What match and compare --match ask alike.
#pragma once
#include "cli/command.hpp"
#include "isopach/match/options.hpp"

namespace isopach::cli {

/// --overlap, --freedom, --max-iterations, --tolerance under the heading "Matching".
void add_match_options(Command& command, MatchOptions& options);

/// UsageError naming the first of them that was given, where there is no matching: `without` is the option that asks
/// for one.
void refuse_match_options(const MatchOptions& options, const std::string& without);

}  // namespace isopach::cli
