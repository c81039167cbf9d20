// What a run writes: a folder whose files all appear together at the end or not at all, and the outputs of a
// comparison.
#pragma once
#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/command.hpp"
#include "isopach/cloud/cloud_view.hpp"
#include "isopach/compare/comparison.hpp"
#include "isopach/io/output_file.hpp"
#include "isopach/io/vector_format.hpp"
#include "isopach/match/matching.hpp"
#include "isopach/report/report.hpp"

namespace isopach::cli {

/// Files are written to a folder within the one they are for and renamed by commit(). Without it (a failure, Ctrl-C)
/// the destructor removes them, and every folder that was made for them. What a killed run left is finished or removed
/// by the next run into the folder, in the constructor: a commit that was decided is finished, all else goes. While an
/// OutputFolder lives it holds a lock on the folder.
///
/// A folder holds one result: commit() removes the files that an earlier run listed (`outputs` of its result.json; of
/// simulate, which writes none, of truth.json) and this one does not write. Nothing else is ever removed: no file
/// outside the folder, no folder, no link, no input of this run.
class OutputFolder {
 public:
  /// Errors: UsageError where the folder may not be written to or another run is writing into it.
  explicit OutputFolder(const std::string& folder);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Where to write the file that will be called `name`.
  [[nodiscard]] std::string path(const std::string& name);
  void write_text(const std::string& name, const std::string& text);
  /// All or nothing, and for good: when it returns, the files are on the disk. A failure puts the earlier result back;
  /// after a kill at any moment the earlier result, or the new one, or a folder without a record (result.json) that
  /// the next run makes the new one. Errors: UsageError where a folder has the name of a file, Error (exit 1) from the
  /// disk. Test: tests/cli/commit_test.py.
  void commit();

  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  /// The place of `name` after commit().
  [[nodiscard]] std::string final_path(const std::string& name) const { return (folder_ / name).string(); }

 private:
  std::filesystem::path folder_, staging_;
  std::vector<std::filesystem::path> made_;  ///< folders that were not there before, outermost first
  std::vector<std::string> names_;
  int lock_ = -1;           ///< the folder, open and locked
  bool half_done_ = false;  ///< a commit was begun and is neither done nor taken back

  void clear() noexcept;
};

/// Text to a file, whole or not at all, or to stdout if `path` is "-".
void write_json(const std::string& path, const std::string& text, Run& run);

/// Seconds since the last call (or since construction).
class Stopwatch {
 public:
  double lap();

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// What a verb writes and prints, as its options under the heading "Output" say.
struct Delivery {
  std::string output, json;   ///< folder, file; empty: none
  bool short_report = false;  ///< report.html: two pages for a client
  std::string pdf;            ///< a file for these as PDF; empty: none
  bool svg = false;           ///< the map as SVG, too
  bool no_map = false, no_cells = false, no_points = false;
  std::string pose_out;        ///< of match: a file for the pose alone
  std::string format = "ply";  ///< of points of distance and roughness
  MapOptions map;
  double raster = 0;                             ///< > 0: side of the pixels of difference.tif
  double contours = 0;                           ///< > 0: from one contour of d to the next
  std::string profile;                           ///< a line: x,y;x,y… or a file
  std::vector<Point2> line;                      ///< what it says, once it is read
  VectorFormat vectors = VectorFormat::geojson;  ///< of contours, outlines, changes
  bool outlines = false;                         ///< of the domain and of both scans
  bool vtu = false;                              ///< the cells for ParaView
};

/// --palette, --flip-palette, --range, --title, --author, --logo, --map-width, --svg and --report-vertices; sets the
/// date of the run. `title`: help of --title.
void add_map_options(Command& command, Delivery& delivery, const std::string& title);

/// These, --extent, --report, --pdf and --no-map.
void add_page_options(Command& command, Delivery& delivery, const std::string& title);

/// --report-vertices.
void add_view_option(Command& command, MapOptions& map);

/// --output and --json, under the heading of the output. `files`: what the help says of the folder.
Option add_result_options(Command& command, Delivery& delivery, const std::string& files);
void add_delivery_options(Command& command, Delivery& delivery, const std::string& default_folder);

/// What can be known to fail before any work is done: layers without a folder, in another direction than z, or of a
/// kind that this build does not write. Reads the line of a profile.
void check_layers(Delivery& delivery, const ProjectOptions& project);

/// Before any work is done: UsageError where no point of the scans lies in the extent of the map. Where B is moved, its
/// map may tell otherwise in the end.
void check_extent(const MapOptions& map, const CloudView& a, const CloudView& b);

/// Writes and prints all that `delivery` asks for. `folder` may hold files already; it is committed here. `matched`:
/// how B was moved, which is then said; null: it was not.
void deliver(Comparison& comparison, const CloudView& a, const CloudView& b, const std::optional<Truth>& truth,
             const Delivery& delivery, OutputFolder* folder, Run& run, const Matching* matched);

/// The files of the objects that changed, where they were asked for.
void write_changes(const Comparison& comparison, const Delivery& delivery, OutputFolder& folder);

/// Puts the time that a stage took into a result's: of reading, which came first; of writing, which comes last and is
/// told of the last time alone.
void add_read_time(Timing& timing, double seconds);
void set_write_time(Timing& timing, double seconds);

}  // namespace isopach::cli
