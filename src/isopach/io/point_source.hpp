// The points of one file from first to last, as many at a time as the caller wants. read_cloud and for_each_block are
// both made of it.
#pragma once
#include <cstddef>
#include <limits>
#include <memory>
#include <string>

#include "isopach/io/byte_view.hpp"
#include "isopach/io/point_blocks.hpp"
#include "isopach/io/read.hpp"

namespace isopach {

inline constexpr std::size_t all_points = std::numeric_limits<std::size_t>::max();

class PointSource {
 public:
  PointSource() = default;
  PointSource(const PointSource&) = delete;
  PointSource& operator=(const PointSource&) = delete;
  virtual ~PointSource() = default;

  /// Sets what the file says before its points: format, unit, CRS, and its attributes, which hold nothing yet.
  virtual void begin(Cloud& cloud) = 0;
  /// Points that the file has for sure, for which memory may be taken at once.
  [[nodiscard]] virtual std::size_t sure() const { return 0; }
  /// Appends the next points, `most` of them at most. False, and nothing is appended, if there are none left.
  virtual bool append(Cloud& cloud, std::size_t most, const Context& context) = 0;
  /// Adds notes, and what else is known after the last point.
  virtual void end(Cloud& cloud) = 0;

  /// From now on points outside of the box may be left out. Before the first append.
  virtual void leave_out_beyond(const PlanBox&) {}
  /// Count and bounds, where they stand before the points.
  virtual void describe(FileSummary&) const {}
};

/// Everything that `source` has.
[[nodiscard]] Cloud read_all(PointSource& source, const Context& context);

/// Of LAS, LAZ and COPC files. `path` is the name in messages; the bytes must outlive the source. Throws as read_las.
[[nodiscard]] std::unique_ptr<PointSource> las_source(const ByteView& bytes, const std::string& path,
                                                      const ReadOptions& options);
/// Of PLY files; null if the points cannot be read without what stands before or among them, or with faces.
[[nodiscard]] std::unique_ptr<PointSource> ply_source(const ByteView& bytes, const std::string& path,
                                                      const ReadOptions& options);
/// Of text; null if it is PTX, whose scans are moved when they are whole.
[[nodiscard]] std::unique_ptr<PointSource> text_source(const ByteView& bytes, const std::string& path,
                                                       const ReadOptions& options);

}  // namespace isopach
