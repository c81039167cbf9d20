// What the command line says, for those who must know which files a run reads.
#pragma once
#include <string>
#include <vector>

namespace isopach::cli {

/// All values of the command line and of its --config, but that of --output: names of the files that a run may read.
[[nodiscard]] const std::vector<std::string>& input_words();

/// The words beside the options, in their order: the scans of a run. Empty until the command line is read.
[[nodiscard]] const std::vector<std::string>& scan_words();

}  // namespace isopach::cli
