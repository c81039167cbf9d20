#include "cli/progress.hpp"

#include <fmt/core.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "cli/terminal.hpp"

namespace isopach::cli {
namespace {

constexpr double patience_s = 1.0;  ///< shorter runs show no bar: it would only flash
constexpr double redraw_s = 0.1;
constexpr int bar_cells = 30;

double seconds(std::chrono::steady_clock::duration d) { return std::chrono::duration<double>(d).count(); }

/// Of the terminal; many where none tells.
std::size_t columns() {
  winsize size{};
  return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1 ? size.ws_col : 1000;
}

}  // namespace

Progress::Progress(ProgressKind kind, bool verbose)
    : bar_(kind == ProgressKind::bar || (kind == ProgressKind::automatic && isatty(STDERR_FILENO) != 0)),
      json_(kind == ProgressKind::json),
      verbose_(verbose),
      patient_(kind == ProgressKind::automatic) {}

void Progress::step(std::string_view stage, double fraction) {
  fraction = std::clamp(fraction, 0.0, 1.0);
  const bool new_stage = stage != stage_;
  stage_ = stage;
  const Clock::time_point now = Clock::now();
  if (verbose_ && new_stage) {
    clear();
    write_message(fmt::format("{:9.3f} s  {}\n", seconds(now - start_), stage));
  }
  if (json_) {
    const nlohmann::ordered_json line{{"stage", stage_}, {"fraction", fraction}};
    write_message(line.dump() + "\n");
  }
  const bool due = new_stage || seconds(now - drawn_) >= redraw_s;
  if (bar_ && due && (!patient_ || seconds(now - start_) >= patience_s)) {
    drawn_ = now;
    draw(fraction);
  }
}

void Progress::draw(double fraction) {
  const auto full = static_cast<std::size_t>(std::lround(fraction * bar_cells));
  std::string line = fmt::format("[{}{}] {:3.0f} %  {}", std::string(full, '#'), std::string(bar_cells - full, '.'),
                                 100 * fraction, stage_);
  line.resize(std::min(line.size(), columns() - 1));  // a longer one would leave its beginning on the line above
  const std::size_t width = line.size();
  if (width < width_) line.append(width_ - width, ' ');
  write_message("\r" + line);
  width_ = width;
}

void Progress::clear() {
  if (width_ == 0) return;
  write_message("\r" + std::string(width_, ' ') + "\r");
  width_ = 0;
}

}  // namespace isopach::cli
