// The points of a file a block at a time, all of them or those in a box: for scans that do not fit into memory. The
// same code decodes them for read_cloud.
//
// LAS, LAZ, COPC, text of points (not PTX) and PLY without lists among its vertices are read piece by piece: a block,
// the piece of the file it comes from and, of compressed files, a batch of at most 128 MB are in memory, whatever the
// file holds; @max-input does not bound them. Everything else (rasters, OBJ, STL, PCD, PTX, other PLY, pipes) is read
// at once by read_cloud and handed on in blocks: who reads such a file more than once spills its blocks.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud.hpp"
#include "isopach/io/read.hpp"

namespace isopach {

/// Points with min_x <= x < max_x and min_y <= y < max_y, compared as doubles: boxes side by side share no point and
/// leave none out. Infinite sides are allowed. A point whose x or y is NaN lies in no box.
struct PlanBox {
  double min_x = 0, min_y = 0, max_x = 0, max_y = 0;

  [[nodiscard]] bool has(const Point3& p) const { return p.x >= min_x && p.x < max_x && p.y >= min_y && p.y < max_y; }
};

/// Points in a block, where the caller does not say.
inline constexpr std::size_t points_in_block = std::size_t{1} << 20;

/// Takes a block of at least one point: with the path, format, unit, CRS and attributes of the file, without faces and
/// notes. It is valid during the call alone. Called on the thread that calls for_each_block, within run_with_threads.
using TakeBlock = std::function<void(const Cloud& block)>;

/// Calls `take` for every block of at most `most` points of a file, in the order of the file. The blocks, one behind
/// the other, are the points and attributes of read_cloud(path, options) without faces, bit by bit. Gives what else
/// read_cloud gives: unit, CRS, notes, `nodata`, the grid of a raster, names of attributes; no points. Throws as
/// read_cloud does, a damaged file maybe after blocks were taken; what `take` throws goes through.
/// Cost: as read_cloud, without the arrays. Oracle: PointBlocks.* (tests/io/point_blocks_test.cpp).
Cloud for_each_block(const std::string& path, const ReadOptions& options, const Context& context, const TakeBlock& take,
                     std::size_t most = points_in_block);

/// The same of the points in `box` alone, still in the order of the file. Of a COPC file only the chunks whose cube of
/// the octree meets the box are read and decompressed: cubes, not the bounds in the header, and grown by a step of the
/// scale, since points are rounded after they were sorted in. Where its index does not fit its points all are read. Of
/// any other file every point is decoded. Notes that count points (withheld ones) are of those that were read. Oracle:
/// a full read, cropped (PointBlocks.Box*).
Cloud for_each_block_in(const std::string& path, const PlanBox& box, const ReadOptions& options, const Context& context,
                        const TakeBlock& take, std::size_t most = points_in_block);

/// What a file says of itself before its points.
struct FileSummary {
  struct Bounds {
    Point3 min, max;
  };
  std::string path, format;  ///< as in Cloud
  std::string unit = "unknown", vertical_unit = "unknown", crs;
  std::optional<std::uint64_t> points;  ///< LAS, LAZ, COPC, PLY; nothing where points would have to be read
  std::optional<Bounds> bounds;         ///< LAS, LAZ, COPC: as stated, which need not be true
  std::vector<std::string> attributes;  ///< that ReadOptions ask for and the file has
  std::uint64_t bytes = 0;              ///< size
  std::int64_t modified_ns = 0;         ///< time of the last change, since 1970
};

/// Of the first bytes of a file, for the formats that are read piece by piece; of all others path, format, size and
/// time alone are known. Throws as read_cloud does. Cost: a few reads, whatever the file holds.
[[nodiscard]] FileSummary summarise(const std::string& path, const ReadOptions& options, const Context& context);

}  // namespace isopach
