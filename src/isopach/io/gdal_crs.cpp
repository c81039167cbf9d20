// io/crs.hpp by GDAL.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>

#include "isopach/io/gdal.hpp"
#include "isopach/io/gdal_memory_file.hpp"

namespace isopach {
namespace {

using Handle = OGRSpatialReferenceH;

constexpr const char* reading = ": reading its coordinate reference system";

GdalReference new_reference() { return GdalReference(gdal().OSRNewSpatialReference(nullptr)); }

std::string epsg_code(Handle reference, const char* node) {
  const char* const authority = gdal().OSRGetAuthorityName(reference, node);
  const char* const code = gdal().OSRGetAuthorityCode(reference, node);
  return authority != nullptr && code != nullptr && std::strcmp(authority, "EPSG") == 0 ? code : "";
}

std::string wkt_of(Handle reference, const char* format) {
  const std::string option = std::string("FORMAT=") + format;
  const char* const options[] = {option.c_str(), nullptr};
  char* text = nullptr;
  const bool good = gdal().OSRExportToWktEx(reference, &text, options) == OGRERR_NONE;
  const GdalText owner(text);
  return good && text != nullptr ? text : "";
}

// Code of a system that is the registry's but for the missing code; a look at the names, without a search.
std::string guessed_code(Handle reference) {
  if (gdal().OSRIsProjected(reference) == 0 || gdal().OSRIsCompound(reference) != 0) return {};
  const GdalReference guess(gdal().OSRClone(reference));
  gdal().OSRAutoIdentifyEPSG(guess.get());
  return epsg_code(guess.get(), nullptr);
}

std::string name_of(Handle reference) {
  if (const std::string whole = epsg_code(reference, nullptr); !whole.empty()) return "EPSG:" + whole;
  if (gdal().OSRIsCompound(reference) != 0) {
    const std::string horizontal = epsg_code(reference, gdal().OSRIsProjected(reference) != 0 ? "PROJCS" : "GEOGCS");
    const std::string vertical = epsg_code(reference, "VERT_CS");
    // A vertical part that only names its unit adds nothing: the unit has a place of its own.
    if (!horizontal.empty()) return "EPSG:" + horizontal + (vertical.empty() ? "" : "+" + vertical);
  }
  if (const std::string code = guessed_code(reference); !code.empty()) return "EPSG:" + code;
  const std::string wkt = wkt_of(reference, "DEFAULT");
  return wkt.empty() ? wkt_of(reference, "WKT2_2019") : wkt;
}

std::string horizontal_unit(Handle reference) {
  const bool projected = gdal().OSRIsProjected(reference) != 0;
  if (gdal().OSRIsGeographic(reference) != 0 && !projected)
    return std::fabs(gdal().OSRGetAngularUnits(reference, nullptr) - M_PI / 180) < 1e-12 ? "deg" : "unknown";
  if (projected || gdal().OSRIsLocal(reference) != 0 || gdal().OSRIsGeocentric(reference) != 0)
    return unit_of_length(gdal().OSRGetLinearUnits(reference, nullptr));
  return "unknown";
}

// Unit of the third axis of a system that is not compound, in metres; 0 if there is none. GDAL's C interface tells
// units of axes in PROJJSON only, by name if they are the metre, else with their length.
double metres_of_third_axis(Handle reference) {
  char* text = nullptr;
  const bool good = gdal().OSRExportToPROJJSON(reference, &text, nullptr) == OGRERR_NONE;
  const GdalText owner(text);
  if (!good || text == nullptr) return 0;
  const nlohmann::json system = nlohmann::json::parse(text, nullptr, false);
  if (!system.is_object()) return 0;
  const nlohmann::json& bare = system.contains("source_crs") ? system["source_crs"] : system;
  const nlohmann::json unit =
      bare.value(nlohmann::json::json_pointer("/coordinate_system/axis/2/unit"), nlohmann::json());
  if (unit == "metre") return 1;
  const bool has_length =
      unit.is_object() && unit.contains("conversion_factor") && unit["conversion_factor"].is_number();
  return has_length ? unit["conversion_factor"].get<double>() : 0;
}

std::string vertical_unit(Handle reference) {
  if (gdal().OSRIsGeocentric(reference) != 0) return unit_of_length(gdal().OSRGetLinearUnits(reference, nullptr));
  if (gdal().OSRIsVertical(reference) != 0)
    return unit_of_length(gdal().OSRGetTargetLinearUnits(reference, "VERT_CS", nullptr));
  if (gdal().OSRGetAxesCount(reference) != 3) return "unknown";
  return unit_of_length(metres_of_third_axis(reference));
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
  [[nodiscard]] std::span<const char> bytes() const { return bytes_; }

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

// The one system of the registry that the text is by all likelihood, by the rule of OGRSpatialReference::FindBestMatch:
// the only match, or the only one of EPSG, of at least 90 %.
GdalReference best_match(Handle reference) {
  int count = 0;
  int* confidence = nullptr;
  Handle* const matches = gdal().OSRFindMatches(reference, nullptr, &count, &confidence);
  int best = -1, of_epsg = 0;
  for (int i = 0; i < count; ++i) {
    if (confidence[i] < 90) continue;
    const char* const authority = gdal().OSRGetAuthorityName(matches[i], nullptr);
    const bool is_epsg = authority != nullptr && std::strcmp(authority, "EPSG") == 0;
    if (is_epsg) ++of_epsg;
    if (is_epsg || count == 1) best = i;
  }
  GdalReference found(best >= 0 && of_epsg <= 1 ? gdal().OSRClone(matches[best]) : nullptr);
  if (matches != nullptr) gdal().OSRFreeSRSArray(matches);
  gdal().VSIFree(confidence);
  return found;
}

// GDAL takes the name of a file, or of a file and an entry of it, for the system that it holds.
bool may_be_a_file(std::string_view text) {
  const auto is_before = [](std::string_view start, std::string_view whole) {
    return std::equal(start.begin(), start.end(), whole.begin(), whole.begin() + std::min(start.size(), whole.size()),
                      [](char a, char b) { return a == std::tolower(static_cast<unsigned char>(b)); });
  };
  while (is_before("esri::", text)) text.remove_prefix(6);
  std::error_code error;
  return is_before("/vsi", text) || is_before("dict:", text) || std::filesystem::exists(text, error);
}

bool understand(const std::string& crs, Handle reference) {
  const NoNetwork none;
  return !crs.empty() && !may_be_a_file(crs) && gdal().OSRSetFromUserInput(reference, crs.c_str()) == OGRERR_NONE;
}

}  // namespace

Crs describe_crs(Handle reference) {
  if (reference == nullptr || gdal().OSRGetName(reference) == nullptr) return {};
  return {name_of(reference), horizontal_unit(reference), vertical_unit(reference)};
}

Crs crs_from_wkt(const std::string& wkt, const std::string& path) {
  need_gdal(path + reading);
  const GdalMessages messages;
  const GdalReference reference = new_reference();
  char* text = const_cast<char*>(wkt.c_str());  // read only: what moves is the pointer
  if (gdal().OSRImportFromWkt(reference.get(), &text) != OGRERR_NONE) return {};
  return describe_crs(reference.get());
}

Crs crs_from_esri(const std::string& wkt, const std::string& path) {
  need_gdal(path + reading);
  const GdalMessages messages;
  const GdalReference reference = new_reference();
  char* lines[] = {const_cast<char*>(wkt.c_str()), nullptr};  // read only
  if (gdal().OSRImportFromESRI(reference.get(), lines) != OGRERR_NONE) return {};
  // ESRI's text has no codes. A search of the registry takes a good part of a second, so only here.
  const GdalReference match = best_match(reference.get());
  return describe_crs(match ? match.get() : reference.get());
}

Crs crs_from_geokeys(std::span<const char> directory, std::span<const char> doubles, std::span<const char> ascii,
                     const std::string& path) {
  need_gdal(path + reading);
  const GdalMessages messages;
  const ReportVerticalCrs vertical;
  gdal().GDALRegister_GTiff();
  const TinyTiff tiff(directory, doubles, ascii);
  const GdalMemoryFile file(tiff.bytes());
  const char* const drivers[] = {"GTiff", nullptr};
  const GdalDataset data(gdal().GDALOpenEx(file.path().c_str(), GDAL_OF_RASTER, drivers, nullptr, nullptr));
  return data ? describe_crs(gdal().GDALGetSpatialRef(data.get())) : Crs{};
}

std::string wkt_of_crs(const std::string& crs, const std::string& path) {
  if (crs.empty()) return {};
  need_gdal(path + ": writing the coordinate reference system");
  const GdalMessages messages;
  const GdalReference reference = new_reference();
  return understand(crs, reference.get()) ? wkt_of(reference.get(), "WKT1_GDAL") : "";
}

bool same_crs(const std::string& one, const std::string& other) {
  if (one == other || one.empty() || other.empty()) return true;
  need_gdal("comparing two coordinate reference systems");
  const GdalMessages messages;
  const GdalReference a = new_reference(), b = new_reference();
  if (!understand(one, a.get()) || !understand(other, b.get())) return true;
  for (const Handle r : {a.get(), b.get()})
    if (gdal().OSRIsCompound(r) != 0) gdal().OSRStripVertical(r);
  const char* const options[] = {"IGNORE_DATA_AXIS_TO_SRS_AXIS_MAPPING=YES",
                                 "CRITERION=EQUIVALENT_EXCEPT_AXIS_ORDER_GEOGCRS", nullptr};
  return gdal().OSRIsSameEx(a.get(), b.get(), options) != 0;
}

std::string short_name(const std::string& crs) {
  if (crs.size() < 40) return crs;
  need_gdal("naming a coordinate reference system");
  const GdalMessages messages;
  const GdalReference reference = new_reference();
  const char* const name = understand(crs, reference.get()) ? gdal().OSRGetName(reference.get()) : nullptr;
  return name != nullptr ? name : "another one";
}

}  // namespace isopach
