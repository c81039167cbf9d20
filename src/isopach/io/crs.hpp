// What a coordinate reference system says about units, read by GDAL. Used by the readers and writers of formats that
// carry one (LAS, rasters). What needs GDAL throws InputError where it cannot be loaded, or was left out of the build;
// `path` names the file in that message.
#pragma once
#include <span>
#include <string>

#include "isopach/cloud/cloud.hpp"

namespace isopach {

/// "EPSG:n", "EPSG:n+m" (horizontal and vertical) or WKT, with the units of the axes; "unknown" where the CRS is
/// silent: a projected CRS says nothing of heights, so its vertical unit is unknown, never assumed to be the horizontal
/// one.
struct Crs {
  std::string name;
  std::string unit = "unknown";
  std::string vertical_unit = "unknown";
};

/// From well-known text. An empty name means that the text was not understood.
[[nodiscard]] Crs crs_from_wkt(const std::string& wkt, const std::string& path);

/// From ESRI's well-known text, as in a .prj file.
[[nodiscard]] Crs crs_from_esri(const std::string& wkt, const std::string& path);

/// From the three GeoTIFF records of a LAS file (34735, 34736, 34737), as raw little-endian bytes.
[[nodiscard]] Crs crs_from_geokeys(std::span<const char> directory, std::span<const char> doubles,
                                   std::span<const char> ascii, const std::string& path);

/// Well-known text (version 1, as LAS wants it) of a Cloud's crs; empty if there is none or it is not understood.
[[nodiscard]] std::string wkt_of_crs(const std::string& crs, const std::string& path);

/// Name of the unit that is `metres` long: "m", "mm", "ft", "us-ft", else "unknown".
[[nodiscard]] std::string unit_of_length(double metres);

/// Do two texts, as in Cloud::crs, name one horizontal system? True also if one of them is empty or not understood:
/// nothing is known against it.
[[nodiscard]] bool same_crs(const std::string& one, const std::string& other);

/// A CRS in a few words for a message: its name or code, not all of its well-known text.
[[nodiscard]] std::string short_name(const std::string& crs);

void set_crs(Cloud& cloud, const Crs& crs);

}  // namespace isopach
