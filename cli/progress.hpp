// Progress on stderr: a bar for people, a line of JSON per step for programs, stage times for --verbose.
#pragma once
#include <chrono>
#include <string>
#include <string_view>

namespace isopach::cli {

enum class ProgressKind { automatic, bar, json, none };

class Progress {
 public:
  Progress(ProgressKind kind, bool verbose);
  ~Progress() { clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void step(std::string_view stage, double fraction);
  void clear();  ///< takes the bar away, so that a message can stand on a line of its own

 private:
  using Clock = std::chrono::steady_clock;
  void draw(double fraction);

  bool bar_, json_, verbose_, patient_;
  Clock::time_point start_ = Clock::now(), drawn_ = start_;
  std::string stage_;
  std::size_t width_ = 0;  ///< of what stands on the terminal's line
};

}  // namespace isopach::cli
