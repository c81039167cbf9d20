// The points of a job: sorted into squares of the curve, in one file.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "isopach/base/array.hpp"
#include "isopach/geom/curve.hpp"
#include "isopach/geom/vec.hpp"
#include "isopach/io/output_file.hpp"
#include "isopach/tiles/squares.hpp"

namespace isopach::cli {

/// Points of one tile or a part of one, one behind the other in JOB/points.
struct PointRun {
  std::uint64_t first = 0, count = 0;
};

/// A file that is read at places. InputError, with a remedy, where that fails.
class PlacedFile {
 public:
  explicit PlacedFile(const std::filesystem::path& path);
  ~PlacedFile();
  PlacedFile(const PlacedFile&) = delete;
  PlacedFile& operator=(const PlacedFile&) = delete;

  void read(void* to, std::size_t size, std::uint64_t at) const;

 private:
  [[noreturn]] void fail() const;
  std::string path_;
  int descriptor_;
};

[[nodiscard]] Array<Point3> read_runs(const PlacedFile& file, const std::vector<PointRun>& runs);

/// Points sorted into squares of the curve as they come, in one file: in runs, which are the longer the more points may
/// wait in memory, however many squares there are.
class Spill {
 public:
  struct Bucket {
    TileSquare square;
    std::array<std::vector<PointRun>, 2> runs;  ///< of A, of B
  };

  /// `waiting`: points that are held in memory at a time, about.
  Spill(const std::filesystem::path& path, const CurveBox& box, std::size_t waiting)
      : file_(path.string()), box_(box), most_waiting_(waiting) {}

  /// Points that lie in the square at hand, into the squares `deeper` levels below it.
  void begin(const TileSquare& within, int deeper);
  void add(std::size_t scan, std::span<const Point3> points);
  /// The squares that hold points.
  [[nodiscard]] std::vector<Bucket> end();
  void close() { file_.close(); }

 private:
  void write(std::size_t scan, std::size_t bucket);

  OutputFile file_;
  const CurveBox& box_;
  std::size_t most_waiting_;
  int level_ = 0;
  std::uint64_t first_ = 0, written_ = 0;
  std::size_t run_ = 0;
  std::vector<Bucket> buckets_;
  std::array<std::vector<std::vector<Point3>>, 2> waiting_;
};

}  // namespace isopach::cli
