// isopach tile status
#include <fmt/core.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "cli/command.hpp"
#include "cli/output.hpp"
#include "cli/tile_job.hpp"
#include "cli/tile_steps.hpp"
#include "isopach/base/option_key.hpp"
#include "isopach/io/input_file.hpp"

namespace isopach::cli {
namespace {
namespace fs = std::filesystem;

std::string first_line_of(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return {};
  const Context nobody_stops;
  InputFile file(path.string(), nobody_stops);
  const std::span<const char> bytes = file.bytes();
  const std::string text(bytes.begin(), bytes.end());
  return text.substr(0, text.find('\n'));
}

}  // namespace

int tile_status(const Arguments& arguments) {
  std::string folder, json;
  RunOptions options;
  Command command("tile status", "What of a job is done, and what failed.\n", step_codes);
  command.positional("JOB", folder, "Folder of the job");
  command.heading("Output");
  command.option("--json", "FILE", json, "The state of every tile as JSON to FILE; - prints it, and nothing else")
      .check(not_empty());
  add_run_options(command, options);
  if (!command.parse(arguments)) return 0;
  Run run(options);
  const Job job = read_job(folder, run.context());
  std::uint64_t points = 0, points_done = 0;
  std::size_t done = 0;
  std::string failures;
  nlohmann::ordered_json tiles = nlohmann::ordered_json::array();
  for (std::size_t k = 0; k < job.tiles.size(); ++k) {
    const bool is_done = job.is_done(k);
    const std::string why = is_done ? "" : first_line_of(job.tile_file(k, "failed"));
    const std::uint64_t count = job.tiles[k].square.all();
    points += count, points_done += is_done ? count : 0, done += is_done ? 1 : 0;
    if (!why.empty()) failures += fmt::format("tile {} failed: {}\n", k, for_shell(why));
    tiles.push_back({{"index", k},
                     {"state", is_done       ? "done"
                               : why.empty() ? "missing"
                                             : "failed"},
                     {"points", count},
                     {"why", why.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(for_shell(why))}});
  }
  if (!json.empty()) {
    const nlohmann::ordered_json all{{"schema", "isopach.tile-status/1"},
                                     {"tiles", job.tiles.size()},
                                     {"done", done},
                                     {"points", points},
                                     {"points_done", points_done},
                                     {"each", tiles}};
    write_json(json, all.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n", run);
  }
  if (json != "-")
    run.show(fmt::format("{} of {} tiles done, {} of {} points\n{}{}", done, job.tiles.size(), points_done, points,
                         failures,
                         done == job.tiles.size() ? fmt::format("now: isopach tile reduce {}\n", folder)
                                                  : fmt::format("now: isopach tile run {} --missing\n", folder)));
  return 0;
}

}  // namespace isopach::cli
