#include "cli/application.hpp"

#include "cli/session.hpp"
#include "isopach/base/error.hpp"

namespace isopach::cli {

void add_application_output(Command& command, Delivery& output, const std::string& files) {
  command.heading("Output");
  command
      .option("-o,--output", "DIR", output.output,
              "Folder for result.json, report.html, " + files + "; made if it is not there")
      .check(not_empty());
  command.option("--json", "FILE", output.json, "The result as JSON to FILE; - prints it, and nothing else, on stdout")
      .check(not_empty());
  add_map_options(command, output, "Title of map and report");
}

std::unique_ptr<OutputFolder> open_folder(const Delivery& output) {
  if (output.svg && output.output.empty() && session().shell)
    throw UsageError("--svg: acts with --output alone, which names the folder to write into");
  return output.output.empty() ? nullptr : std::make_unique<OutputFolder>(output.output);
}

void deliver_application(const Delivered& result, Timing& timing, const std::vector<std::string>& warnings,
                         const Delivery& output, OutputFolder* folder, Run& run) {
  Stopwatch watch;
  std::string map;
  if (folder != nullptr) map = result.write(*folder);
  set_write_time(timing, watch.lap());
  std::string json;
  if (folder != nullptr) {
    const std::string report = folder->path("report.html"), file = folder->path("result.json");
    json = result.json(folder->names());
    write_text_atomically(file, json);
    result.page(report, map, json);
    run.context().check();
    folder->commit();
  } else if (!output.json.empty()) {
    json = result.json({});
  }
  if (!output.json.empty()) write_json(output.json, json, run);
  if (output.json != "-") {
    run.show(result.text());
  } else {
    for (const std::string& warning : warnings) run.warn(warning);
  }
}

}  // namespace isopach::cli
