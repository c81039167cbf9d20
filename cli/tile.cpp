// isopach tile plan | run | status | reduce | script
#include <fmt/core.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <memory>
#include <utility>

#include "cli/answer.hpp"
#include "cli/command.hpp"
#include "cli/compare_request.hpp"
#include "cli/output.hpp"
#include "cli/session.hpp"
#include "cli/tile_fields.hpp"
#include "cli/tile_job.hpp"
#include "cli/tile_record.hpp"
#include "cli/tile_steps.hpp"
#include "cli/verbs.hpp"
#include "isopach/base/error.hpp"
#include "isopach/base/memory.hpp"
#include "isopach/base/option_key.hpp"
#include "isopach/io/output_file.hpp"
#include "isopach/report/layers.hpp"
#include "isopach/report/page/text.hpp"
#include "isopach/tiles/solve.hpp"

namespace isopach::cli {
namespace {

constexpr const char* overview =
    "A comparison in tiles: of scans that do not fit into memory, on one machine or on many. The result is that of\n"
    "compare on all points, to the last bit, whatever the tiles.\n"
    "\n"
    "Usage: isopach tile <step> ...\n"
    "\n"
    "Steps:\n"
    "  plan A B -o JOB   look at both scans, sort their points into tiles\n"
    "  run JOB           do tiles; several runs may work on one job at a time\n"
    "  status JOB        what is done, what failed and why\n"
    "  reduce JOB        join the tiles to the result\n"
    "  script JOB        a script that runs the tiles on a cluster\n"
    "\n"
    "Options beside those of every run; plan has all of compare, too:\n"
    "  -o --output DIR       plan: the folder of the job; reduce: that of result.json\n"
    "  --max-memory SIZE     plan: memory that a tile may take, e.g. 4G\n"
    "  --tile-points N       plan: most points of a tile instead\n"
    "  --index K[-L][,...]   run: these tiles alone\n"
    "  --missing             run: all that are not done\n"
    "  --json FILE           status, reduce: as JSON; - prints it\n"
    "  --tiles FILE          status: the tiles as polygons for maps\n"
    "  --allow-missing       reduce: compare the points of the tiles that are done\n"
    "  --raster STEP         reduce: also difference.tif\n"
    "  --points              reduce: also the differences at the points, as LAZ\n"
    "  --engine NAME         script: slurm, parallel or snakemake\n"
    "  --tiles-each N        script: tiles of one job of the engine\n"
    "  --at-once N           script: most jobs of the engine at a time\n"
    "  --program PATH        script: the isopach program on the machines that run it\n"
    "\n"
    "Examples:\n"
    "  isopach tile plan 2012 '2019/*.laz' -o job --max-memory 8G --class 2\n"
    "  isopach tile run job && isopach tile reduce job -o result\n"
    "  isopach tile script job --engine slurm > job.sh && sbatch job.sh\n"
    "\n"
    "isopach tile <step> --help explains one step. On one machine, compare --max-memory SIZE does all of them.\n";

/// Of a job, as its words say. They were checked when it was planned.
struct JobOptions {
  CompareRequest request;
  std::vector<Tolerance> tolerances;

  explicit JobOptions(const Job& job) {
    Command command("tile", "", "");
    add_compare_options(command, request);
    if (!command.parse(job.words)) throw UsageError("the job was planned with --help");
    tolerances = settle_options(request);
    request.options.pose = job.pose;
    request.options.keep_points = false;
  }
};

// --- plan ------------------------------------------------------------------------------------------------------------

void warn_of_broken_files(const Job& job, Run& run) {
  for (const JobScan& scan : job.scan) {
    constexpr std::size_t most = 5;
    for (std::size_t i = 0; i < std::min(most, scan.broken.size()); ++i) run.warn("left out: " + scan.broken[i].why);
    if (!scan.broken.empty())
      run.warn(
          fmt::format("{}: {} of {} files cannot be read and are left out of the job: repair them and plan it again",
                      scan.name, scan.broken.size(), scan.broken.size() + scan.files.size()));
  }
}

int plan(const Arguments& arguments) {
  CompareRequest request;
  std::string folder;
  JobLimits limits;
  Command command(
      "tile plan",
      "Looks at both scans twice, block by block, and sorts their points into tiles: squares of a quadtree\n"
      "that hold few enough points each.\nA and B: files, folders, patterns, lists, catalogues.\n",
      step_codes);
  command.positional("A", request.path_a, "Reference scan, or the one before: a file or a set of files");
  command.positional("B", request.path_b, "Compared scan, or the one after");
  command.heading("Job");
  command.option("-o,--output", "JOB", folder, "Folder of the job, new or empty; its points take 24 bytes each there")
      .check(not_empty())
      .required(true);
  command.option_with(
      "--max-memory", "SIZE", [&](const std::string& text) { limits.memory = parse_size(text, "--max-memory"); },
      "Memory that the run of one tile may take, e.g. 4G; tiles are as large as it allows (default half of the "
      "memory)");
  command
      .option("--tile-points", "N", limits.tile_points,
              "Most points of a tile, of both scans together, instead of what the memory allows")
      .check(whole_number(1));
  add_compare_options(command, request);
  add_run_options(command, request.run);
  if (!command.parse(arguments)) return 0;
  static_cast<void>(settle_options(request));
  check_tiled(request.options);
  refuse_in_tiles(request);
  if (!request.pose_path.empty()) request.options.pose = read_pose(request.pose_path);
  Run run(request.run);
  // What says what is compared, without what says where and how large.
  const Arguments words = command.given_options(
      {"output", "max-memory", "tile-points", "pose", "threads", "progress", "max-input", "quiet", "verbose"});
  const Job job = plan_job(request.path_a, request.path_b, request.options, words, limits, BrokenFiles::left_out,
                           folder, run.context());
  warn_of_broken_files(job, run);
  std::uint64_t largest = 0, all = 0;
  for (const JobTile& tile : job.tiles) largest = std::max(largest, tile.square.all()), all += tile.square.all();
  if (largest > most_points(limits))
    run.warn(fmt::format("{} points lie on one spot that no tile can part: they are one tile", largest));
  run.show(fmt::format("{} tiles of {} points, at most {} each, in {}\nnow: isopach tile run {}\n", job.tiles.size(),
                       all, largest, folder, folder));
  return 0;
}

// --- run -------------------------------------------------------------------------------------------------------------

std::size_t number_of(const std::string& text, std::string_view part, std::size_t tiles) {
  std::size_t k = 0;
  const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), k);
  if (error != std::errc() || end != part.data() + part.size() || k >= tiles)
    throw UsageError(fmt::format("--index {}: give numbers of tiles from 0 to {}, e.g. 0-99 or 3,7", text, tiles - 1));
  return k;
}

std::vector<std::size_t> tiles_of(const std::string& text, std::size_t tiles) {
  std::vector<std::size_t> all;
  for (std::string_view rest = text; !rest.empty();) {
    const std::string_view item = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(rest.size(), item.size() + 1));
    const std::size_t dash = item.find('-');
    const std::size_t first = number_of(text, item.substr(0, dash), tiles);
    const std::size_t last = dash == std::string_view::npos ? first : number_of(text, item.substr(dash + 1), tiles);
    for (std::size_t k = first; k <= last; ++k) all.push_back(k);
  }
  return all;
}

void warn_of_memory(const Job& job, std::size_t k, Run& run) {
  const std::optional<TileRecord> took = read_record(job, k);
  if (job.memory == 0 || !took || took->peak_bytes.value_or(0) <= job.memory) return;
  run.warn(
      fmt::format("tile {} took {} of memory, more than the {} of @max-memory: where there is no more, plan the job "
                  "with less",
                  k, bytes_in_words(*took->peak_bytes), bytes_in_words(job.memory)));
}

/// A disk that takes no more fails every tile.
bool ends_all_tiles(const std::exception& e) {
  const auto* error = dynamic_cast<const Error*>(&e);
  return error != nullptr && error->code() == ExitCode::internal;
}

/// Does the tiles that are named and not done; gives how many failed.
std::size_t do_tiles(const Job& job, const std::vector<std::size_t>& tiles, const CompareOptions& options, Run& run) {
  std::size_t failed = 0;
  TileProgress progress(job, tiles, run.context());
  Context quiet = run.context();
  quiet.progress = nullptr;
  for (const std::size_t k : tiles) {
    progress.begin(k);
    try {
      run_tile(job, k, options, quiet);
      warn_of_memory(job, k, run);
    } catch (const Interrupted&) {
      throw;
    } catch (const std::exception& e) {
      if (tiles.size() == 1 || ends_all_tiles(e)) throw;
      ++failed;
      run.say(fmt::format("tile {}: {}", k, for_shell(e.what())));
    }
    progress.end(k);
  }
  return failed;
}

int run_tiles(const Arguments& arguments) {
  std::string folder, index;
  bool missing = false;
  RunOptions options;
  Command command(
      "tile run",
      "Does tiles of a job, those that are not done: all of them, or those that are named. May be killed and\n"
      "run again at any time; several may run at once, on one machine or on many that share the folder.\n",
      step_codes);
  command.positional("JOB", folder, "Folder of the job");
  command.heading("Tiles");
  command.option("--index", "K[-L][,…]", index, "These tiles alone, e.g. 7 or 0-99 (default: all)").check(not_empty());
  command.flag("--missing", missing, "All that are not done (as without --index)");
  add_run_options(command, options);
  if (!command.parse(arguments)) return 0;
  if (missing && !index.empty()) throw UsageError("--missing and --index: give one of them");
  Run run(options);
  const Job job = read_job(folder, run.context());
  check_inputs(job);
  const JobOptions asked(job);
  std::vector<std::size_t> tiles;
  if (!index.empty()) {
    tiles = tiles_of(index, job.tiles.size());
  } else {
    sweep_unfinished_files((job.folder / "tiles").string(), "");
    for (std::size_t k = 0; k < job.tiles.size(); ++k)
      if (!job.is_done(k)) tiles.push_back(k);
  }
  const std::size_t failed = do_tiles(job, tiles, asked.request.options, run);
  if (failed > 0)
    throw InputError(fmt::format("{}: {} of {} tiles failed: isopach tile status {} says why", folder, failed,
                                 tiles.size(), folder));
  run.show(fmt::format("{} tiles done\n", tiles.size()));
  return 0;
}

// --- reduce ----------------------------------------------------------------------------------------------------------

int reduce(const Arguments& arguments) {
  std::string folder;
  bool allow_missing = false, points = false;
  Delivery delivery;
  RunOptions options;
  Command command("tile reduce", "Joins the tiles of a job to the result of the whole.\n", step_codes);
  command.positional("JOB", folder, "Folder of the job");
  command.heading("Output");
  add_result_options(command, delivery,
                     "Folder for result.json, histogram.csv, report.html, difference.png, of changes changes.csv and "
                     "changes.geojson; made if it is not there");
  add_page_options(command, delivery, "Title of map and report; without it the names of the scans");
  command
      .option("--raster", "STEP", delivery.raster,
              "Also difference.tif: a cloud-optimised GeoTIFF of d, coverage and both heights; each pixel is the exact "
              "mean over what was "
              "measured of it. Side of the pixels, in the unit of x and y")
      .check(positive());
  command.flag(
      "--points", points,
      "Also points_a_K.laz and points_b_K.laz of every tile K: the points that were compared, with dz_signed as "
      "extra bytes");
  command.flag("--allow-missing", allow_missing,
               "Compare the points of the tiles that are done, although others are missing; the result says so");
  add_run_options(command, options);
  if (!command.parse(arguments)) return 0;
  if (points && delivery.output.empty())
    throw UsageError("--points: acts with --output alone, which names the folder to write into");
  Run run(options);
  const Job job = read_job(folder, run.context());
  check_inputs(job);
  sweep_unfinished_files((job.folder / "tiles").string(), "");
  JobOptions asked(job);
  check_layers(delivery, asked.request.options.project);
  std::unique_ptr<OutputFolder> output;
  if (!delivery.output.empty()) output = std::make_unique<OutputFolder>(delivery.output);
  auto answer = std::make_unique<TiledAnswer>();
  answer->tolerances = std::move(asked.tolerances);
  JoinedNodes nodes;
  answer->comparison = reduce_job(job, asked.request.options, allow_missing, answer->look(delivery, run.context()), run,
                                  points ? &nodes : nullptr);
  if (points) write_point_fields(job, asked.request.options, nodes, *output, run.context());
  return finish(std::move(answer), delivery, output.get(), run);
}

}  // namespace

int run_tile_verb(const Arguments& arguments) {
  static const std::vector<std::pair<std::string, int (*)(const Arguments&)>> steps{
      {"plan", plan}, {"run", run_tiles}, {"status", tile_status}, {"reduce", reduce}, {"script", tile_script}};
  if (arguments.empty())
    throw UsageError("tile: give a step: plan, run, status, reduce or script (isopach tile --help)");
  const std::string& word = arguments.front();
  if (word == "--help" || word == "-h") {
    std::fputs(overview, stdout);
    return 0;
  }
  std::vector<std::string> names;
  for (const auto& [name, step] : steps) {
    if (name == word) return step({arguments.begin() + 1, arguments.end()});
    names.push_back(name);
  }
  throw UsageError(
      fmt::format("tile: unknown step '{}'{}; isopach tile --help lists the steps", word, did_you_mean(word, names)));
}

}  // namespace isopach::cli
