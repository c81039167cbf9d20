// Fuzz target: any bytes as the file of --config, of a command with every kind of option there is: those of scans
// and of a run, numbers within bounds, texts that are parsed. Nothing that an option names is opened but to ask whether
// it is there.
#include "cli/command.hpp"
#include "cli/parse.hpp"
#include "cli/scans.hpp"
#include "isopach/io/input_file.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/memory_file.hpp"

namespace {

using namespace isopach;

struct Request {
  std::string a, pose, unit;
  CompareOptions compare;
  std::vector<std::string> fail_above, include;
  cli::RunOptions run;
};

void add_options(cli::Command& command, Request& request) {
  CompareOptions& o = request.compare;
  command.positional("A", request.a, "a scan");
  cli::add_scan_options(command, o.project, request.pose, request.unit, "direction", "duplicates");
  cli::add_border_options(command, o);
  command.parsed(
      "--sigma1", "S", o.uncertainty.sigma1,
      +[](const std::string& text) { return cli::parse_sigma(text, "--sigma1"); }, "noise");
  command.parsed(
      "--weight", "W", o.weight, +[](const std::string& text) { return cli::parse_weight(text); }, "weight");
  command.option("--lod", "L", o.uncertainty.lod, "level").check(cli::positive());
  command.option("--confidence", "P", o.uncertainty.confidence, "share").check(cli::share());
  command.option("--include", "FILE", request.include, "polygons");
  command.option("--fail-above", "STATISTIC=LIMIT", request.fail_above, "limits");
  cli::add_run_options(command, request.run);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const fuzz::ExactBytes copy(data, size);
  static fuzz::MemoryFile file;
  fuzz::only_errors([&] {
    Request request;
    cli::Command command("compare", "", "");
    add_options(command, request);
    if (!command.parse({"a.ply", "--config", file.with(copy.bytes())})) return;
    for (const std::string& text : request.fail_above)
      for (const cli::Tolerance& t : cli::parse_tolerances(text)) fuzz::require_finite("limit", {t.limit});
    fuzz::require(request.compare.uncertainty.lod >= 0, "a level of detection is no less than 0");
  });
  set_max_input(0);
  return 0;
}
