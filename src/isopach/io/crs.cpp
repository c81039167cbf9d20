#include "isopach/io/crs.hpp"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <fmt/format.h>
#include <gdal_frmts.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>
#include <proj.h>

#include <cmath>
#include <cstdint>
#include <cstring>

namespace isopach {
namespace {

void CPL_STDCALL keep_message(CPLErr severity, CPLErrorNum, const char* message) {
  static_cast<GdalMessages*>(CPLGetErrorHandlerUserData())->keep(severity, message);
}

std::string epsg_code(const OGRSpatialReference& reference, const char* node) {
  const char* const authority = reference.GetAuthorityName(node);
  const char* const code = reference.GetAuthorityCode(node);
  return authority != nullptr && code != nullptr && std::strcmp(authority, "EPSG") == 0 ? code : "";
}

std::string wkt_of(const OGRSpatialReference& reference, const char* format) {
  const std::string option = std::string("FORMAT=") + format;
  const char* const options[] = {option.c_str(), nullptr};
  char* text = nullptr;
  const bool good = reference.exportToWkt(&text, options) == OGRERR_NONE;
  std::string wkt = good && text != nullptr ? text : "";
  CPLFree(text);
  return wkt;
}

// Code of a system that is the registry's but for the missing code; a look at the names, without a search.
std::string guessed_code(const OGRSpatialReference& reference) {
  if (!reference.IsProjected() || reference.IsCompound()) return {};
  OGRSpatialReference guess(reference);
  guess.AutoIdentifyEPSG();
  return epsg_code(guess, nullptr);
}

std::string name_of(const OGRSpatialReference& reference) {
  if (const std::string whole = epsg_code(reference, nullptr); !whole.empty()) return "EPSG:" + whole;
  if (reference.IsCompound()) {
    const std::string horizontal = epsg_code(reference, reference.IsProjected() ? "PROJCS" : "GEOGCS");
    const std::string vertical = epsg_code(reference, "VERT_CS");
    // A vertical part that only names its unit adds nothing: the unit has a place of its own.
    if (!horizontal.empty()) return "EPSG:" + horizontal + (vertical.empty() ? "" : "+" + vertical);
  }
  if (const std::string code = guessed_code(reference); !code.empty()) return "EPSG:" + code;
  const std::string wkt = wkt_of(reference, "DEFAULT");
  return wkt.empty() ? wkt_of(reference, "WKT2_2019") : wkt;
}

std::string horizontal_unit(const OGRSpatialReference& reference) {
  if (reference.IsGeographic() && !reference.IsProjected())
    return std::fabs(reference.GetAngularUnits() - M_PI / 180) < 1e-12 ? "deg" : "unknown";
  if (reference.IsProjected() || reference.IsLocal() || reference.IsGeocentric())
    return unit_of_length(reference.GetLinearUnits());
  return "unknown";
}

std::string vertical_unit(const OGRSpatialReference& reference) {
  if (reference.IsGeocentric()) return unit_of_length(reference.GetLinearUnits());
  if (reference.IsVertical()) return unit_of_length(reference.GetTargetLinearUnits("VERT_CS"));
  if (reference.GetAxesCount() != 3) return "unknown";
  double metres = 0;
  reference.GetAxis(nullptr, 2, nullptr, &metres);
  return unit_of_length(metres);
}

// A GeoTIFF of one pixel that carries the keys: GDAL reads keys only from a file, and its reading of them (user-defined
// systems, old codes) is not worth repeating.
class TinyTiff {
 public:
  TinyTiff(std::span<const char> directory, std::span<const char> doubles, std::span<const char> ascii) {
    const std::uint32_t tags = 9 + (doubles.empty() ? 0 : 1) + (ascii.empty() ? 0 : 1);
    tail_ = 8 + 2 + 12 * tags + 4;
    put("II*\0", 4);
    put32(8);
    put16(static_cast<std::uint16_t>(tags));
    for (const auto& [tag, value] :
         {std::pair{256, 1}, {257, 1}, {258, 8}, {259, 1}, {262, 1}, {273, 4}, {278, 1}, {279, 1}})
      entry(tag, 4, 1, static_cast<std::uint32_t>(value));
    block(34735, 3, 2, directory);
    if (!doubles.empty()) block(34736, 12, 8, doubles);
    if (!ascii.empty()) block(34737, 2, 1, ascii);
    put32(0);
    bytes_ += late_;
  }
  [[nodiscard]] std::string& bytes() { return bytes_; }

 private:
  void put(const void* data, std::size_t size) { bytes_.append(static_cast<const char*>(data), size); }
  void put16(std::uint16_t value) { put(&value, 2); }
  void put32(std::uint32_t value) { put(&value, 4); }
  void entry(int tag, std::uint16_t type, std::uint32_t count, std::uint32_t value) {
    put16(static_cast<std::uint16_t>(tag));
    put16(type);
    put32(count);
    put32(value);
  }
  void block(int tag, std::uint16_t type, std::size_t width, std::span<const char> data) {
    const std::size_t count = data.size() / width;
    if (count * width <= 4) {
      std::uint32_t value = 0;
      std::memcpy(&value, data.data(), count * width);
      entry(tag, type, static_cast<std::uint32_t>(count), value);
      return;
    }
    entry(tag, type, static_cast<std::uint32_t>(count), tail_ + static_cast<std::uint32_t>(late_.size()));
    late_.append(data.data(), count * width);
    late_.resize((late_.size() + 7) / 8 * 8);
  }

  std::string bytes_, late_;
  std::uint32_t tail_ = 0;
};

}  // namespace

std::string unit_of_length(double metres) {
  const auto is = [metres](double length) { return std::fabs(metres - length) < 1e-9 * length; };
  if (is(1)) return "m";
  if (is(0.001)) return "mm";
  if (is(0.3048)) return "ft";
  if (is(1200.0 / 3937.0)) return "us-ft";
  return "unknown";
}

Crs describe_crs(const OGRSpatialReference& reference) {
  if (reference.IsEmpty()) return {};
  return {name_of(reference), horizontal_unit(reference), vertical_unit(reference)};
}

Crs crs_from_wkt(const std::string& wkt) {
  const GdalMessages messages;
  OGRSpatialReference reference;
  if (reference.importFromWkt(wkt.c_str()) != OGRERR_NONE) return {};
  return describe_crs(reference);
}

Crs crs_from_esri(const std::string& wkt) {
  const GdalMessages messages;
  OGRSpatialReference reference;
  CPLStringList lines;
  lines.AddString(wkt.c_str());
  if (reference.importFromESRI(lines.List()) != OGRERR_NONE) return {};
  // ESRI's text has no codes. A search of the registry takes a good part of a second, so only here.
  if (OGRSpatialReference* const match = reference.FindBestMatch()) {
    reference = *match;
    match->Release();
  }
  return describe_crs(reference);
}

Crs crs_from_geokeys(std::span<const char> directory, std::span<const char> doubles, std::span<const char> ascii) {
  const GdalMessages messages;
  const ReportVerticalCrs vertical;
  GDALRegister_GTiff();
  TinyTiff tiff(directory, doubles, ascii);
  // The address of the bytes makes the name unique among threads.
  const std::string name = fmt::format("/vsimem/isopach-geokeys-{}.tif", fmt::ptr(tiff.bytes().data()));
  VSIFCloseL(
      VSIFileFromMemBuffer(name.c_str(), reinterpret_cast<GByte*>(tiff.bytes().data()), tiff.bytes().size(), FALSE));
  Crs crs;
  const char* const drivers[] = {"GTiff", nullptr};
  if (GDALDataset* data = GDALDataset::Open(name.c_str(), GDAL_OF_RASTER, drivers)) {
    if (const OGRSpatialReference* reference = data->GetSpatialRef()) crs = describe_crs(*reference);
    GDALClose(data);
  }
  VSIUnlink(name.c_str());
  return crs;
}

std::string wkt_of_crs(const std::string& crs) {
  if (crs.empty()) return {};
  const GdalMessages messages;
  OGRSpatialReference reference;
  const char* const options[] = {"ALLOW_NETWORK_ACCESS=NO", "ALLOW_FILE_ACCESS=NO", nullptr};
  if (reference.SetFromUserInput(crs.c_str(), options) != OGRERR_NONE) return {};
  return wkt_of(reference, "WKT1_GDAL");
}

namespace {

bool understand(const std::string& crs, OGRSpatialReference& reference) {
  const char* const options[] = {"ALLOW_NETWORK_ACCESS=NO", "ALLOW_FILE_ACCESS=NO", nullptr};
  return !crs.empty() && reference.SetFromUserInput(crs.c_str(), options) == OGRERR_NONE;
}

}  // namespace

bool same_crs(const std::string& one, const std::string& other) {
  if (one == other) return true;
  const GdalMessages messages;
  OGRSpatialReference a, b;
  if (!understand(one, a) || !understand(other, b)) return true;
  for (OGRSpatialReference* r : {&a, &b})
    if (r->IsCompound() != 0) r->StripVertical();
  const char* const options[] = {"IGNORE_DATA_AXIS_TO_SRS_AXIS_MAPPING=YES",
                                 "CRITERION=EQUIVALENT_EXCEPT_AXIS_ORDER_GEOGCRS", nullptr};
  return a.IsSame(&b, options) != 0;
}

std::string short_name(const std::string& crs) {
  if (crs.size() < 40) return crs;
  const GdalMessages messages;
  OGRSpatialReference reference;
  const char* const name = understand(crs, reference) ? reference.GetName() : nullptr;
  return name != nullptr ? name : "another one";
}

void set_crs(Cloud& cloud, const Crs& crs) {
  cloud.crs = crs.name;
  cloud.unit = crs.unit;
  cloud.vertical_unit = crs.vertical_unit;
}

GdalMessages::GdalMessages() {
  CPLPushErrorHandlerEx(keep_message, this);
  // GDAL's reader of GeoTIFF keys asks PROJ through a context of its own, which would print of units it does not know.
  proj_log_level(nullptr, PJ_LOG_NONE);
}
GdalMessages::~GdalMessages() { CPLPopErrorHandler(); }

void GdalMessages::keep(int severity, const char* message) {
  if (severity < CE_Failure || !failure_.empty()) return;
  failure_ = message;
  for (char& c : failure_)
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
}

ReportVerticalCrs::ReportVerticalCrs() { CPLSetThreadLocalConfigOption("GTIFF_REPORT_COMPD_CS", "YES"); }
ReportVerticalCrs::~ReportVerticalCrs() { CPLSetThreadLocalConfigOption("GTIFF_REPORT_COMPD_CS", nullptr); }

}  // namespace isopach
