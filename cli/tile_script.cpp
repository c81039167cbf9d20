// isopach tile script
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "cli/command.hpp"
#include "cli/tile_job.hpp"
#include "cli/tile_steps.hpp"
#include "isopach/base/error.hpp"

namespace isopach::cli {
namespace fs = std::filesystem;
namespace {

enum class Engine { slurm, parallel, snakemake };

/// What a script is made of.
struct ScriptPlan {
  std::string folder, program;
  std::size_t tiles = 0, each = 0, at_once = 0;  ///< each, at_once: 0 where they were not given
  std::uint64_t megabytes = 0;                   ///< of one tile

  [[nodiscard]] std::size_t last_call() const { return (tiles - 1) / each; }
};

/// A word as sh takes it.
std::string quoted(const std::string& word) {
  constexpr const char* plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./:=@%+,-";
  if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

/// A string of Python.
std::string literal(const std::string& text) {
  std::string all = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') all += '\\';
    all += c;
  }
  return all + "\"";
}

/// The index of tiles that call i does, as sh works it out.
std::string index_of_call(const ScriptPlan& plan, const std::string& i) {
  if (plan.each == 1) return i;
  const std::string last = fmt::format("({} + 1) * {} - 1", i, plan.each);
  return fmt::format("$(( {} * {} ))-$(( {} < {} ? {} : {} ))", i, plan.each, last, plan.tiles - 1, last,
                     plan.tiles - 1);
}

std::string reduce_line(const ScriptPlan& plan) {
  return fmt::format("{} tile reduce {}", quoted(plan.program), quoted(plan.folder));
}

/// The largest array that clusters take without being told otherwise (MaxArraySize).
constexpr std::size_t most_tasks = 1000;

std::string slurm_script(const ScriptPlan& plan) {
  return fmt::format(
      "#!/bin/sh\n"
      "#SBATCH --job-name=isopach\n"
      "#SBATCH --array=0-{}{}\n"
      "#SBATCH --cpus-per-task=2\n"
      "#SBATCH --mem={}M\n"
      "# Submitted again, it does what is missing. Tiles, and then the result:\n"
      "# sbatch --mem=0 --kill-on-invalid-dep=yes --dependency=afterok:$(sbatch --parsable job.sh) --wrap={}\n"
      "i=$SLURM_ARRAY_TASK_ID\n"
      "exec {} tile run {} --index \"{}\" --threads \"${{SLURM_CPUS_PER_TASK:-2}}\"\n",
      plan.last_call(), plan.at_once > 0 ? fmt::format("%{}", plan.at_once) : "", plan.megabytes,
      quoted(reduce_line(plan) + " -o result"), quoted(plan.program), quoted(plan.folder), index_of_call(plan, "$i"));
}

/// The path and the program are handed over in the environment: parallel replaces braces within its command.
std::string parallel_script(const ScriptPlan& plan) {
  return fmt::format(
      "#!/bin/sh\n"
      "# Run again, it does what is missing. The folder of the result: sh job.sh RESULT\n"
      "set -eu\n"
      "export PARALLEL_SHELL=/bin/sh isopach={} job={}\n"
      "seq 0 {} | parallel --retries 3 --memfree {}M{} 'i={{}}; exec \"$isopach\" tile run \"$job\" --index \"{}\" "
      "--quiet --threads 1'\n"
      "{} -o \"${{1:-result}}\"\n",
      quoted(plan.program), quoted(plan.folder), plan.last_call(), plan.megabytes,
      plan.at_once > 0 ? fmt::format(" --jobs {}", plan.at_once) : "", index_of_call(plan, "$i"), reduce_line(plan));
}

std::string snakemake_script(const ScriptPlan& plan) {
  return fmt::format(
      "# snakemake --cores N does what is missing; after a kill with --rerun-incomplete\n"
      "JOB = {}\n"
      "TILES = [f\"{{k:06d}}\" for k in range({})]\n\n"
      "rule result:\n"
      "    input: expand(JOB + \"/tiles/{{k}}.part\", k=TILES)\n"
      "    output: \"result/result.json\"\n"
      "    shell: {}\n\n"
      "rule tile:\n"
      "    output: JOB + \"/tiles/{{k}}.part\"\n"
      "    params: index=lambda wildcards: int(wildcards.k)\n"
      "    threads: 2\n"
      "    retries: 2\n"
      "    resources: mem_mb={}\n"
      "    shell: {}\n",
      literal(plan.folder), plan.tiles, literal(reduce_line(plan) + " -o result"), plan.megabytes,
      literal(fmt::format("{} tile run {} --index {{params.index}} --quiet --threads {{threads}}", quoted(plan.program),
                          quoted(plan.folder))));
}

void check_words(const ScriptPlan& plan, Engine engine) {
  const bool makes_rules = engine == Engine::snakemake;
  for (const std::string& word : {plan.folder, plan.program})
    if (word.find_first_of(makes_rules ? "\n\r{}" : "\n\r") != std::string::npos)
      throw UsageError(fmt::format("{}: a script cannot hold a path with {}: rename it", word,
                                   makes_rules ? "braces or a line break" : "a line break"));
  if (makes_rules && plan.each > 0)
    throw UsageError("--tiles-each: snakemake groups its jobs itself: leave it out, and see its --group-components");
  if (makes_rules && plan.at_once > 0)
    throw UsageError("--at-once: snakemake is told by its own --cores or --jobs: leave it out");
}

/// What the largest tile takes, and a quarter more.
std::uint64_t megabytes_of_tile(const Job& job) {
  std::uint64_t largest = 0;
  for (const JobTile& tile : job.tiles) largest = std::max(largest, tile.square.all());
  return memory_of_tile(largest) / 4 * 5 / (1024 * 1024) + 1;
}

}  // namespace

int tile_script(const Arguments& arguments) {
  ScriptPlan plan;
  std::string folder;
  plan.program = "isopach";
  Engine engine = Engine::slurm;
  RunOptions options;
  Command command("tile script",
                  "Prints a script that runs the tiles of a job by an engine that people have; nothing is submitted.\n",
                  step_codes);
  command.positional("JOB", folder, "Folder of the job, which all machines see under this path");
  command.heading("Script");
  command.choice<Engine>("--engine", engine,
                         {{"slurm", Engine::slurm}, {"parallel", Engine::parallel}, {"snakemake", Engine::snakemake}},
                         "slurm: an array of jobs, for sbatch; parallel: GNU parallel, for sh; snakemake: a Snakefile");
  command
      .option("--tiles-each", "N", plan.each,
              "Tiles that one job of slurm or parallel does, one after the other (default 1; slurm: as few as make "
              "1000 jobs at most)")
      .check(whole_number(1));
  command
      .option("--at-once", "N", plan.at_once,
              "Most jobs of slurm or parallel at a time (default: what the cluster allows; parallel: one a core)")
      .check(whole_number(1));
  command.option("--program", "PATH", plan.program, "The isopach program on the machines that run it")
      .check(not_empty())
      .show_default();
  add_run_options(command, options);
  if (!command.parse(arguments)) return 0;
  Run run(options);
  const Job job = read_job(folder, run.context());
  plan.folder = fs::absolute(folder).lexically_normal().string();
  plan.tiles = job.tiles.size(), plan.megabytes = megabytes_of_tile(job);
  check_words(plan, engine);
  if (plan.each == 0) plan.each = engine == Engine::slurm ? (plan.tiles + most_tasks - 1) / most_tasks : 1;
  run.print(engine == Engine::slurm      ? slurm_script(plan)
            : engine == Engine::parallel ? parallel_script(plan)
                                         : snakemake_script(plan));
  return 0;
}

}  // namespace isopach::cli
