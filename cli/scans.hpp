// What verbs of two scans ask about them alike.
#pragma once
#include <string>

#include "cli/command.hpp"
#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud_view.hpp"
#include "isopach/compare/options.hpp"
#include "isopach/io/read.hpp"

namespace isopach::cli {

/// --direction, --duplicates, --class, --crop, --pose (a path, read later) and --unit, under the heading "Scans". The
/// two texts say what the verb does with directions and with points of the same place; `pose` is another name and
/// meaning of the pose.
struct PoseOption {
  const char* name = "--pose";
  const char* meaning = "the row-major matrix that takes B to A, applied to B first (default: as is)";
};
void add_scan_options(Command& command, ProjectOptions& project, std::string& pose_path, std::string& unit,
                      const std::string& direction_help, const std::string& duplicates_help,
                      const PoseOption& pose = {});

/// Of these --duplicates, --class, --crop and --unit, under the heading at hand.
void add_points_options(Command& command, ProjectOptions& project, std::string& unit,
                        const std::string& duplicates_help);

/// --border and --max-edge; of a comparison --folds, too.
void add_border_options(Command& command, BorderRule& border, double& max_edge);
void add_border_options(Command& command, CompareOptions& options);

/// --visible.
void add_visible_option(Command& command, bool& visible);
/// What --visible leaves of a scan, seen in the frame of it (after `pose`) and `other` together. A scan without faces
/// is whole, and a note says so; UsageError where neither has any.
[[nodiscard]] CloudView visible_of(CloudView cloud, const Pose& pose, const CloudView& other,
                                   const ProjectOptions& project, const Context& context);

/// What has to be read of a scan; without classes to select no attributes: memory is not free.
[[nodiscard]] ReadOptions read_options(const ProjectOptions& project);

}  // namespace isopach::cli
