// What a coordinate reference system says about units, read by GDAL. Used by the readers and writers of formats that
// carry one (LAS, rasters).
#pragma once
#include <span>
#include <string>

#include "isopach/cloud/cloud.hpp"

class OGRSpatialReference;

namespace isopach {

/// "EPSG:n", "EPSG:n+m" (horizontal and vertical) or WKT, with the units of the axes; "unknown" where the CRS is
/// silent: a projected CRS says nothing of heights, so its vertical unit is unknown, never assumed to be the horizontal
/// one.
struct Crs {
  std::string name;
  std::string unit = "unknown";
  std::string vertical_unit = "unknown";
};

[[nodiscard]] Crs describe_crs(const OGRSpatialReference& reference);

/// From well-known text. An empty name means that the text was not understood.
[[nodiscard]] Crs crs_from_wkt(const std::string& wkt);

/// From ESRI's well-known text, as in a .prj file.
[[nodiscard]] Crs crs_from_esri(const std::string& wkt);

/// From the three GeoTIFF records of a LAS file (34735, 34736, 34737), as raw little-endian bytes.
[[nodiscard]] Crs crs_from_geokeys(std::span<const char> directory, std::span<const char> doubles,
                                   std::span<const char> ascii);

/// Well-known text (version 1, as LAS wants it) of a Cloud's crs; empty if there is none or it is not understood.
[[nodiscard]] std::string wkt_of_crs(const std::string& crs);

/// Name of the unit that is `metres` long: "m", "mm", "ft", "us-ft", else "unknown".
[[nodiscard]] std::string unit_of_length(double metres);

/// Do two texts, as in Cloud::crs, name one horizontal system? True also if one of them is empty or not understood:
/// nothing is known against it.
[[nodiscard]] bool same_crs(const std::string& one, const std::string& other);

/// A CRS in a few words for a message: its name or code, not all of its well-known text.
[[nodiscard]] std::string short_name(const std::string& crs);

void set_crs(Cloud& cloud, const Crs& crs);

/// While it lives, GDAL prints nothing in this thread; the first failure it would have printed is kept, as one line.
class GdalMessages {
 public:
  GdalMessages();
  ~GdalMessages();
  GdalMessages(const GdalMessages&) = delete;
  GdalMessages& operator=(const GdalMessages&) = delete;
  [[nodiscard]] const std::string& failure() const { return failure_; }
  void keep(int severity, const char* message);

 private:
  std::string failure_;
};

/// While it lives, GDAL reports in this thread the vertical part of a GeoTIFF's CRS also where GeoTIFF 1.0 is in use.
class ReportVerticalCrs {
 public:
  ReportVerticalCrs();
  ~ReportVerticalCrs();
  ReportVerticalCrs(const ReportVerticalCrs&) = delete;
  ReportVerticalCrs& operator=(const ReportVerticalCrs&) = delete;
};

}  // namespace isopach
