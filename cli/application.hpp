// What the verbs of the applications write alike: result.json, report.html, a map, and a text on stdout.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cli/output.hpp"

namespace isopach::cli {

/// --output, --json and the look of the map. `files`: what is written beside result.json and report.html.
void add_application_output(Command& command, Delivery& output, const std::string& files);

/// Nothing where no folder is asked for.
[[nodiscard]] std::unique_ptr<OutputFolder> open_folder(const Delivery& output);

/// How a result is written.
struct Delivered {
  std::function<std::string(OutputFolder&)> write;  ///< the files but result and report; the path of the map
  std::function<std::string(const std::vector<std::string>& outputs)> json;
  std::function<void(const std::string& path, const std::string& map, const std::string& json)> page;
  std::function<std::string()> text;
};
void deliver_application(const Delivered& result, Timing& timing, const std::vector<std::string>& warnings,
                         const Delivery& output, OutputFolder* folder, Run& run);

}  // namespace isopach::cli
