// A comparison made in tiles, as a folder: what `tile plan` writes, every `tile run` reads, and `tile reduce` joins.
//
// JOB/manifest.json: inputs, options, frame, tiles. Written last by plan: without it there is no job.
//
// JOB/points: points of both scans in the frame, tile by tile, 24 bytes each.
//
// JOB/tiles/K.cells: final cells of tile K.
//
// JOB/tiles/K.part: what it passes up; with it the tile is done.
//
// JOB/tiles/K.json: what the run of it took (tile_record.hpp).
//
// JOB/tiles/K.failed: why the last run of it failed, in one line.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cli/answer.hpp"
#include "cli/command.hpp"
#include "cli/tile_points.hpp"
#include "cli/verbs.hpp"
#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud_view.hpp"
#include "isopach/compare/comparison.hpp"
#include "isopach/field/height_field.hpp"
#include "isopach/geom/vec.hpp"
#include "isopach/measure/parted_cells.hpp"
#include "isopach/tiles/join.hpp"
#include "isopach/tiles/squares.hpp"

namespace isopach::cli {

/// A file as it was when the job was planned.
struct FileStamp {
  std::string path;  ///< absolute: tiles may be run from another folder
  std::uint64_t bytes = 0;
  std::int64_t modified_ns = 0;
};

/// A file of a set that could not be read, and the message that says why.
struct BrokenFile {
  std::string path, why;
};

/// What becomes of a set of several files of which some cannot be read: an error, or a job of the others, which names
/// them in its manifest.
enum class BrokenFiles { refused, left_out };

struct JobScan {
  std::string name, format, unit = "unknown", vertical_unit = "unknown", crs;
  std::vector<FileStamp> files;
  std::vector<BrokenFile> broken;  ///< no part of the job
  std::vector<std::string> notes;
  std::size_t nodata = 0;
  bool is_raster = false;  ///< its file; whether it is one height a cell goes by direction and pose
  ScanExtent extent;
  std::vector<Point2> hull;  ///< of its points in the frame, as ConvexHull::corners

  /// What a comparison asks of a scan beside its points.
  [[nodiscard]] CloudView header() const;
};

struct JobTile {
  TileSquare square;
  std::array<std::vector<PointRun>, 2> runs;
};

struct Job {
  std::filesystem::path folder;
  std::string id;            ///< of inputs, options and tiles: parts of another plan are not taken for its own
  Arguments words;           ///< options as they were given, on the command line or by --config, but for the pose
  Pose pose;                 ///< of B
  std::uint64_t memory = 0;  ///< bytes that the run of a tile may take; 0: the points of a tile were given instead
  std::array<JobScan, 2> scan;
  Frame frame;
  std::vector<JobTile> tiles;

  [[nodiscard]] std::filesystem::path tile_file(std::size_t k, const char* ending) const;
  [[nodiscard]] bool is_done(std::size_t k) const;
  /// Whether scan k is one height a cell, as stages::MergedSpread::is_raster.
  [[nodiscard]] bool is_raster(std::size_t k, const CompareOptions& options) const;
};

struct JobLimits {
  std::uint64_t memory = 0;       ///< bytes that a run of one tile may take; 0: half of the memory
  std::uint64_t tile_points = 0;  ///< most points of a tile, of both scans; 0: what the memory has room for
};

/// Most points of a tile, of both scans: where both limits are given, the narrower one.
[[nodiscard]] std::uint64_t most_points(const JobLimits& limits);
/// Bytes that the run of a tile of so many points takes at most, about.
[[nodiscard]] std::uint64_t memory_of_tile(std::uint64_t points);
/// What compare() in memory takes, about, for scans of so many points together.
[[nodiscard]] std::uint64_t memory_of_comparison(std::uint64_t points);

/// Reads both scans twice, block by block; memory does not depend on their size. Errors as of read_cloud and
/// choose_frame, also where no file of a set can be read, or one only at the first look; UsageError if the folder holds
/// a job or anything else already, or if one cell of the curve, the smallest tile, holds more points than the memory
/// has room for.
[[nodiscard]] Job plan_job(const std::string& a, const std::string& b, const CompareOptions& options,
                           const Arguments& words, const JobLimits& limits, BrokenFiles broken,
                           const std::filesystem::path& folder, const Context& context);

/// JOB/manifest.json, from which the id follows.
void write_manifest(Job& job);

/// UsageError if there is no job in the folder; InputError if its manifest is damaged.
[[nodiscard]] Job read_job(const std::filesystem::path& folder, const Context& context);

/// InputError, naming the file, if an input is not what it was when the job was planned.
void check_inputs(const Job& job);

/// Does tile k unless it is done. Files appear whole.
void run_tile(const Job& job, std::size_t k, const CompareOptions& options, const Context& context);

/// What the join tells of the points, for those who write them.
struct JoinedNodes {
  std::vector<std::size_t> tiles;  ///< those that were joined
  HeightsOfOther heights;          ///< of the nodes that they passed up
};

/// All that the tiles found as one comparison; its cells are those that tiles left open. InputError if tiles are
/// missing or files were left out, unless `allow_missing`: then all other points are compared, and warnings say so;
/// also if joining them would take more memory than there is. Says on stderr if it takes more than the job allows.
[[nodiscard]] Comparison reduce_job(const Job& job, const CompareOptions& options, bool allow_missing,
                                    const LookAtCells& look, Run& run, JoinedNodes* nodes = nullptr);

/// What of the points of both scans is known without reading them; nothing where one of their files does not say.
[[nodiscard]] std::optional<std::uint64_t> points_stated(const std::string& a, const std::string& b,
                                                         const CompareOptions& options, const Context& context);

/// All steps on this machine, in a folder that is removed at the end, however that comes.
[[nodiscard]] Comparison compare_in_tiles(const std::string& a, const std::string& b, const CompareOptions& options,
                                          const JobLimits& limits, const LookAtCells& look, Run& run);

}  // namespace isopach::cli
