// read_cloud: any supported file, chosen by content first and extension second.
// Formats: XYZ/CSV/TXT/PTS/PTX text, PLY, LAS/LAZ/COPC, OBJ, STL, PCD, GeoTIFF and other GDAL rasters, ESRI ASCII grid.
#pragma once
#include <string>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud.hpp"

namespace isopach {

struct ReadOptions {
  /// Attributes to keep. Default none but "classification": a comparison needs no others and memory is not free.
  bool all_attributes = false;
  std::vector<std::string> attributes = {"classification"};
  bool faces = false;  ///< keep faces (default: points only)
};

/// Reads one file. Throws InputError (exit 3) with one line that names the file, the cause and the remedy. Every count
/// in the file is checked against its size before memory is taken.
[[nodiscard]] Cloud read_cloud(const std::string& path, const ReadOptions& options, const Context& context);

}  // namespace isopach
