#include "cli/tile_job.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "cli/compare_request.hpp"
#include "cli/scans.hpp"
#include "isopach/base/error.hpp"
#include "isopach/base/memory.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/compare/stages.hpp"
#include "isopach/io/file_set.hpp"
#include "isopach/io/output_file.hpp"
#include "isopach/io/point_blocks.hpp"
#include "isopach/tiles/join.hpp"
#include "isopach/tiles/part_bytes.hpp"
#include "isopach/tiles/solve.hpp"

namespace isopach::cli {
namespace fs = std::filesystem;
namespace {

constexpr const char* schema = "isopach.tiles/1";
constexpr double bytes_a_point = 420;  // of a tile while it is solved; bench/tiles.py
constexpr double bytes_a_point_whole = 210;
constexpr std::uint64_t bytes_at_least = 150'000'000;  // of the program, a block of input, buffers of the spill

/// A file that is read at places.
class PlacedFile {
 public:
  explicit PlacedFile(const fs::path& path)
      : path_(path.string()), descriptor_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (descriptor_ < 0) fail();
  }
  ~PlacedFile() { ::close(descriptor_); }
  PlacedFile(const PlacedFile&) = delete;
  PlacedFile& operator=(const PlacedFile&) = delete;

  void read(void* to, std::size_t size, std::uint64_t at) const {
    auto* bytes = static_cast<char*>(to);
    while (size > 0) {
      const ssize_t got = ::pread(descriptor_, bytes, size, static_cast<off_t>(at));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) fail();
      if (got == 0) throw InputError(path_ + ": it is cut short: plan the job again (isopach tile plan)");
      bytes += got, at += static_cast<std::uint64_t>(got), size -= static_cast<std::size_t>(got);
    }
  }

 private:
  [[noreturn]] void fail() const {
    throw InputError(
        fmt::format("{}: cannot be read ({}): plan the job again (isopach tile plan)", path_, std::strerror(errno)));
  }
  std::string path_;
  int descriptor_;
};

/// The bytes of a file, mapped: what has been looked at can go.
class MappedFile {
 public:
  explicit MappedFile(const fs::path& path) {
    const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    struct stat about {};
    if (descriptor < 0 || ::fstat(descriptor, &about) != 0) {
      const int error = errno;
      if (descriptor >= 0) ::close(descriptor);
      throw InputError(fmt::format("{}: cannot be read ({})", path.string(), std::strerror(error)));
    }
    size_ = static_cast<std::size_t>(about.st_size);
    if (size_ > 0) data_ = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, descriptor, 0);
    const int error = errno;
    ::close(descriptor);
    if (data_ == MAP_FAILED)
      throw Error(ExitCode::internal, fmt::format("{}: cannot be mapped ({})", path.string(), std::strerror(error)));
  }
  ~MappedFile() {
    if (data_ != nullptr) ::munmap(data_, size_);
  }
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  [[nodiscard]] std::span<const char> bytes() const { return {static_cast<const char*>(data_), size_}; }

 private:
  void* data_ = nullptr;
  std::size_t size_ = 0;
};

/// Cells of a file, which is mapped as long as they are looked at.
std::shared_ptr<const CellPart> cells_in(const fs::path& path, const std::string& job, std::size_t first_node) {
  struct Held {
    MappedFile file;
    CellPart cells;
    Held(const fs::path& of, const std::string& id, std::size_t node)
        : file(of), cells(cells_of(file.bytes(), id, of.string(), node)) {}
  };
  const auto held = std::make_shared<const Held>(path, job, first_node);
  return {held, &held->cells};
}

/// Points sorted into squares of the curve as they come, in one file: runs of a few thousand.
class Spill {
 public:
  struct Bucket {
    TileSquare square;
    std::array<std::vector<PointRun>, 2> runs;
  };

  Spill(const fs::path& path, const CurveBox& box) : file_(path.string()), box_(box) {}

  /// Points of a scan that lie in the square at hand, into the squares `deeper` levels below it.
  void begin(const TileSquare& within, int deeper) {
    level_ = within.level + deeper;
    first_ = level_ == 0 ? 0 : within.prefix << (2 * deeper);
    buckets_.assign(std::size_t{1} << (2 * deeper), {});
    for (auto& of_scan : waiting_) of_scan.assign(buckets_.size(), {});
    // All buffers together: a fixed part of memory.
    run_ = std::clamp<std::size_t>(most_waiting / (2 * buckets_.size()), 64, 65536);
  }
  void add(std::size_t scan, std::span<const Point3> points) {
    Array<std::uint64_t> keys(points.size());
    for_each_index(points.size(), [&](std::size_t i) { keys[i] = curve_key(box_, {points[i].x, points[i].y}); });
    for (std::size_t i = 0; i < points.size(); ++i) {
      const std::size_t bucket = level_ == 0 ? 0 : static_cast<std::size_t>((keys[i] >> (64 - 2 * level_)) - first_);
      std::vector<Point3>& waiting = waiting_[scan][bucket];
      waiting.push_back(points[i]);
      if (waiting.size() == run_) write(scan, bucket);
    }
  }
  /// The squares that hold points.
  [[nodiscard]] std::vector<Bucket> end() {
    std::vector<Bucket> found;
    for (std::size_t b = 0; b < buckets_.size(); ++b) {
      for (std::size_t scan = 0; scan < 2; ++scan) write(scan, b);
      Bucket& bucket = buckets_[b];
      bucket.square.level = level_, bucket.square.prefix = first_ + b;
      for (std::size_t scan = 0; scan < 2; ++scan)
        for (const PointRun& run : bucket.runs[scan]) bucket.square.points[scan] += run.count;
      if (bucket.square.all() > 0) found.push_back(std::move(bucket));
    }
    buckets_.clear();
    return found;
  }
  void close() { file_.close(); }

 private:
  static constexpr std::size_t most_waiting = 2'000'000;  // points

  void write(std::size_t scan, std::size_t bucket) {
    std::vector<Point3>& waiting = waiting_[scan][bucket];
    if (waiting.empty()) return;
    file_.write({reinterpret_cast<const char*>(waiting.data()), waiting.size() * sizeof(Point3)});
    buckets_[bucket].runs[scan].push_back({written_, waiting.size()});
    written_ += waiting.size();
    waiting.clear();
  }

  OutputFile file_;
  const CurveBox& box_;
  int level_ = 0;
  std::uint64_t first_ = 0, written_ = 0;
  std::size_t run_ = 0;
  std::vector<Bucket> buckets_;
  std::array<std::vector<std::vector<Point3>>, 2> waiting_;
};

Array<Point3> read_runs(const PlacedFile& file, const std::vector<PointRun>& runs) {
  std::uint64_t count = 0;
  for (const PointRun& run : runs) count += run.count;
  Array<Point3> points(static_cast<std::size_t>(count));
  std::size_t at = 0;
  for (const PointRun& run : runs) {
    file.read(points.data() + at, static_cast<std::size_t>(run.count) * sizeof(Point3), run.first * sizeof(Point3));
    at += static_cast<std::size_t>(run.count);
  }
  return points;
}

/// Two looks at the files of both scans.
class Planner {
 public:
  Planner(Job& job, const CompareOptions& options, const Context& context)
      : job_(job), options_(options), wanted_(read_options(options.project)), context_(context) {}

  void look(std::size_t k, const std::string& word) {
    JobScan& scan = job_.scan[k];
    scan.name = word;
    const std::vector<std::string> files = files_of(word);
    ScanSystem system;
    std::vector<FileNotes> told;
    for (const std::string& path : files) {
      const FileSummary stamp = summarise(path, wanted_, context_);
      scan.files.push_back({path, stamp.bytes, stamp.modified_ns});
      const Cloud about = for_each_block(path, wanted_, context_, [&](const Cloud& block) {
        scan.extent.add(extent_of(block, pose_of(k), options_.project));
      });
      join_systems(system, {path, about.unit, about.vertical_unit, about.crs});
      scan.format = files.size() > 1 ? "set" : about.format;
      scan.nodata += about.nodata;
      scan.is_raster = scan.is_raster || (files.size() == 1 && about.grid.has_value());
      told.push_back({path, about.notes});
    }
    scan.notes = join_notes(told);
    scan.unit = system.unit, scan.vertical_unit = system.vertical_unit, scan.crs = system.crs;
  }

  void sort_into_tiles(std::uint64_t most) {
    Spill spill(job_.folder / "points", job_.frame.curve);
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
  }

 private:
  [[nodiscard]] const Pose& pose_of(std::size_t k) const { return k == 1 ? options_.pose : identity_; }
  [[nodiscard]] std::uint64_t kept(std::size_t k) const {
    const Cleaning& c = job_.scan[k].extent.cleaning;
    return c.points - c.dropped_nonfinite - c.dropped_class - c.dropped_crop;
  }

  /// Squares that hold too many points are sorted once more, into smaller ones.
  void split(Spill& spill, std::vector<Spill::Bucket> buckets, std::uint64_t most) {
    std::vector<Spill::Bucket> done;
    while (!buckets.empty()) {
      Spill::Bucket bucket = std::move(buckets.back());
      buckets.pop_back();
      constexpr int deepest = 30;
      if (bucket.square.all() <= most || bucket.square.level >= deepest) {
        done.push_back(std::move(bucket));
        continue;
      }
      const PlacedFile file(job_.folder / "points");
      spill.begin(bucket.square, 3);
      for (std::size_t k = 0; k < 2; ++k)
        for (const PointRun& run : bucket.runs[k]) spill.add(k, read_runs(file, {run}));
      for (Spill::Bucket& part : spill.end()) buckets.push_back(std::move(part));
      context_.check();
    }
    spill.close();
    gather(std::move(done), most);
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

using Json = nlohmann::ordered_json;

Json of(const Point3& p) { return Json::array({p.x, p.y, p.z}); }
Point3 point_of(const Json& j) { return {j.at(0).get<double>(), j.at(1).get<double>(), j.at(2).get<double>()}; }
Json of(const Box3& box) { return box.empty() ? Json() : Json::array({of(box.min), of(box.max)}); }
Box3 box_of(const Json& j) {
  Box3 box;
  if (!j.is_null()) box.min = point_of(j.at(0)), box.max = point_of(j.at(1));
  return box;
}

Json of(const JobScan& s) {
  const Cleaning& c = s.extent.cleaning;
  Json files = Json::array();
  for (const FileStamp& f : s.files)
    files.push_back({{"path", f.path}, {"bytes", f.bytes}, {"modified_ns", f.modified_ns}});
  return {{"name", s.name},
          {"format", s.format},
          {"unit", s.unit},
          {"vertical_unit", s.vertical_unit},
          {"crs", s.crs},
          {"notes", s.notes},
          {"nodata", s.nodata},
          {"is_raster", s.is_raster},
          {"points", c.points},
          {"dropped", {{"nonfinite", c.dropped_nonfinite}, {"class", c.dropped_class}, {"crop", c.dropped_crop}}},
          {"kept", of(s.extent.kept)},
          {"finite", of(s.extent.finite)},
          {"files", files}};
}

JobScan scan_of(const Json& j) {
  JobScan s;
  j.at("name").get_to(s.name), j.at("format").get_to(s.format), j.at("unit").get_to(s.unit);
  j.at("vertical_unit").get_to(s.vertical_unit), j.at("crs").get_to(s.crs), j.at("notes").get_to(s.notes);
  j.at("nodata").get_to(s.nodata), j.at("is_raster").get_to(s.is_raster);
  Cleaning& c = s.extent.cleaning;
  j.at("points").get_to(c.points);
  const Json& dropped = j.at("dropped");
  dropped.at("nonfinite").get_to(c.dropped_nonfinite), dropped.at("class").get_to(c.dropped_class);
  dropped.at("crop").get_to(c.dropped_crop);
  s.extent.kept = box_of(j.at("kept")), s.extent.finite = box_of(j.at("finite"));
  for (const Json& f : j.at("files"))
    s.files.push_back(
        {f.at("path").get<std::string>(), f.at("bytes").get<std::uint64_t>(), f.at("modified_ns").get<std::int64_t>()});
  return s;
}

Json of(const std::vector<PointRun>& runs) {
  Json all = Json::array();
  for (const PointRun& run : runs) all.push_back({run.first, run.count});
  return all;
}

std::vector<PointRun> runs_of(const Json& j) {
  std::vector<PointRun> runs;
  for (const Json& run : j) runs.push_back({run.at(0).get<std::uint64_t>(), run.at(1).get<std::uint64_t>()});
  return runs;
}

Json of(const Job& job) {
  Json tiles = Json::array();
  for (const JobTile& t : job.tiles)
    tiles.push_back({{"level", t.square.level},
                     {"prefix", t.square.prefix},
                     {"points", t.square.points},
                     {"a", of(t.runs[0])},
                     {"b", of(t.runs[1])}});
  const Frame& f = job.frame;
  return {{"schema", schema},
          {"words", job.words},
          {"inputs", {of(job.scan[0]), of(job.scan[1])}},
          {"frame",
           {{"origin", of(f.origin)},
            {"rotation", f.rotation},
            {"box", of(f.box)},
            {"curve", {f.curve.min.x, f.curve.min.y, f.curve.scale}}}},
          {"tiles", tiles}};
}

std::string id_of(const std::string& text) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return fmt::format("{:016x}", hash);
}

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

InputSummary summary_of(const JobScan& scan, const char* role, const Cleaning& of_nodes, std::size_t nodes) {
  CloudView cloud;
  cloud.path = scan.name, cloud.format = scan.format, cloud.unit = scan.unit;
  cloud.vertical_unit = scan.vertical_unit, cloud.crs = scan.crs;
  InputSummary s = stages::summarise_file(cloud, role);
  s.points = scan.extent.cleaning.points, s.nodes = nodes;
  s.cleaning = scan.extent.cleaning;
  s.cleaning.duplicates = of_nodes.duplicates, s.cleaning.duplicate_max_spread = of_nodes.duplicate_max_spread;
  s.bounds = scan.extent.finite, s.nodata = scan.nodata;
  return s;
}

CloudView header_of(const JobScan& scan) {
  CloudView cloud;
  cloud.path = scan.name, cloud.unit = scan.unit, cloud.vertical_unit = scan.vertical_unit, cloud.crs = scan.crs;
  cloud.notes = scan.notes;
  return cloud;
}

/// Whether folds ask how far apart the heights of merged points lie, as stages::merged_spreads does.
bool merges(const CompareOptions& options) {
  const DuplicatePolicy policy = options.project.duplicates;
  return options.check_layers && (policy == DuplicatePolicy::mean || policy == DuplicatePolicy::median);
}

void refuse_duplicates(const JobScan& scan, const Cleaning& cleaning, const CompareOptions& options) {
  if (cleaning.duplicates == 0 || options.project.duplicates != DuplicatePolicy::error) return;
  throw InputError(
      fmt::format("{}: {} points share their place in the plane with another point; choose how to merge "
                  "them (duplicates mean, min, max, median or first)",
                  scan.name, cleaning.duplicates));
}

class Reducer {
 public:
  Reducer(const Job& job, const CompareOptions& options, const Context& context)
      : job_(job), options_(options), context_(context) {}

  Comparison run(bool allow_missing, const LookAtCells& look) {
    const std::vector<std::size_t> done = tiles_done(allow_missing);
    Comparison c;
    c.options = options_;
    c.frame = job_.frame;
    stages::check_units(header_of(job_.scan[0]), header_of(job_.scan[1]), options_, c);
    TilesToJoin tiles;
    tiles.is_raster = {job_.scan[0].is_raster, job_.scan[1].is_raster};
    std::size_t first_node = 0;
    for (const std::size_t k : done) {
      const fs::path part = job_.tile_file(k, "part"), of_cells = job_.tile_file(k, "cells");
      tiles.parts.push_back(part_of(MappedFile(part).bytes(), job_.id, part.string()));
      const auto open = [of_cells, id = job_.id, first_node] { return cells_in(of_cells, id, first_node); };
      const std::shared_ptr<const CellPart> first = open();
      if (first->xy.size() != tiles.parts.back().nodes)
        throw InputError(of_cells.string() + ": it does not fit its part: remove both, and run the tile again");
      tiles.cells.push_back({first->triangles.size(), open});
      first_node += tiles.parts.back().nodes;
      context_.step("reading parts", static_cast<double>(tiles.parts.size()) / static_cast<double>(done.size()));
    }
    describe(tiles.parts, done, c);
    if (look) tiles.look = [&](const PartedCells& all) { look(all, c); };
    hint_at_matching(join_tiles(std::move(tiles), c, context_), c);
    if (done.size() < job_.tiles.size())
      c.warnings.push_back(fmt::format("{} of {} tiles are missing: their points are no part of this comparison",
                                       job_.tiles.size() - done.size(), job_.tiles.size()));
    return c;
  }

 private:
  [[nodiscard]] std::vector<std::size_t> tiles_done(bool allow_missing) const {
    std::vector<std::size_t> done;
    std::size_t missing = 0, first = 0;
    for (std::size_t k = 0; k < job_.tiles.size(); ++k) {
      if (job_.is_done(k))
        done.push_back(k);
      else if (missing++ == 0)
        first = k;
    }
    if (missing > 0 && !allow_missing)
      throw InputError(
          fmt::format("{}: {} of {} tiles are not done, the first is {}: run them (isopach tile run {} --missing), or "
                      "compare the points of the others alone (--allow-missing)",
                      job_.folder.string(), missing, job_.tiles.size(), first, job_.folder.string()));
    return done;
  }

  void describe(const std::vector<Part>& parts, const std::vector<std::size_t>& done, Comparison& c) {
    for (std::size_t k = 0; k < 2; ++k) {
      Cleaning of_nodes;
      std::size_t nodes = 0;
      LayerCheck layers;
      for (const Part& part : parts) {
        const ScanPart& s = part.scan[k];
        nodes += s.nodes;
        of_nodes.duplicates += s.cleaning.duplicates;
        of_nodes.duplicate_max_spread = std::max(of_nodes.duplicate_max_spread, s.cleaning.duplicate_max_spread);
        layers.add(s.layers);
      }
      InputSummary& s = k == 0 ? c.a : c.b;
      s = summary_of(job_.scan[k], k == 0 ? "A" : "B", of_nodes, nodes);
      if (options_.check_layers && nodes > 0) s.layered_share = layered_share(k, std::move(layers), done, s);
    }
    stages::warn_of_layers(c);
  }

  /// One more look at all points.
  double layered_share(std::size_t k, LayerCheck layers, const std::vector<std::size_t>& done, const InputSummary& s) {
    const PlacedFile file(job_.folder / "points");
    double share = 0;
    run_with_threads(context_, [&] {
      layers.begin(s.nodes + s.cleaning.duplicates, job_.frame.curve);
      for (const std::size_t tile : done)
        for (const PointRun& run : job_.tiles[tile].runs[k]) layers.add_points(read_runs(file, {run}));
      share = layers.share(context_);
    });
    return share;
  }

  const Job& job_;
  const CompareOptions& options_;
  const Context& context_;
};

}  // namespace

fs::path Job::tile_file(std::size_t k, const char* ending) const {
  return folder / "tiles" / fmt::format("{:06d}.{}", k, ending);
}

bool Job::is_done(std::size_t k) const {
  std::error_code error;
  return fs::is_regular_file(tile_file(k, "part"), error);
}

std::uint64_t most_points(const JobLimits& limits) {
  if (limits.tile_points > 0) return limits.tile_points;
  const std::uint64_t memory = limits.memory > 0 ? limits.memory : usable_memory() / 2;
  if (memory < 2 * bytes_at_least)
    throw UsageError(fmt::format("--max-memory: {} leaves no room for points beside the program: give {} or more",
                                 bytes_in_words(memory), bytes_in_words(2 * bytes_at_least)));
  return static_cast<std::uint64_t>(static_cast<double>(memory - bytes_at_least) / bytes_a_point);
}

std::uint64_t memory_of_comparison(std::uint64_t points) {
  return bytes_at_least / 4 + static_cast<std::uint64_t>(bytes_a_point_whole * static_cast<double>(points));
}

Job plan_job(const std::string& a, const std::string& b, const CompareOptions& options, const Arguments& words,
             const JobLimits& limits, const fs::path& folder, const Context& context) {
  check_tiled(options);
  const std::uint64_t most = most_points(limits);
  NewFolder made(folder);
  Job job;
  job.folder = folder, job.words = words;
  run_with_threads(context, [&] {
    Planner planner(job, options, context);
    context.step("first look at the points", 0);
    planner.look(0, a), planner.look(1, b);
    Comparison refused;
    stages::check_units(header_of(job.scan[0]), header_of(job.scan[1]), options, refused);
    job.frame = choose_frame({job.scan[0].extent, job.scan[1].extent}, {a, b}, options.project.direction);
    made.make();
    require_room(folder, job);
    context.step("sorting points into tiles", 0);
    planner.sort_into_tiles(most);
  });
  const std::string text = of(job).dump(1, ' ', false, Json::error_handler_t::replace);
  job.id = id_of(text);
  write_text_atomically((folder / "manifest.json").string(), text + "\n");
  made.keep();
  return job;
}

Job read_job(const fs::path& folder, const Context& context) {
  context.check();
  const fs::path path = folder / "manifest.json";
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw UsageError(
        fmt::format("{}: there is no job: plan one (isopach tile plan A B -o {})", folder.string(), folder.string()));
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  try {
    const Json json = Json::parse(text);
    if (json.at("schema") != schema) throw InputError("");
    Job job;
    job.folder = folder;
    job.id = id_of(text.substr(0, text.find_last_not_of('\n') + 1));
    json.at("words").get_to(job.words);
    for (std::size_t k = 0; k < 2; ++k) job.scan[k] = scan_of(json.at("inputs").at(k));
    const Json& frame = json.at("frame");
    job.frame.origin = point_of(frame.at("origin"));
    frame.at("rotation").get_to(job.frame.rotation);
    job.frame.box = box_of(frame.at("box"));
    const Json& curve = frame.at("curve");
    job.frame.curve = {{curve.at(0).get<double>(), curve.at(1).get<double>()}, curve.at(2).get<double>()};
    for (const Json& t : json.at("tiles")) {
      JobTile tile;
      t.at("level").get_to(tile.square.level), t.at("prefix").get_to(tile.square.prefix);
      t.at("points").get_to(tile.square.points);
      tile.runs = {runs_of(t.at("a")), runs_of(t.at("b"))};
      if (tile.square.level < 0 || tile.square.level > 32) throw InputError("");
      job.tiles.push_back(std::move(tile));
    }
    return job;
  } catch (const std::exception&) {
    throw InputError(path.string() + ": this is no manifest of a job, or it is damaged: plan the job again");
  }
}

void check_inputs(const Job& job) {
  for (const JobScan& scan : job.scan)
    for (const FileStamp& file : scan.files) {
      struct stat about {};
      if (::stat(file.path.c_str(), &about) != 0)
        throw InputError(
            fmt::format("{}: it is gone ({}), and the job was planned with it", file.path, std::strerror(errno)));
      const std::int64_t changed = std::int64_t{about.st_mtim.tv_sec} * 1'000'000'000 + about.st_mtim.tv_nsec;
      if (static_cast<std::uint64_t>(about.st_size) != file.bytes || changed != file.modified_ns)
        throw InputError(file.path +
                         ": it has changed since the job was planned: plan the job again (isopach tile plan)");
    }
}

void run_tile(const Job& job, std::size_t k, const CompareOptions& options, const Context& context) {
  if (job.is_done(k)) return;
  const JobTile& tile = job.tiles[k];
  try {
    run_with_threads(context, [&] {
      TileInput input;
      input.frame = job.frame;
      const PlacedFile file(job.folder / "points");
      for (std::size_t s = 0; s < 2; ++s) {
        const Array<Point3> points = read_runs(file, tile.runs[s]);
        if (points.empty()) continue;
        const Point2 first{points[0].x, points[0].y};
        input.square = curve_square(job.frame.curve, first, tile.square.level);
        input.scan[s].is_raster = job.scan[s].is_raster;
        input.scan[s].field = project_part(points, job.frame, options.project.duplicates,
                                           merges(options) ? &input.scan[s].spread : nullptr, context);
        refuse_duplicates(job.scan[s], input.scan[s].field.cleaning, options);
        Array<Index>().swap(input.scan[s].field.node_of_point);
      }
      const SolvedTile solved = solve_tile(std::move(input), options, context);
      write_text_atomically(job.tile_file(k, "cells").string(), bytes_of(solved.cells, job.id));
      write_text_atomically(job.tile_file(k, "part").string(), bytes_of(solved.part, job.id));
    });
  } catch (const Interrupted&) {
    throw;
  } catch (const std::exception& e) {
    say_failed(job.tile_file(k, "failed"), e.what());
    throw;
  }
  say_failed(job.tile_file(k, "failed"), "");
}

Comparison reduce_job(const Job& job, const CompareOptions& options, bool allow_missing, const LookAtCells& look,
                      const Context& context) {
  return Reducer(job, options, context).run(allow_missing, look);
}

std::optional<std::uint64_t> points_stated(const std::string& a, const std::string& b, const CompareOptions& options,
                                           const Context& context) {
  std::uint64_t points = 0;
  for (const std::string& word : {a, b})
    for (const std::string& path : files_of(word)) {
      const FileSummary summary = summarise(path, read_options(options.project), context);
      if (!summary.points) return std::nullopt;
      points += *summary.points;
    }
  return points;
}

namespace {

/// A folder for the time of a run.
class PassingFolder {
 public:
  PassingFolder() : path_(fs::temp_directory_path() / unfinished_name()) {}
  ~PassingFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  PassingFolder(const PassingFolder&) = delete;
  PassingFolder& operator=(const PassingFolder&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

}  // namespace

Comparison compare_in_tiles(const std::string& a, const std::string& b, const CompareOptions& options,
                            const JobLimits& limits, const LookAtCells& look, const Context& context) {
  const PassingFolder folder;
  const Job job = plan_job(a, b, options, {}, limits, folder.path(), context);
  Context quiet = context;
  quiet.progress = nullptr;
  for (std::size_t k = 0; k < job.tiles.size(); ++k) {
    context.step(fmt::format("tile {} of {}", k + 1, job.tiles.size()),
                 static_cast<double>(k) / static_cast<double>(job.tiles.size()));
    run_tile(job, k, options, quiet);
  }
  context.step("joining tiles", 0);
  check_inputs(job);
  return reduce_job(job, options, false, look, context);
}

}  // namespace isopach::cli
