// What the run of a tile took: JOB/tiles/K.json, beside the part and no part of the result.
#pragma once
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cli/tile_job.hpp"
#include "isopach/base/memory.hpp"

namespace isopach::cli {

struct TileRecord {
  double seconds = 0, cpu_seconds = 0;      ///< by the clock; of all threads
  std::optional<std::uint64_t> peak_bytes;  ///< largest resident size of the process; nothing where it is not known
  int threads = 0;
  std::string host, ended;  ///< ended: 2026-01-01T12:00:00Z
};

/// Made when the run of a tile begins. One at a time.
class TileWatch {
 public:
  TileWatch();
  [[nodiscard]] TileRecord record() const;

 private:
  std::chrono::steady_clock::time_point start_;
  double cpu_seconds_;
  PeakMemory peak_;
};

void write_record(const Job& job, std::size_t k, const TileRecord& record);
/// Nothing where there is none of this job: the tile is done all the same.
[[nodiscard]] std::optional<TileRecord> read_record(const Job& job, std::size_t k);

/// Says while tiles are run which one is at hand, how fast they go and how long the rest takes.
class TileProgress {
 public:
  /// `tiles`: those to be run. The context must live.
  TileProgress(const Job& job, const std::vector<std::size_t>& tiles, const Context& context);
  void begin(std::size_t k);
  /// Also of one that failed.
  void end(std::size_t k);

 private:
  const Job& job_;
  const Context& context_;
  std::chrono::steady_clock::time_point start_;
  std::size_t tiles_, begun_ = 0;
  std::uint64_t points_ = 0, points_done_ = 0;
};

/// "12 min left, 85000 points/s"; empty before anything is known.
[[nodiscard]] std::string pace_in_words(std::uint64_t points_done, double seconds, std::uint64_t points_left);

}  // namespace isopach::cli
