#include "isopach/base/memory.hpp"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>

namespace isopach {
namespace {

/// The largest resident size since the mark was put back, or since the process began.
std::optional<std::uint64_t> resident_mark() {
  std::ifstream status("/proc/self/status");
  for (std::string name; status >> name; status.ignore(std::numeric_limits<std::streamsize>::max(), '\n')) {
    std::uint64_t kib = 0;
    if (name == "VmHWM:" && status >> kib) return kib * 1024;
  }
  return std::nullopt;
}

bool put_mark_back() {
  std::ofstream marks("/proc/self/clear_refs");
  return static_cast<bool>(marks << '5' << std::flush);
}

}  // namespace

std::uint64_t usable_memory() {
  std::uint64_t least = std::numeric_limits<std::uint64_t>::max();
  const long pages = ::sysconf(_SC_PHYS_PAGES), page = ::sysconf(_SC_PAGESIZE);
  if (pages > 0 && page > 0) least = static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page);
  for (const char* path : {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"}) {
    std::uint64_t group = 0;  // "max" where there is none
    if (std::ifstream(path) >> group) least = std::min(least, group);
  }
  rlimit address{};
  if (::getrlimit(RLIMIT_AS, &address) == 0 && address.rlim_cur != RLIM_INFINITY)
    least = std::min<std::uint64_t>(least, address.rlim_cur);
  return least;
}

PeakMemory::PeakMemory() {
  if (!put_mark_back()) before_ = resident_mark();
}

std::optional<std::uint64_t> PeakMemory::bytes() const {
  const std::optional<std::uint64_t> mark = resident_mark();
  return mark && before_ && *mark <= *before_ ? std::nullopt : mark;
}

std::string bytes_in_words(std::uint64_t bytes) {
  const auto value = static_cast<double>(bytes);
  if (value >= 1e9) return fmt::format("{:.3g} GB", value / 1e9);
  return value >= 1e6 ? fmt::format("{:.3g} MB", value / 1e6) : fmt::format("{} bytes", bytes);
}

}  // namespace isopach
