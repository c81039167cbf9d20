#include "cli/scans.hpp"

#include "cli/parse.hpp"
#include "isopach/apps/visible.hpp"
#include "isopach/base/error.hpp"

namespace isopach::cli {

void add_scan_options(Command& command, ProjectOptions& project, std::string& pose_path, std::string& unit,
                      const std::string& direction_help, const std::string& duplicates_help, const PoseOption& pose) {
  command.heading("Scans");
  command.parsed("--direction", "x|y|z|fit|X,Y,Z", project.direction, parse_direction, direction_help);
  add_points_options(command, project, unit, duplicates_help);
  command.option(pose.name, "FILE", pose_path, std::string("Four lines of four numbers: ") + pose.meaning);
}

void add_points_options(Command& command, ProjectOptions& project, std::string& unit,
                        const std::string& duplicates_help) {
  command.choice<DuplicatePolicy>("--duplicates", project.duplicates,
                                  {{"mean", DuplicatePolicy::mean},
                                   {"min", DuplicatePolicy::min},
                                   {"max", DuplicatePolicy::max},
                                   {"median", DuplicatePolicy::median},
                                   {"first", DuplicatePolicy::first},
                                   {"error", DuplicatePolicy::error}},
                                  duplicates_help);
  command.parsed("--class", "N[,N]", project.classes, parse_classes,
                 "Keep only points of these LAS classes, e.g. 2 for ground (default all)");
  command.parsed("--crop", "XMIN,YMIN,XMAX,YMAX", project.crop, parse_crop,
                 "Keep only points inside this box, in input coordinates (default all)");
  command.parsed("--unit", "m|mm|cm|um|km|ft|us-ft|in", unit, parse_unit,
                 "Unit of the input, where the files do not say it or say it wrongly");
}

void add_border_options(Command& command, BorderRule& border, double& max_edge) {
  command.choice<BorderRule>(
      "--border", border, {{"trim", BorderRule::trim}, {"hull", BorderRule::hull}},
      "Border of a scan; trim: without the triangles that its sampling does not support, at the rim and "
      "in holes; hull: the convex hull of its points");
  command
      .option("--max-edge", "L", max_edge,
              "Triangles of a scan with an edge longer than this, in the unit of x and y, are no part of it (default: "
              "any length)")
      .check(positive());
}

void add_border_options(Command& command, CompareOptions& options) {
  add_border_options(command, options.border, options.max_edge);
  command.choice<FoldRule>("--folds", options.folds, {{"leave-out", FoldRule::leave_out}, {"keep", FoldRule::keep}},
                           "Places where a scan has several layers along the direction, as under overhangs; leave-out: "
                           "excluded from all results, their share is reported; keep: measured as triangulated");
}

void add_visible_option(Command& command, bool& visible) {
  command.flag("--visible", visible,
               "Of files with faces: points behind a face, seen from where the direction comes from, are left out, so "
               "that what is left is a height field");
}

CloudView visible_of(CloudView cloud, const Pose& pose, const CloudView& other, const ProjectOptions& project,
                     const Context& context) {
  if (cloud.faces.empty() && other.faces.empty())
    throw UsageError("--visible: none of the files has faces that could hide a point: leave the option out");
  if (cloud.faces.empty()) {
    cloud.notes.push_back("it has no faces, so all of its points are kept (--visible)");
    return cloud;
  }
  const Frame frame = choose_frame(other.points.empty() ? cloud : other, cloud, pose, project, context);
  return visible_part(cloud, pose, frame, project, context);
}

ReadOptions read_options(const ProjectOptions& project) {
  ReadOptions options;
  if (project.classes.empty()) options.attributes.clear();
  return options;
}

}  // namespace isopach::cli
