// COPC files for tests: the chunks are compressed by LASzip, the octree and its index are made here, apart from the
// code that reads them.
#pragma once
#include <array>
#include <string>

namespace isopach::test {

struct CopcShape {
  std::array<double, 3> centre{};  ///< of the cube of the octree
  double half = 1;                 ///< half of its side
  int levels = 4;                  ///< of nodes, the root's included
  bool pages = false;              ///< nodes below level 1 in pages of their own
};

/// Writes the points of a plain LAS 1.4 file (point format 6 or higher, all points in the cube) as COPC. A point goes
/// to a level by its number, and to the node of it that holds the place it may have had before it was rounded to the
/// scale. Chunks are in no order of the octree. No table of chunks is written: isopach reads none of layered chunks.
void write_copc(const std::string& las, const std::string& copc, const CopcShape& shape);

}  // namespace isopach::test
