// Ctrl-C: the first one asks the run to stop, so that it can remove what it has half written; a second one kills, and
// the next run into the same place removes it.
#pragma once
#include <atomic>

namespace isopach::cli {

/// Also ends an abort of a library in one line with exit code 1, and turns SIGPIPE and SIGXFSZ into failures of the
/// write that would have raised them.
void catch_interrupts();

/// The end of a program whose standard output has lost its reader, as shells know it; nothing is said.
void end_by_broken_pipe();

/// Set by SIGINT, SIGTERM and SIGHUP (the terminal is gone). A signal handler can reach nothing but a global.
[[nodiscard]] const std::atomic<bool>& interrupted();

}  // namespace isopach::cli
