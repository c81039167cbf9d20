// What the verbs of the applications write alike: result.json, report.html, a map, and a text on stdout.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cli/output.hpp"

namespace isopach::cli {

struct ApplicationOutput {
  std::string output, json;
  MapOptions map;
};

/// --output, --json and the look of the map. `files`: what is written beside result.json and report.html.
void add_application_output(Command& command, ApplicationOutput& output, const std::string& files);

/// Nothing where no folder is asked for.
[[nodiscard]] std::unique_ptr<OutputFolder> open_folder(const ApplicationOutput& output);

/// How a result is written.
struct Delivered {
  std::function<std::string(OutputFolder&)> write;  ///< the files but result and report; the path of the map
  std::function<std::string(const std::vector<std::string>& outputs)> json;
  std::function<void(const std::string& path, const std::string& map, const std::string& json)> page;
  std::function<std::string()> text;
};
void deliver_application(const Delivered& result, Timing& timing, const std::vector<std::string>& warnings,
                         const ApplicationOutput& output, OutputFolder* folder, double read_s, Run& run);

}  // namespace isopach::cli
