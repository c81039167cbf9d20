// What the command line says, for those who must know which files a run reads.
#pragma once
#include <string>
#include <vector>

namespace isopach::cli {

/// All values of the command line and of its --config, but that of --output: names of the files that a run may read.
[[nodiscard]] const std::vector<std::string>& input_words();

/// The words beside the options, in their order: the scans of a run. Empty until the command line is read.
[[nodiscard]] const std::vector<std::string>& scan_words();

/// A message about the scans says which ones: where it names none of them and no file of the run, they stand before it.
[[nodiscard]] std::string naming_a_scan(const std::string& message);

}  // namespace isopach::cli
