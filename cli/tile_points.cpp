#include "cli/tile_points.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"

namespace isopach::cli {

PlacedFile::PlacedFile(const std::filesystem::path& path)
    : path_(path.string()), descriptor_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
  if (descriptor_ < 0) fail();
}

PlacedFile::~PlacedFile() { ::close(descriptor_); }

void PlacedFile::read(void* to, std::size_t size, std::uint64_t at) const {
  auto* bytes = static_cast<char*>(to);
  while (size > 0) {
    const ssize_t got = ::pread(descriptor_, bytes, size, static_cast<off_t>(at));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail();
    if (got == 0) throw InputError(path_ + ": it is cut short: plan the job again (isopach tile plan)");
    bytes += got, at += static_cast<std::uint64_t>(got), size -= static_cast<std::size_t>(got);
  }
}

void PlacedFile::fail() const {
  throw InputError(
      fmt::format("{}: cannot be read ({}): plan the job again (isopach tile plan)", path_, std::strerror(errno)));
}

Array<Point3> read_runs(const PlacedFile& file, const std::vector<PointRun>& runs) {
  std::uint64_t count = 0;
  for (const PointRun& run : runs) count += run.count;
  Array<Point3> points(static_cast<std::size_t>(count));
  std::size_t at = 0;
  for (const PointRun& run : runs) {
    file.read(points.data() + at, static_cast<std::size_t>(run.count) * sizeof(Point3), run.first * sizeof(Point3));
    at += static_cast<std::size_t>(run.count);
  }
  return points;
}

void Spill::begin(const TileSquare& within, int deeper) {
  level_ = within.level + deeper;
  first_ = level_ == 0 ? 0 : within.prefix << (2 * deeper);
  buckets_.assign(std::size_t{1} << (2 * deeper), {});
  for (auto& of_scan : waiting_) of_scan.assign(buckets_.size(), {});
  run_ = std::clamp<std::size_t>(most_waiting_ / (2 * buckets_.size()), 64, 65536);
}

void Spill::add(std::size_t scan, std::span<const Point3> points) {
  Array<std::uint64_t> keys(points.size());
  for_each_index(points.size(), [&](std::size_t i) { keys[i] = curve_key(box_, {points[i].x, points[i].y}); });
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t bucket = level_ == 0 ? 0 : static_cast<std::size_t>((keys[i] >> (64 - 2 * level_)) - first_);
    std::vector<Point3>& waiting = waiting_[scan][bucket];
    waiting.push_back(points[i]);
    if (waiting.size() == run_) write(scan, bucket);
  }
}

std::vector<Spill::Bucket> Spill::end() {
  std::vector<Bucket> found;
  for (std::size_t b = 0; b < buckets_.size(); ++b) {
    for (std::size_t scan = 0; scan < 2; ++scan) write(scan, b);
    Bucket& bucket = buckets_[b];
    bucket.square.level = level_, bucket.square.prefix = first_ + b;
    for (std::size_t scan = 0; scan < 2; ++scan)
      for (const PointRun& run : bucket.runs[scan]) bucket.square.points[scan] += run.count;
    if (bucket.square.all() > 0) found.push_back(std::move(bucket));
  }
  buckets_.clear();
  return found;
}

void Spill::write(std::size_t scan, std::size_t bucket) {
  std::vector<Point3>& waiting = waiting_[scan][bucket];
  if (waiting.empty()) return;
  file_.write({reinterpret_cast<const char*>(waiting.data()), waiting.size() * sizeof(Point3)});
  buckets_[bucket].runs[scan].push_back({written_, waiting.size()});
  written_ += waiting.size();
  waiting.clear();
}

}  // namespace isopach::cli
