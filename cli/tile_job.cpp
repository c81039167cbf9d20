#include "cli/tile_job.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>

#include "cli/passing_folder.hpp"
#include "cli/scans.hpp"
#include "cli/tile_record.hpp"
#include "isopach/base/error.hpp"
#include "isopach/base/memory.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/compare/changes.hpp"
#include "isopach/compare/stages.hpp"
#include "isopach/geom/convex_hull.hpp"
#include "isopach/geom/curve.hpp"
#include "isopach/io/file_set.hpp"
#include "isopach/io/output_file.hpp"
#include "isopach/io/point_blocks.hpp"
#include "isopach/tiles/part_bytes.hpp"
#include "isopach/tiles/solve.hpp"

namespace isopach::cli {
namespace fs = std::filesystem;
namespace {

constexpr double bytes_a_point = 420;  // of a tile while it is solved; bench/tiles.py
constexpr double bytes_a_point_whole = 210;
constexpr std::uint64_t bytes_at_least = 150'000'000;  // of the program, a block of input, buffers of the spill
constexpr int deepest = 32;                            // levels of the curve

std::uint64_t memory_of_tile(std::uint64_t points) {
  return bytes_at_least + static_cast<std::uint64_t>(bytes_a_point * static_cast<double>(points));
}

/// Of the points that are sorted: an eighth of the memory, within reason.
std::size_t points_waiting(std::uint64_t memory) {
  return std::clamp<std::size_t>(static_cast<std::size_t>(memory / 8 / sizeof(Point3)), 2'000'000, 40'000'000);
}

/// A pipe, or what else can be read once alone.
bool is_stream(const std::string& path) {
  std::error_code error;
  return fs::exists(path, error) && !fs::is_regular_file(path, error);
}

/// Two looks at the files of both scans.
class Planner {
 public:
  Planner(Job& job, const CompareOptions& options, const Context& context)
      : job_(job), options_(options), wanted_(read_options(options.project)), context_(context) {}

  void look(std::size_t k, const std::string& word, BrokenFiles broken) {
    JobScan& scan = job_.scan[k];
    scan.name = word;
    const std::vector<std::string> files = files_of(word);
    ScanSystem system;
    std::vector<FileNotes> told;
    for (const std::string& path : files) {
      std::optional<FileLook> looked;
      try {
        looked = look_at(k, path);
      } catch (const InputError& e) {
        if (broken == BrokenFiles::refused || files.size() == 1) throw;
        scan.broken.push_back({path, e.what()});
        continue;
      }
      const Cloud& about = looked->about;
      const ScanSystem own{path, about.unit, about.vertical_unit, about.crs};
      if (scan.files.empty())
        system = own;
      else
        join_systems(system, own);
      scan.files.push_back(looked->stamp);
      scan.extent.add(looked->extent);
      scan.format = files.size() > 1 ? "set" : about.format;
      scan.nodata += about.nodata;
      scan.is_raster = scan.is_raster || (files.size() == 1 && about.grid.has_value());
      told.push_back({path, about.notes});
    }
    if (scan.files.empty())
      throw InputError(fmt::format("{}: none of its {} files can be read; the first: {}", word, files.size(),
                                   scan.broken.front().why));
    scan.notes = join_notes(told);
    scan.unit = system.unit, scan.vertical_unit = system.vertical_unit, scan.crs = system.crs;
  }

  void sort_into_tiles(std::uint64_t most) {
    Spill spill(job_.folder / "points", job_.frame.curve, points_waiting(job_.memory));
    const std::uint64_t all = kept(0) + kept(1);
    int level = 0;
    while (level < 6 && (all >> (2 * level)) * 16 > most) ++level;
    spill.begin({}, level);
    for (std::size_t k = 0; k < 2; ++k)
      for (const FileStamp& file : job_.scan[k].files)
        static_cast<void>(for_each_block(file.path, wanted_, context_, [&](const Cloud& block) {
          spill.add(k, points_in_frame(block, pose_of(k), job_.frame, options_.project));
        }));
    split(spill, spill.end(), most);
    check_sorted();
  }

  /// Points that share a cell of the curve are in one tile, however many they are.
  void refuse_tiles_beyond_memory() const {
    for (const JobTile& tile : job_.tiles) {
      const std::uint64_t needed = memory_of_tile(tile.square.all());
      if (job_.memory == 0 || needed <= job_.memory) continue;
      const Point3 at = place_in(tile);
      throw UsageError(
          fmt::format("--max-memory: {} points lie within {:.2g} of {:.10g}, {:.10g}, {:.10g}, and no tile can part "
                      "them: they take "
                      "{}, and {} are allowed: give --max-memory {}M or more, or thin the scans there",
                      tile.square.all(), std::ldexp(1 / job_.frame.curve.scale, deepest - tile.square.level), at.x,
                      at.y, at.z, bytes_in_words(needed), bytes_in_words(job_.memory), needed / 1'000'000 + 1));
    }
  }

 private:
  /// What a file tells of itself and its points.
  struct FileLook {
    FileStamp stamp;
    ScanExtent extent;
    Cloud about;
  };
  [[nodiscard]] FileLook look_at(std::size_t k, const std::string& path) const {
    FileLook found;
    const FileSummary stamp = summarise(path, wanted_, context_);
    if (is_stream(path))
      throw InputError(path + ": it can be read once alone, and tiles take two looks: write it to a file");
    found.stamp = {fs::absolute(path).lexically_normal().string(), stamp.bytes, stamp.modified_ns};
    found.about = for_each_block(path, wanted_, context_, [&](const Cloud& block) {
      found.extent.add(extent_of(block, pose_of(k), options_.project));
    });
    return found;
  }

  /// The second look found the points of the first.
  void check_sorted() const {
    check_inputs(job_);
    for (std::size_t k = 0; k < 2; ++k) {
      std::uint64_t sorted = 0;
      for (const JobTile& tile : job_.tiles) sorted += tile.square.points[k];
      if (sorted != kept(k))
        throw InputError(
            fmt::format("{}: it has changed while the job was planned: plan the job again", job_.scan[k].name));
    }
  }

  [[nodiscard]] Point3 place_in(const JobTile& tile) const {
    const PlacedFile file(job_.folder / "points");
    const std::vector<PointRun>& runs = tile.runs[tile.runs[0].empty() ? 1 : 0];
    return job_.frame.to_input(read_runs(file, {{runs.front().first, 1}}).front());
  }

  [[nodiscard]] const Pose& pose_of(std::size_t k) const { return k == 1 ? options_.pose : identity_; }
  [[nodiscard]] std::uint64_t kept(std::size_t k) const {
    const Cleaning& c = job_.scan[k].extent.cleaning;
    return c.points - c.dropped_nonfinite - c.dropped_class - c.dropped_crop;
  }

  /// The smallest square that holds the points: what it is cut into parts them, however near one another they are.
  void narrow(const PlacedFile& file, Spill::Bucket& bucket) const {
    std::optional<std::uint64_t> first;
    std::uint64_t differences = 0;
    for (const std::vector<PointRun>& runs : bucket.runs)
      for (const PointRun& run : runs)
        for (const Point3& p : read_runs(file, {run})) {
          const std::uint64_t key = curve_key(job_.frame.curve, {p.x, p.y});
          if (!first) first = key;
          differences |= key ^ *first;
        }
    bucket.square.level = std::countl_zero(differences) / 2;
    bucket.square.prefix = bucket.square.level == 0 ? 0 : *first >> (64 - 2 * bucket.square.level);
  }

  /// Squares that hold too many points are sorted once more, into smaller ones.
  void split(Spill& spill, std::vector<Spill::Bucket> buckets, std::uint64_t most) {
    std::vector<Spill::Bucket> done;
    while (!buckets.empty()) {
      Spill::Bucket bucket = std::move(buckets.back());
      buckets.pop_back();
      const PlacedFile file(job_.folder / "points");
      if (bucket.square.all() > most) narrow(file, bucket);
      if (bucket.square.all() <= most || bucket.square.level == deepest) {
        done.push_back(std::move(bucket));
        continue;
      }
      spill.begin(bucket.square, std::min(3, deepest - bucket.square.level));
      for (std::size_t k = 0; k < 2; ++k)
        for (const PointRun& run : bucket.runs[k]) spill.add(k, read_runs(file, {run}));
      for (Spill::Bucket& part : spill.end()) buckets.push_back(std::move(part));
      context_.check();
    }
    spill.close();
    for (std::size_t k = 0; k < 2; ++k) job_.scan[k].hull = hull_of(k, done);
    gather(std::move(done), most);
  }

  /// Of a point of each bucket, and then of all points of those that may reach beyond it.
  [[nodiscard]] std::vector<Point2> hull_of(std::size_t k, const std::vector<Spill::Bucket>& buckets) const {
    const PlacedFile file(job_.folder / "points");
    ConvexHull hull;
    const auto add = [&](const PointRun& run) {
      Array<Point2> places;
      for (const Point3& p : read_runs(file, {run})) places.push_back({p.x, p.y});
      hull.add(places);
      return places.front();
    };
    std::vector<OpenBox> squares(buckets.size());
    for (std::size_t i = 0; i < buckets.size(); ++i)
      if (!buckets[i].runs[k].empty())
        squares[i] = curve_square(job_.frame.curve, add({buckets[i].runs[k][0].first, 1}), buckets[i].square.level);
    for (std::size_t i = 0; i < buckets.size(); ++i) {
      if (holds(hull, squares[i])) continue;
      for (const PointRun& run : buckets[i].runs[k]) static_cast<void>(add(run));
      context_.check();
    }
    return hull.corners();
  }
  static bool holds(const ConvexHull& hull, const OpenBox& box) {
    const std::array<Point2, 4> corners{{box.low, {box.high.x, box.low.y}, box.high, {box.low.x, box.high.y}}};
    return std::all_of(corners.begin(), corners.end(),
                       [&](const Point2& p) { return std::isfinite(p.x) && std::isfinite(p.y) && hull.holds(p); });
  }

  void gather(std::vector<Spill::Bucket> buckets, std::uint64_t most) {
    std::sort(buckets.begin(), buckets.end(), [](const Spill::Bucket& a, const Spill::Bucket& b) {
      return a.square.first_key() < b.square.first_key();
    });
    std::vector<TileSquare> squares;
    for (const Spill::Bucket& bucket : buckets) squares.push_back(bucket.square);
    for (const TileSquare& square : joined_squares(std::move(squares), most)) job_.tiles.push_back({square, {}});
    std::size_t tile = 0;
    for (Spill::Bucket& bucket : buckets) {
      while (tile + 1 < job_.tiles.size() && job_.tiles[tile + 1].square.first_key() <= bucket.square.first_key())
        ++tile;
      for (std::size_t k = 0; k < 2; ++k) {
        auto& runs = job_.tiles[tile].runs[k];
        runs.insert(runs.end(), bucket.runs[k].begin(), bucket.runs[k].end());
      }
    }
  }

  Job& job_;
  const CompareOptions& options_;
  ReadOptions wanted_;
  const Context& context_;
  Pose identity_;
};

/// The folder of a job until its manifest stands in it: a plan that fails leaves nothing, and one that was killed is
/// swept by the next.
class NewFolder {
 public:
  explicit NewFolder(const fs::path& path) : path_(path) {
    std::error_code error;
    was_there_ = fs::exists(path_, error);
    if (!was_there_) return;
    sweep_unfinished_files(path_.string(), "manifest.json");
    if (!fs::is_directory(path_, error) || !holds_remains_alone())
      throw UsageError(
          fmt::format("--output {}: it is there and not empty: a job gets a folder of its own", path_.string()));
    clear();
  }
  ~NewFolder() {
    if (keep_) return;
    clear();
    std::error_code ignored;
    if (!was_there_) fs::remove(path_, ignored);
  }
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;

  void make() {
    std::error_code error;
    fs::create_directories(path_ / "tiles", error);
    if (error) fail_to_write(path_.string(), error.message());
  }
  void keep() { keep_ = true; }

 private:
  [[nodiscard]] bool holds_remains_alone() const {
    for (const fs::directory_entry& entry : fs::directory_iterator(path_)) {
      std::error_code error;
      const fs::path name = entry.path().filename();
      const bool is_ours = (name == "points" && entry.is_regular_file(error)) ||
                           (name == "tiles" && entry.is_directory(error) && fs::is_empty(entry.path(), error));
      if (!is_ours) return false;
    }
    return true;
  }
  void clear() const {
    std::error_code ignored;
    fs::remove(path_ / "points", ignored);
    fs::remove(path_ / "tiles", ignored);
  }

  fs::path path_;
  bool was_there_ = false, keep_ = false;
};

/// Before hours of work: the points, and about as much again twice for what tiles leave.
void require_room(const fs::path& folder, const Job& job) {
  std::error_code error;
  const fs::space_info space = fs::space(folder, error);
  if (error) return;  // the disk does not tell; writing will
  std::uint64_t points = 0;
  for (const JobScan& scan : job.scan) points += scan.extent.cleaning.points;
  constexpr std::uint64_t bytes = 80;
  if (points * bytes > space.available)
    fail_to_write((folder / "points").string(),
                  fmt::format("a job of {} points takes about {}, and {} are free there", points,
                              bytes_in_words(points * bytes), bytes_in_words(space.available)));
}

/// What a tile left of an earlier failure.
void say_failed(const fs::path& path, const std::string& why) {
  std::error_code ignored;
  if (why.empty())
    fs::remove(path, ignored);
  else
    write_text_atomically(path.string(), why + "\n");
}

void refuse_duplicates(const JobScan& scan, const Cleaning& cleaning, const CompareOptions& options) {
  if (cleaning.duplicates == 0 || options.project.duplicates != DuplicatePolicy::error) return;
  throw InputError(
      fmt::format("{}: {} points share their place in the plane with another point; choose how to merge "
                  "them (duplicates mean, min, max, median or first)",
                  scan.name, cleaning.duplicates));
}

/// 0: no limit, as the points of a tile are given.
std::uint64_t memory_for_tile(const JobLimits& limits) {
  if (limits.memory > 0) return limits.memory;
  return limits.tile_points > 0 ? 0 : usable_memory() / 2;
}

}  // namespace

std::uint64_t most_points(const JobLimits& limits) {
  if (limits.tile_points > 0 && limits.memory == 0) return limits.tile_points;
  const std::uint64_t memory = memory_for_tile(limits);
  if (memory < 2 * bytes_at_least)
    throw UsageError(fmt::format("--max-memory: {} leaves no room for points beside the program: give {} or more",
                                 bytes_in_words(memory), bytes_in_words(2 * bytes_at_least)));
  const auto points = static_cast<std::uint64_t>(static_cast<double>(memory - bytes_at_least) / bytes_a_point);
  return limits.tile_points > 0 ? std::min(limits.tile_points, points) : points;
}

std::uint64_t memory_of_tile(std::uint64_t points) {
  return bytes_at_least + static_cast<std::uint64_t>(bytes_a_point * static_cast<double>(points));
}

std::uint64_t memory_of_comparison(std::uint64_t points) {
  return bytes_at_least / 4 + static_cast<std::uint64_t>(bytes_a_point_whole * static_cast<double>(points));
}

Job plan_job(const std::string& a, const std::string& b, const CompareOptions& options, const Arguments& words,
             const JobLimits& limits, BrokenFiles broken, const fs::path& folder, const Context& context) {
  check_tiled(options);
  const std::uint64_t most = most_points(limits);
  NewFolder made(folder);
  Job job;
  job.folder = folder, job.words = words, job.pose = options.pose, job.memory = memory_for_tile(limits);
  run_with_threads(context, [&] {
    Planner planner(job, options, context);
    context.step("first look at the points", 0);
    planner.look(0, a, broken), planner.look(1, b, broken);
    Comparison refused;
    stages::check_units(job.scan[0].header(), job.scan[1].header(), options, refused);
    job.frame = choose_frame({job.scan[0].extent, job.scan[1].extent}, {a, b}, options.project.direction);
    stages::check_changes(options, job.frame);
    made.make();
    require_room(folder, job);
    context.step("sorting points into tiles", 0);
    planner.sort_into_tiles(most);
    planner.refuse_tiles_beyond_memory();
  });
  write_manifest(job);
  made.keep();
  return job;
}

void run_tile(const Job& job, std::size_t k, const CompareOptions& options, const Context& context) {
  if (job.is_done(k)) return;
  const JobTile& tile = job.tiles[k];
  try {
    run_with_threads(context, [&] {
      const TileWatch watch;
      TileInput input;
      input.frame = job.frame;
      const PlacedFile file(job.folder / "points");
      for (std::size_t s = 0; s < 2; ++s) {
        input.scan[s].hull = job.scan[s].hull;
        const Array<Point3> points = read_runs(file, tile.runs[s]);
        if (points.empty()) continue;
        const Point2 first{points[0].x, points[0].y};
        input.square = curve_square(job.frame.curve, first, tile.square.level);
        input.scan[s].is_raster = job.is_raster(s, options);
        input.scan[s].field = project_part(points, job.frame, options.project.duplicates,
                                           stages::asks_spreads(options) ? &input.scan[s].spread : nullptr, context);
        refuse_duplicates(job.scan[s], input.scan[s].field.cleaning, options);
        input.scan[s].points = stages::points_of_nodes(input.scan[s].field);
        Array<Index>().swap(input.scan[s].field.node_of_point);
      }
      const SolvedTile solved = solve_tile(std::move(input), options, context);
      write_text_atomically(job.tile_file(k, "cells").string(), bytes_of(solved.cells, job.id));
      write_record(job, k, watch.record());
      write_text_atomically(job.tile_file(k, "part").string(), bytes_of(solved.part, job.id));
    });
  } catch (const Interrupted&) {
    throw;
  } catch (const std::exception& e) {
    try {
      say_failed(job.tile_file(k, "failed"), e.what());
    } catch (const Error&) {  // a disk that is full takes no note either: what was first is what is told
    }
    throw;
  }
  say_failed(job.tile_file(k, "failed"), "");
}

std::optional<std::uint64_t> points_stated(const std::string& a, const std::string& b, const CompareOptions& options,
                                           const Context& context) {
  std::uint64_t points = 0;
  for (const std::string& word : {a, b})
    for (const std::string& path : files_of(word)) {
      if (is_stream(path)) return std::nullopt;
      const FileSummary summary = summarise(path, read_options(options.project), context);
      if (!summary.points) return std::nullopt;
      points += *summary.points;
    }
  return points;
}

Comparison compare_in_tiles(const std::string& a, const std::string& b, const CompareOptions& options,
                            const JobLimits& limits, const LookAtCells& look, Run& run) {
  const Context& context = run.context();
  const PassingFolder folder;
  const Job job = plan_job(a, b, options, {}, limits, BrokenFiles::refused, folder.path(), context);
  Context quiet = context;
  quiet.progress = nullptr;
  std::vector<std::size_t> tiles(job.tiles.size());
  std::iota(tiles.begin(), tiles.end(), std::size_t{0});
  TileProgress progress(job, tiles, context);
  for (const std::size_t k : tiles) {
    progress.begin(k);
    run_tile(job, k, options, quiet);
    progress.end(k);
  }
  context.step("joining tiles", 0);
  check_inputs(job);
  return reduce_job(job, options, false, look, run);
}

}  // namespace isopach::cli
