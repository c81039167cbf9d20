// Other programs, timed from outside.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace isopach::bench {

struct ProcessRun {
  bool ok = false;
  double seconds = 0;      ///< wall
  double cpu_seconds = 0;  ///< user and system, all threads
  std::size_t peak_bytes = 0;
  std::string output;
};

/// Runs a program (looked for in PATH) to its end, without the memory settings of the benchmark. To be called while
/// this process is small: the kernel counts its size in the child's peak.
[[nodiscard]] ProcessRun run_process(const std::vector<std::string>& words);

/// Bytes from /proc/self/status, e.g. of "VmRSS:" (now) or "VmHWM:" (most so far); 0 where it cannot be read.
[[nodiscard]] std::size_t own_memory(const std::string& field);

}  // namespace isopach::bench
