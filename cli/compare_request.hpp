// What is asked of a comparison: by compare, and by tile plan for one that is made in parts.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "cli/command.hpp"
#include "cli/match.hpp"
#include "cli/output.hpp"
#include "cli/parse.hpp"
#include "cli/registration.hpp"
#include "cli/values.hpp"
#include "isopach/compare/comparison.hpp"
#include "isopach/compare/displacement.hpp"
#include "isopach/match/match.hpp"

namespace isopach::cli {

struct CompareRequest {
  std::string path_a, path_b, pose_path;
  CompareOptions options;
  AreaPaths area;
  std::vector<std::string> fail_above;
  RegistrationError registration;
  Option model;                // --uncertainty-model
  double min_change_area = 0;  // if has_min_change_area
  Option has_min_change_area;
  bool no_layer_check = false, match = false, visible = false;
  MatchOptions matching;  ///< compare and start are those of the comparison
  Delivery delivery;
  RunOptions run;
};

/// All options that say what is compared and how, but for those of the matching, the delivery and the run.
void add_compare_options(Command& command, CompareRequest& request);

/// After parse: puts into request.options what stands beside them. Gives the limits of --fail-above. Throws what can be
/// known to fail before any work is done.
[[nodiscard]] std::vector<Tolerance> settle_options(CompareRequest& request);

/// UsageError, naming the option, for what a comparison in tiles cannot have and check_tiled does not see: what is done
/// before scans are compared, and polygons and masks that are not read yet.
void refuse_in_tiles(const CompareRequest& request);

/// Of scans that were not matched: warns of B that lies off A as a whole, if it does.
void hint_at_matching(const std::optional<Displacement>& found, Comparison& c);

}  // namespace isopach::cli
