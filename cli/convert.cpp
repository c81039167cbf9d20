// isopach convert IN OUT
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <optional>

#include "cli/command.hpp"
#include "cli/parse.hpp"
#include "cli/session.hpp"
#include "cli/verbs.hpp"
#include "isopach/io/las.hpp"
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

bool is_colour(const Attribute& attribute) {
  return attribute.name == "red" || attribute.name == "green" || attribute.name == "blue";
}

std::string extension_of(const std::string& path) {
  std::string end = std::filesystem::path(path).extension().string();
  for (char& c : end) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return end;
}

std::string words(const LasStorage& s) {
  return fmt::format("LAS 1.{}, point format {}, steps of {}, {} and {}", s.minor, s.format, s.step[0], s.step[1],
                     s.step[2]);
}

/// How a LAS file stores what was read, and what of that is not as it was; `before`: of IN, if that is LAS too.
std::string storage_summary(const std::string& path, const std::optional<LasStorage>& before) {
  const LasStorage now = las_storage(path);
  std::string text = "stored as " + words(now);
  if (before && words(*before) != words(now)) text += "; read from " + words(*before);
  std::vector<std::string> extra;
  for (const LasStorage::Extra& e : now.extra) {
    std::string was;
    if (before)
      for (const LasStorage::Extra& old : before->extra)
        if (old.name == e.name && old.type != e.type) was = " (was " + old.type + ")";
    extra.push_back(fmt::format("{} as {}{}", e.name, e.type, was));
  }
  if (!extra.empty()) text += fmt::format("; extra bytes: {}", fmt::join(extra, ", "));
  return text;
}

/// What was written, and what the format has no place for.
std::string summary(const std::string& path, const Cloud& cloud) {
  const std::string end = extension_of(path);
  const auto one_of = [&](std::initializer_list<const char*> ends) {
    return std::find(ends.begin(), ends.end(), end) != ends.end();
  };
  const bool bare = one_of({".stl", ".npy", ".tif", ".tiff"});
  std::vector<std::string> kept, lost;
  const auto share = [](std::vector<std::string>& list, std::size_t n, const char* what) {
    if (n > 0) list.push_back(fmt::format("{} {}", n, what));
  };
  const std::size_t all = cloud.attributes.size(), faces = cloud.faces.size();
  const auto colours =
      static_cast<std::size_t>(std::count_if(cloud.attributes.begin(), cloud.attributes.end(), is_colour));
  const std::size_t written = bare ? 0 : end != ".obj" ? all : colours == 3 ? colours : 0;
  const bool holds_faces = one_of({".ply", ".obj", ".stl"});
  share(kept, written, "attributes");
  share(kept, holds_faces ? faces : 0, "faces");
  share(lost, all - written, "attributes");
  share(lost, holds_faces ? 0 : faces, "faces");
  std::string text = fmt::format("{}: {} points", path, cloud.points.size());
  for (const std::string& part : kept) text += ", " + part;
  if (!lost.empty()) text += fmt::format("; {} cannot hold {}", end, fmt::join(lost, " and "));
  return text;
}

}  // namespace

int run_convert(const Arguments& arguments) {
  std::string in, out, pose_path;
  RunOptions run_options;
  Command command("convert", description, footer);
  command.positional("IN", in, "File to read: XYZ, CSV, PTS, PTX, PLY, LAS, LAZ, OBJ, STL, PCD, GeoTIFF, ASC");
  command.positional("OUT", out,
                     "File to write: .ply .xyz .txt .csv .las .laz .obj .stl (needs faces) .pcd .npy "
                     ".tif (of a raster)");
  command.heading("Scan");
  command.option("--pose", "FILE", pose_path, "Four lines of four numbers: the row-major matrix applied to the points");
  add_run_options(command, run_options);
  if (!command.parse(arguments)) return 0;

  Run run(run_options);
  const Pose pose = pose_path.empty() ? Pose{} : read_pose(pose_path);
  ReadOptions options;
  options.all_attributes = true;
  options.faces = true;
  Cloud cloud = cloud_named(in, options, run.context());
  std::optional<LasStorage> before;  // now: OUT may be the same file
  if (is_las_file(cloud)) before = las_storage(cloud.path);
  for (const std::string& note : cloud.notes) run.warn(fmt::format("{}: {}", name_of_scan(in), note));
  if (!pose.is_identity()) {
    for (Point3& p : cloud.points) p = pose.apply(p);
    turn_normals(cloud, pose);
    cloud.grid.reset();
  }
  write_cloud(out, cloud, run.context());
  run.show(summary(out, cloud));
  if (const std::string end = extension_of(out); end == ".las" || end == ".laz")
    if (std::error_code none; std::filesystem::is_regular_file(out, none) && !run_options.quiet)
      run.show(storage_summary(out, before));
  return 0;
}

}  // namespace isopach::cli
