// isopach tile status
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "cli/command.hpp"
#include "cli/output.hpp"
#include "cli/tile_job.hpp"
#include "cli/tile_record.hpp"
#include "cli/tile_steps.hpp"
#include "isopach/base/error.hpp"
#include "isopach/base/memory.hpp"
#include "isopach/base/option_key.hpp"
#include "isopach/io/output_file.hpp"
#include "isopach/io/vector_format.hpp"
#include "isopach/report/tile_states.hpp"
#include "isopach/report/vector_styles.hpp"

namespace isopach::cli {
namespace {
namespace fs = std::filesystem;

using Json = nlohmann::ordered_json;

enum class State { done, failed, missing };

const char* word_of(State state) {
  return state == State::done ? "done" : state == State::failed ? "failed" : "missing";
}

struct TileAtHand {
  State state = State::missing;
  std::string why;  ///< first line of the last failure
  std::optional<TileRecord> took;
};

/// A job as it stands now.
class JobStatus {
 public:
  explicit JobStatus(const Job& job) : job_(job) {
    for (std::size_t k = 0; k < job.tiles.size(); ++k) add(k);
  }

  [[nodiscard]] std::string text() const {
    std::string out = fmt::format("{} of {} tiles done", count(State::done), job_.tiles.size());
    if (count(State::failed) > 0) out += fmt::format(", {} failed", count(State::failed));
    out += fmt::format(", {} of {} points\n", points_done_, points_);
    if (const std::string pace = pace_in_words(points_timed_, seconds_, points_ - points_done_); !pace.empty())
      out += pace + " in one run at a time\n";
    if (peak_)
      out += fmt::format("largest memory of a tile {}{}\n", bytes_in_words(*peak_),
                         job_.memory > 0 ? ", allowed " + bytes_in_words(job_.memory) : "");
    for (const JobScan& scan : job_.scan)
      for (const BrokenFile& file : scan.broken) out += fmt::format("left out: {}\n", for_shell(file.why));
    for (std::size_t k = 0; k < tiles_.size(); ++k)
      if (tiles_[k].state == State::failed) out += fmt::format("tile {} failed: {}\n", k, for_shell(tiles_[k].why));
    const std::string folder = job_.folder.string();
    return out + (count(State::done) == tiles_.size() ? fmt::format("now: isopach tile reduce {}\n", folder)
                                                      : fmt::format("now: isopach tile run {} --missing\n", folder));
  }

  [[nodiscard]] std::string json() const {
    Json each = Json::array();
    for (std::size_t k = 0; k < tiles_.size(); ++k) each.push_back(json_of(k));
    const bool has_pace = points_timed_ > 0 && seconds_ > 0;
    const double rate = has_pace ? static_cast<double>(points_timed_) / seconds_ : 0;
    const Json all{{"schema", "isopach.tile-status/1"},
                   {"tiles", tiles_.size()},
                   {"done", count(State::done)},
                   {"failed", count(State::failed)},
                   {"missing", count(State::missing)},
                   {"points", points_},
                   {"points_done", points_done_},
                   {"points_per_second", has_pace ? Json(rate) : Json()},
                   {"seconds_left", has_pace ? Json(static_cast<double>(points_ - points_done_) / rate) : Json()},
                   {"peak_bytes", peak_ ? Json(*peak_) : Json()},
                   {"memory", job_.memory > 0 ? Json(job_.memory) : Json()},
                   {"broken", broken_files()},
                   {"each", each}};
    return all.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  }

  /// The layer of --tiles.
  [[nodiscard]] std::string layer() const {
    const PlacedFile points(job_.folder / "points");
    std::vector<TileState> states;
    for (std::size_t k = 0; k < tiles_.size(); ++k) {
      const TileAtHand& tile = tiles_[k];
      TileState state;
      state.square = square_of(points, job_.tiles[k]);
      state.index = k, state.state = word_of(tile.state);
      state.points_a = job_.tiles[k].square.points[0], state.points_b = job_.tiles[k].square.points[1];
      if (tile.took) state.seconds = tile.took->seconds, state.peak_bytes = tile.took->peak_bytes;
      state.why = tile.why;
      states.push_back(std::move(state));
    }
    return tile_states_geojson(states, job_.frame, crs());
  }
  [[nodiscard]] const std::string& crs() const { return job_.scan[job_.scan[0].crs.empty() ? 1 : 0].crs; }

 private:
  void add(std::size_t k) {
    TileAtHand tile;
    const std::uint64_t points = job_.tiles[k].square.all();
    points_ += points;
    if (job_.is_done(k)) {
      tile.state = State::done;
      tile.took = read_record(job_, k);
      points_done_ += points;
    } else if (std::ifstream failed(job_.tile_file(k, "failed")); std::getline(failed, tile.why)) {
      tile.state = State::failed;
    }
    if (tile.took) {
      points_timed_ += points, seconds_ += tile.took->seconds;
      if (const auto peak = tile.took->peak_bytes) peak_ = std::max(peak_.value_or(0), *peak);
    }
    tiles_.push_back(std::move(tile));
  }

  [[nodiscard]] std::size_t count(State state) const {
    return static_cast<std::size_t>(
        std::count_if(tiles_.begin(), tiles_.end(), [&](const TileAtHand& tile) { return tile.state == state; }));
  }

  [[nodiscard]] Json json_of(std::size_t k) const {
    const TileAtHand& tile = tiles_[k];
    const TileSquare& square = job_.tiles[k].square;
    const auto of_run = [&](auto&& value) { return tile.took ? Json(value(*tile.took)) : Json(); };
    return {{"index", k},
            {"state", word_of(tile.state)},
            {"points", square.all()},
            {"points_a", square.points[0]},
            {"points_b", square.points[1]},
            {"seconds", of_run([](const TileRecord& r) { return r.seconds; })},
            {"cpu_seconds", of_run([](const TileRecord& r) { return r.cpu_seconds; })},
            {"peak_bytes", of_run([](const TileRecord& r) { return r.peak_bytes ? Json(*r.peak_bytes) : Json(); })},
            {"threads", of_run([](const TileRecord& r) { return r.threads; })},
            {"host", of_run([](const TileRecord& r) { return r.host; })},
            {"ended", of_run([](const TileRecord& r) { return r.ended; })},
            {"why", tile.why.empty() ? Json() : Json(for_shell(tile.why))}};
  }

  [[nodiscard]] Json broken_files() const {
    Json all = Json::array();
    for (std::size_t k = 0; k < 2; ++k)
      for (const BrokenFile& file : job_.scan[k].broken)
        all.push_back({{"scan", k == 0 ? "A" : "B"}, {"path", file.path}, {"why", for_shell(file.why)}});
    return all;
  }

  /// Clipped to the box of the points.
  [[nodiscard]] Box2 square_of(const PlacedFile& points, const JobTile& tile) const {
    const std::vector<PointRun>& runs = tile.runs[tile.runs[0].empty() ? 1 : 0];
    const Point3 in_it = read_runs(points, {{runs.front().first, 1}}).front();
    const OpenBox square = curve_square(job_.frame.curve, {in_it.x, in_it.y}, tile.square.level);
    const Box3& box = job_.frame.box;
    return {{std::max(square.low.x, box.min.x), std::max(square.low.y, box.min.y)},
            {std::min(square.high.x, box.max.x), std::min(square.high.y, box.max.y)}};
  }

  const Job& job_;
  std::vector<TileAtHand> tiles_;
  std::uint64_t points_ = 0, points_done_ = 0;
  std::uint64_t points_timed_ = 0;  // of the tiles of which it is known how long they took
  double seconds_ = 0;
  std::optional<std::uint64_t> peak_;
};

VectorFormat format_of(const std::string& path) {
  const std::string ending = fs::path(path).extension().string();
  for (const VectorFormat format : {VectorFormat::geojson, VectorFormat::gpkg, VectorFormat::fgb})
    if (ending == std::string(".") + ending_of(format)) return format;
  throw UsageError(fmt::format("--tiles {}: its ending says how it is written: .geojson, .gpkg or .fgb", path));
}

void write_layer(const JobStatus& status, const Job& job, const std::string& path) {
  const VectorFormat format = format_of(path);
  if (job.frame.rotation != Frame{}.rotation)
    throw UsageError("--tiles: it is in x and y, so it goes with jobs of --direction z alone");
  need_vector_writer(format, path);
  write_vectors(path, status.layer(), format, status.crs());
  const fs::path style = fs::path(path).replace_extension(".qml");
  if (!fs::exists(style)) write_text_atomically(style.string(), tile_states_style());  // one may have been changed
}

}  // namespace

int tile_status(const Arguments& arguments) {
  std::string folder, json, layer;
  RunOptions options;
  Command command("tile status",
                  "What of a job is done, what failed and why, how fast it goes, and the memory it takes.\n",
                  step_codes);
  command.positional("JOB", folder, "Folder of the job");
  command.heading("Output");
  command.option("--json", "FILE", json, "The state of every tile as JSON to FILE; - prints it, and nothing else")
      .check(not_empty());
  command
      .option(
          "--tiles", "FILE", layer,
          "The tiles as polygons, with their state: FILE.geojson, FILE.gpkg or FILE.fgb, and a style for QGIS beside "
          "it unless there is one")
      .check(not_empty());
  add_run_options(command, options);
  if (!command.parse(arguments)) return 0;
  Run run(options);
  const Job job = read_job(folder, run.context());
  const JobStatus status(job);
  if (!layer.empty()) write_layer(status, job, layer);
  if (!json.empty()) write_json(json, status.json(), run);
  if (json != "-") run.show(status.text());
  return 0;
}

}  // namespace isopach::cli
