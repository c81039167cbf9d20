// isopach tile script
#include <fmt/format.h>

#include <filesystem>

#include "cli/command.hpp"
#include "cli/tile_job.hpp"
#include "cli/tile_steps.hpp"
#include "isopach/base/error.hpp"

namespace isopach::cli {
namespace fs = std::filesystem;

int tile_script(const Arguments& arguments) {
  enum class Engine { slurm, parallel, snakemake };
  std::string folder, program = "isopach";
  Engine engine = Engine::slurm;
  std::size_t each = 1;
  RunOptions options;
  Command command("tile script",
                  "Prints a script that runs the tiles of a job by an engine that people have; nothing is submitted.\n",
                  step_codes);
  command.positional("JOB", folder, "Folder of the job, which all machines see under this path");
  command.heading("Script");
  command.choice<Engine>("--engine", engine,
                         {{"slurm", Engine::slurm}, {"parallel", Engine::parallel}, {"snakemake", Engine::snakemake}},
                         "slurm: an array of jobs, for sbatch; parallel: GNU parallel, for sh; snakemake: a Snakefile");
  command.option("--tiles-each", "N", each, "Tiles of one job of the engine").check(whole_number(1)).show_default();
  command.option("--program", "PATH", program, "The isopach program on the machines that run it")
      .check(not_empty())
      .show_default();
  add_run_options(command, options);
  if (!command.parse(arguments)) return 0;
  Run run(options);
  const Job job = read_job(folder, run.context());
  const std::size_t n = job.tiles.size(), jobs = (n + each - 1) / each;
  const std::string path = fs::absolute(folder).lexically_normal().string();
  if (path.find_first_of("'\n\r") != std::string::npos || program.find_first_of("'\n\r") != std::string::npos)
    throw UsageError("JOB: a script cannot quote a path with an apostrophe or a line break: rename the folder");
  const std::string index = "$(( i * " + std::to_string(each) + " ))-$(( last < " + std::to_string(n) +
                            " - 1 ? last : " + std::to_string(n) + " - 1 ))";
  const std::string body = fmt::format("last=$(( (i + 1) * {} - 1 ))\nexec '{}' tile run '{}' --index \"{}\" --quiet\n",
                                       each, program, path, index);
  switch (engine) {
    case Engine::slurm:
      run.print(
          fmt::format("#!/bin/sh\n#SBATCH --job-name=isopach\n#SBATCH --array=0-{}\n#SBATCH --cpus-per-task=2\n"
                      "# then: isopach tile reduce '{}' -o RESULT\ni=$SLURM_ARRAY_TASK_ID\n{}",
                      jobs - 1, path, body));
      break;
    case Engine::parallel:
      run.print(
          fmt::format("#!/bin/sh\nset -eu\nseq 0 {} | parallel --halt soon,fail=1 \"'{}' tile run '{}' --index "
                      "{{}} --quiet --threads 1\"\n'{}' tile reduce '{}' -o \"${{1:-result}}\"\n",
                      n - 1, program, path, program, path));
      break;
    case Engine::snakemake:
      run.print(fmt::format(
          "TILES = [f\"{{k:06d}}\" for k in range({})]\nJOB = '{}'\n\n"
          "rule result:\n    input: expand(JOB + \"/tiles/{{k}}.part\", k=TILES)\n    output: \"result/result.json\"\n"
          "    shell: \"'{}' tile reduce '{}' -o result\"\n\n"
          "rule tile:\n    output: JOB + \"/tiles/{{k}}.part\"\n    threads: 2\n"
          "    shell: \"'{}' tile run '{}' --index $((10#{{wildcards.k}})) --quiet --threads {{threads}}\"\n",
          n, path, program, path, program, path));
      break;
  }
  return 0;
}

}  // namespace isopach::cli
