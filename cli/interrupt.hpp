// Ctrl-C: the first one asks the run to stop, so that it can remove what it has half written; a second one kills.
#pragma once
#include <atomic>

namespace isopach::cli {

void catch_interrupts();

/// Set by SIGINT and SIGTERM. A signal handler can reach nothing but a global: this is the only one of the program.
[[nodiscard]] const std::atomic<bool>& interrupted();

}  // namespace isopach::cli
