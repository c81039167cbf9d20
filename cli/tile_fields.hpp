// The differences at the points of a job, tile by tile.
#pragma once
#include "cli/output.hpp"
#include "cli/tile_job.hpp"

namespace isopach::cli {

/// points_a_K.laz and points_b_K.laz of every tile that was joined and has points of the scan: the points that were
/// compared, at the coordinates of the input (of B after the pose), with dz_signed as compare gives it, to the last
/// bit; NaN where there is none. One tile is in memory at a time. Errors: as write_las; InputError where tiles are
/// damaged. Oracle: compare, tests/cli/tile_points_test.py.
void write_point_fields(const Job& job, const CompareOptions& options, const JoinedNodes& nodes, OutputFolder& folder,
                        const Context& context);

}  // namespace isopach::cli
