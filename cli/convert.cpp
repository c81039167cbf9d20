// isopach convert IN OUT
#include <fmt/core.h>

#include "cli/command.hpp"
#include "cli/parse.hpp"
#include "cli/verbs.hpp"
#include "isopach/io/read.hpp"
#include "isopach/io/write.hpp"

namespace isopach::cli {
namespace {

constexpr const char* description =
    "Reads IN and writes OUT in the format of its extension; attributes and faces are kept where the format can hold "
    "them.\n";

constexpr const char* footer =
    "Examples:\n"
    "  isopach convert scan.laz scan.ply\n"
    "  isopach convert moving.ply moved.ply --pose pose.txt";

/// Normals turn with the points; a scale does not change them (they are brought back to their length).
void turn_normals(Cloud& cloud, const Pose& pose) {
  Array<double>* n[3] = {};
  for (Attribute& attribute : cloud.attributes)
    for (int axis = 0; axis < 3; ++axis)
      if (attribute.name == std::string("n") + "xyz"[axis]) n[axis] = &attribute.values;
  if (n[0] == nullptr || n[1] == nullptr || n[2] == nullptr) return;
  const Point3 shift = pose.apply({0, 0, 0});
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const Point3 old{(*n[0])[i], (*n[1])[i], (*n[2])[i]};
    const Point3 end = pose.apply(old);
    const Point3 turned{end.x - shift.x, end.y - shift.y, end.z - shift.z};
    const double length = std::hypot(turned.x, turned.y, turned.z);
    const double scale = length > 0 ? std::hypot(old.x, old.y, old.z) / length : 1;
    (*n[0])[i] = turned.x * scale;
    (*n[1])[i] = turned.y * scale;
    (*n[2])[i] = turned.z * scale;
  }
}

}  // namespace

int run_convert(const Arguments& arguments) {
  std::string in, out, pose_path;
  RunOptions run_options;
  Command command("convert", description, footer);
  command.positional("IN", in, "File to read: XYZ, CSV, PTS, PTX, PLY, LAS, LAZ, OBJ, STL, PCD, GeoTIFF, ASC");
  command.positional("OUT", out, "File to write: .ply .xyz .txt .csv .las .laz .obj .stl (needs faces) .pcd .npy");
  command.heading("Scan");
  command.option("--pose", "FILE", pose_path, "Four lines of four numbers: the row-major matrix applied to the points");
  add_run_options(command, run_options);
  if (!command.parse(arguments)) return 0;

  Run run(run_options);
  const Pose pose = pose_path.empty() ? Pose{} : read_pose(pose_path);
  ReadOptions options;
  options.all_attributes = true;
  options.faces = true;
  Cloud cloud = read_cloud(in, options, run.context());
  for (const std::string& note : cloud.notes) run.say(fmt::format("warning: {}: {}", in, note));
  if (!pose.is_identity()) {
    for (Point3& p : cloud.points) p = pose.apply(p);
    turn_normals(cloud, pose);
    cloud.grid.reset();
  }
  write_cloud(out, cloud, run.context());
  run.show(fmt::format("{}: {} points, {} attributes, {} faces", out, cloud.points.size(), cloud.attributes.size(),
                       cloud.faces.size()));
  return 0;
}

}  // namespace isopach::cli
