// Scenes of `accuracy` and `scanners`: one object, and scanners whose errors are known. mm.
//
// The object is a board of 120 by 80 with broad hills (tens of mm) and a texture of waves of 6 to 8 mm, 0.1 mm RMS, and
// nothing between. A scanner measures at independent, uniform places; heights are the mean over a disc, or those of a
// point; bias and noise are along the view. Tests: tests/simulate/scanned_object_test.cpp
#pragma once
#include "isopach/cloud/cloud.hpp"
#include "isopach/geom/rigid.hpp"

namespace isopach {

inline constexpr double object_width = 120, object_depth = 80;

/// Height of the object.
[[nodiscard]] double object_height(double x, double y);

struct ObjectScanner {
  std::size_t points = 20000;
  double noise = 0, bias = 0;  ///< standard deviation, offset of all heights
  double spot = 0;             ///< diameter of the disc that a height is the mean over; 0: a point
  double reach = 1;            ///< share of the object, from x = 0 on, that is scanned
  double scale = 1;            ///< lengths of the scan over those of the object
  bool moved = false;          ///< turned by 2.3° and shifted by some centimetres, instead of in place
};

/// T_object_scan: takes a scan back to where the object is, scale included.
[[nodiscard]] Pose object_pose(const ObjectScanner& scanner);

/// Scan number `scan` of the object: scans with different numbers share no random numbers. The same bits for any number
/// of threads. Cost O(points), 96 times as much with a spot. Errors: UsageError for fewer than 100 points or more than
/// max_nodes, or a number that makes no sense.
[[nodiscard]] Cloud scan_object(const ObjectScanner& scanner, std::uint64_t seed, std::uint64_t scan);

}  // namespace isopach
