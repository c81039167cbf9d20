// The steps of the verb `tile` that have files of their own: words in, exit code out, as every verb.
#pragma once
#include "cli/verbs.hpp"

namespace isopach::cli {

inline constexpr const char* step_codes =
    "Exit codes: 0 done, 2 wrong usage, 3 input cannot be read or tiles are missing, 4 no overlap, 6 --fail-above\n"
    "exceeded, 130 interrupted.";

/// What of a job is done, what failed and why.
int tile_status(const Arguments& arguments);

/// A script that runs the tiles by an engine that people have.
int tile_script(const Arguments& arguments);

}  // namespace isopach::cli
