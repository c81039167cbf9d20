#include "isopach/io/las_format.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "isopach/base/error.hpp"
#include "isopach/io/scan.hpp"

namespace isopach {
namespace {

static_assert(std::endian::native == std::endian::little, "point records are read in place");

constexpr std::size_t oldest_header = 227, header_1_3 = 235, header_1_4 = 375;
constexpr std::size_t record_header = 54, extended_header = 60;
constexpr std::array<std::size_t, 10> type_width = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};

[[noreturn]] void fail(const std::string& path, const std::string& cause, const char* remedy = "get the file again") {
  throw InputError(fmt::format("{}: {}: {}", path, cause, remedy));
}

std::string fixed_text(const char* at, std::size_t size) { return {at, std::find(at, at + size, '\0')}; }

// Calls f(T) with the raw value of the column.
template <class F>
auto with_raw(const LasColumn& column, const char* record, F&& f) {
  const char* const at = record + column.offset;
  switch (column.type) {
    case LasType::u8:
      return f(get_le<std::uint8_t>(at));
    case LasType::i8:
      return f(get_le<std::int8_t>(at));
    case LasType::u16:
      return f(get_le<std::uint16_t>(at));
    case LasType::i16:
      return f(get_le<std::int16_t>(at));
    case LasType::u32:
      return f(get_le<std::uint32_t>(at));
    case LasType::i32:
      return f(get_le<std::int32_t>(at));
    case LasType::u64:
      return f(get_le<std::uint64_t>(at));
    case LasType::i64:
      return f(get_le<std::int64_t>(at));
    case LasType::f32:
      return f(get_le<float>(at));
    default:
      return f(get_le<double>(at));
  }
}

std::vector<LasRecord> parse_records(LasFile& file) {
  std::vector<LasRecord> records;
  const auto promised = get_le<std::uint32_t>(file.head.data() + 100);
  std::size_t at = file.header_size;
  for (std::uint32_t i = 0; i < promised; ++i) {
    const char* const head = file.head.data() + at;
    const std::size_t length = at + record_header <= file.points_at ? get_le<std::uint16_t>(head + 20) : 0;
    if (at + record_header + length > file.points_at) {
      file.notes.push_back(fmt::format("the header promises {} variable length records, {} are there", promised, i));
      break;
    }
    records.push_back({fixed_text(head + 2, 16), get_le<std::uint16_t>(head + 18), at,
                       file.head.subspan(at, record_header + length), file.head.subspan(at + record_header, length)});
    at += record_header + length;
  }
  return records;
}

// A part of the file that stays as long as `file` does.
std::span<const char> keep(LasFile& file, std::size_t at, std::size_t length) {
  auto copy = std::make_shared<Array<char>>();
  const std::span<const char> part = file.bytes.get(at, length, *copy);
  if (!file.bytes.in_memory()) file.kept.push_back(std::move(copy));
  return part;
}

// Waveforms and the like may be larger than memory; nothing but the CRS is asked of a file that is not in it.
bool is_kept(const LasFile& file, const std::string& user, std::size_t length) {
  constexpr std::size_t most = std::size_t{16} << 20;
  return file.bytes.in_memory() || ((user == "LASF_Projection" || user == "liblas") && length <= most);
}

std::vector<LasRecord> parse_extended(LasFile& file) {
  std::vector<LasRecord> records;
  if (file.header_size < header_1_3) return records;
  const char* const header = file.head.data();
  std::uint64_t at = get_le<std::uint64_t>(header + 227), promised = at == 0 ? 0 : 1;  // 1.3: the waveforms alone
  if (file.header_size >= header_1_4)
    at = get_le<std::uint64_t>(header + 235), promised = get_le<std::uint32_t>(header + 243);
  for (std::uint64_t i = 0; i < promised; ++i) {
    const bool fits = at >= file.points_at && at <= file.bytes.size() && file.bytes.size() - at >= extended_header;
    const std::uint64_t length = fits ? file.bytes.number<std::uint64_t>(at + 20) : 0;
    if (!fits || length > file.bytes.size() - at - extended_header) {
      file.notes.push_back(fmt::format("the header promises {} extended records, {} are there", promised, i));
      break;
    }
    std::array<char, extended_header> own{};
    file.bytes.copy(at, own.size(), own.data());
    LasRecord record{fixed_text(own.data() + 2, 16), get_le<std::uint16_t>(own.data() + 18), at, {}, {}};
    if (is_kept(file, record.user, length)) {
      record.whole = keep(file, at, extended_header + length);
      record.data = record.whole.subspan(extended_header);
    }
    records.push_back(std::move(record));
    at += extended_header + length;
  }
  return records;
}

void check_header(const LasFile& file, const std::string& path) {
  const std::size_t least = file.minor >= 4 ? header_1_4 : oldest_header;
  if (file.header_size < least || file.header_size > file.bytes.size())
    fail(path, fmt::format("the LAS header of {} bytes does not fit version 1.{}", file.header_size, file.minor));
  if (file.points_at < file.header_size || file.points_at > file.bytes.size())
    fail(path, fmt::format("the points start at byte {} of a file of {}", file.points_at, file.bytes.size()));
  if (file.format >= las_formats)
    fail(path, fmt::format("point format {} is unknown", file.format), "convert it to a format from 0 to 10");
  const std::size_t base = las_record_length[static_cast<std::size_t>(file.format)];
  if (file.record_length < base)
    fail(path, fmt::format("point records of {} bytes are too short for format {}", file.record_length, file.format));
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!std::isfinite(file.scale[axis]) || !std::isfinite(file.offset[axis]) || file.scale[axis] == 0)
      fail(path, fmt::format("scale {} and offset {} of {} make no coordinates", file.scale[axis], file.offset[axis],
                             "xyz"[axis]));
}

void check_count(const LasFile& file, const std::string& path) {
  const std::size_t room = (file.bytes.size() - file.points_at) / file.record_length;
  if (!file.compressed && file.count > room)
    fail(path, fmt::format("the header promises {} points, the file ends after {}", file.count, room));
}

std::size_t point_count(const LasFile& file) {
  const auto legacy = get_le<std::uint32_t>(file.head.data() + 107);
  const std::uint64_t count = file.minor >= 4 ? get_le<std::uint64_t>(file.head.data() + 247) : 0;
  return count != 0 ? count : legacy;
}

std::string unlike(const std::string& name, const std::vector<LasColumn>& a, const std::vector<LasColumn>& b) {
  const auto taken = [&](const std::string& candidate) {
    const auto same = [&](const LasColumn& column) { return column.name == candidate; };
    return std::any_of(a.begin(), a.end(), same) || std::any_of(b.begin(), b.end(), same);
  };
  std::string candidate = name;
  for (int i = 2; taken(candidate); ++i) candidate = fmt::format("{}_{}", name, i);
  return candidate;
}

// One descriptor of an extra-bytes record (LAS 1.4, table 24), kinds 1 to 10, or 11 to 30: deprecated pairs and
// triples.
LasColumn describe(const char* descriptor, LasType type, std::size_t k, std::size_t offset) {
  const auto options = static_cast<unsigned char>(descriptor[3]);
  LasColumn column{attribute_name(fixed_text(descriptor + 4, 32)), offset, type};
  if (column.name.empty()) column.name = "extra";
  if ((options & 1U) != 0) {  // stored in the widest type of its kind
    const char* const none = descriptor + 40 + 8 * k;
    if (type >= LasType::f32)
      column.nodata = get_le<double>(none);
    else if (static_cast<int>(type) % 2 == 1)
      column.nodata = static_cast<double>(get_le<std::int64_t>(none));
    else
      column.nodata = static_cast<double>(get_le<std::uint64_t>(none));
  }
  if ((options & 8U) != 0) column.scale = get_le<double>(descriptor + 112 + 8 * k);
  if ((options & 16U) != 0) column.add = get_le<double>(descriptor + 136 + 8 * k);
  return column;
}

const LasRecord* find_record(const LasFile& file, const char* user, int id) {
  for (const auto* list : {&file.records, &file.extended})
    for (const LasRecord& record : *list)
      if (record.user == user && record.id == id) return &record;
  return nullptr;
}

}  // namespace

double LasColumn::load(const char* record) const {
  return with_raw(*this, record, [this]<class T>(T raw) {
    if (nodata && static_cast<double>(raw) == *nodata) return std::numeric_limits<double>::quiet_NaN();
    if constexpr (std::is_unsigned_v<T>) raw = static_cast<T>((raw >> shift) & static_cast<T>(mask));
    return static_cast<double>(raw) * scale + add;
  });
}

bool LasColumn::store(char* record, double value) const {
  return with_raw(*this, record, [&]<class T>(T old) {
    if constexpr (std::is_floating_point_v<T>) {
      if (!std::isnan(value) && static_cast<double>(static_cast<T>(value)) != value) return false;
      put_le(record + offset, static_cast<T>(value));
      return true;
    } else {
      const double raw = std::nearbyint((value - add) / scale);
      const double most = static_cast<double>(std::min<std::uint64_t>(mask, std::numeric_limits<T>::max()));
      // 2^63 and 2^64 are not below the limits of their types, but no standard column is as wide.
      if (!(raw >= static_cast<double>(std::numeric_limits<T>::min()) && raw <= most) || raw * scale + add != value)
        return false;
      T bits = static_cast<T>(raw);
      if constexpr (std::is_unsigned_v<T>) {
        const T field = static_cast<T>(mask);
        if (mask != ~std::uint64_t{0}) bits = static_cast<T>((old & ~(field << shift)) | (bits << shift));
      }
      put_le(record + offset, bits);
      return true;
    }
  });
}

LasFile parse_las(std::span<const char> bytes, const std::string& path) { return parse_las(ByteView(bytes), path); }

LasFile parse_las(const ByteView& bytes, const std::string& path) {
  LasFile file;
  file.bytes = bytes;
  std::array<char, oldest_header> header_bytes{};
  const char* const header = header_bytes.data();
  bytes.copy(0, std::min(bytes.size(), oldest_header), header_bytes.data());
  if (bytes.size() < 4 || std::string(header, 4) != "LASF")
    fail(path, "this is not a LAS file: it does not start with LASF", "check the format");
  if (bytes.size() < oldest_header) fail(path, "the LAS header is cut short");
  const int major = static_cast<unsigned char>(header[24]);
  file.minor = static_cast<unsigned char>(header[25]);
  if (major != 1 || file.minor > 5)
    fail(path, fmt::format("LAS version {}.{} is unknown", major, file.minor), "convert it to 1.4");
  file.encoding = get_le<std::uint16_t>(header + 6);
  file.header_size = get_le<std::uint16_t>(header + 94);
  file.points_at = get_le<std::uint32_t>(header + 96);
  file.format = static_cast<unsigned char>(header[104]) & 0x3F;  // the two upper bits are LASzip's
  file.compressed = (static_cast<unsigned char>(header[104]) & 0xC0) != 0;
  file.record_length = get_le<std::uint16_t>(header + 105);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    file.scale[axis] = get_le<double>(header + 131 + 8 * axis);
    file.offset[axis] = get_le<double>(header + 155 + 8 * axis);
  }
  check_header(file, path);
  file.head = keep(file, 0, file.points_at);
  file.count = point_count(file);
  check_count(file, path);
  if (file.minor >= 3 && file.header_size >= header_1_3)
    file.waveforms_at = get_le<std::uint64_t>(file.head.data() + 227);
  file.records = parse_records(file);
  if (file.minor >= 3) file.extended = parse_extended(file);
  return file;
}

std::array<LasColumn, 3> las_coordinates(const LasFile& file) {
  const auto axis = [&](const char* name, std::size_t i) {
    LasColumn column{name, 4 * i, LasType::i32};
    column.scale = file.scale[i];
    column.add = file.offset[i];
    return column;
  };
  return {axis("x", 0), axis("y", 1), axis("z", 2)};
}

std::vector<LasColumn> las_standard_columns(int format) {
  using enum LasType;
  const bool modern = format >= 6;
  std::vector<LasColumn> columns = {{"intensity", 12, u16}};
  const auto add = [&](const char* name, std::size_t offset, LasType type, unsigned shift = 0, unsigned bits = 0) {
    LasColumn column{name, offset, type};
    column.shift = shift;
    if (bits != 0) column.mask = (std::uint64_t{1} << bits) - 1;
    columns.push_back(column);
  };
  if (modern) {
    add("return_number", 14, u8, 0, 4), add("number_of_returns", 14, u8, 4, 4);
    add("synthetic", 15, u8, 0, 1), add("key_point", 15, u8, 1, 1), add("withheld", 15, u8, 2, 1);
    add("overlap", 15, u8, 3, 1), add("scanner_channel", 15, u8, 4, 2);
    add("scan_direction", 15, u8, 6, 1), add("edge_of_flight_line", 15, u8, 7, 1);
    add("classification", 16, u8), add("user_data", 17, u8), add("scan_angle", 18, i16);
    columns.back().scale = 0.006;  // degrees per step
    add("point_source_id", 20, u16), add("gps_time", 22, f64);
  } else {
    add("return_number", 14, u8, 0, 3), add("number_of_returns", 14, u8, 3, 3);
    add("scan_direction", 14, u8, 6, 1), add("edge_of_flight_line", 14, u8, 7, 1);
    add("classification", 15, u8, 0, 5), add("synthetic", 15, u8, 5, 1), add("key_point", 15, u8, 6, 1);
    add("withheld", 15, u8, 7, 1), add("scan_angle", 16, i8), add("user_data", 17, u8);
    add("point_source_id", 18, u16);
    if (format == 1 || format >= 3) add("gps_time", 20, f64);
  }
  const std::size_t colour = modern ? 30 : format == 2 ? 20 : 28;
  if (format == 2 || format == 3 || format == 5 || format == 7 || format == 8 || format == 10)
    add("red", colour, u16), add("green", colour + 2, u16), add("blue", colour + 4, u16);
  if (format == 8 || format == 10) add("near_infrared", colour + 6, u16);
  return columns;
}

std::size_t las_described_length(const char* descriptor) {
  const std::size_t kind = static_cast<unsigned char>(descriptor[2]);
  if (kind == 0 || kind > 30)
    return static_cast<unsigned char>(descriptor[3]);  // not typed: its options are its length
  return type_width[(kind - 1) % 10] * ((kind - 1) / 10 + 1);
}

std::string las_descriptors(const LasFile& file) {
  std::string all;
  std::size_t room = file.record_length - las_record_length[static_cast<std::size_t>(file.format)];
  for (const LasRecord& record : file.records) {
    if (record.user != "LASF_Spec" || record.id != 4) continue;
    for (std::size_t i = 0; i + las_descriptor_length <= record.data.size(); i += las_descriptor_length) {
      const std::size_t length = las_described_length(record.data.data() + i);
      if (length > room) return all;
      room -= length;
      all.append(record.data.data() + i, las_descriptor_length);
    }
  }
  return all;
}

std::vector<LasColumn> las_extra_columns(const LasFile& file, const std::vector<LasColumn>& taken,
                                         std::vector<std::string>& notes) {
  std::vector<LasColumn> columns;
  const std::string all = las_descriptors(file);
  std::size_t promised = 0;
  for (const LasRecord& record : file.records)
    if (record.user == "LASF_Spec" && record.id == 4) promised += record.data.size() / las_descriptor_length;
  if (all.size() < promised * las_descriptor_length)
    notes.emplace_back("the extra bytes described do not fit into a point record: those that do not are left out");

  std::size_t at = las_record_length[static_cast<std::size_t>(file.format)];
  for (std::size_t i = 0; i < all.size(); i += las_descriptor_length) {
    const char* const descriptor = all.data() + i;
    const int kind = static_cast<unsigned char>(descriptor[2]);
    const int parts = kind == 0 || kind > 30 ? 0 : (kind - 1) / 10 + 1;
    for (int k = 0; k < parts; ++k) {
      const auto part = static_cast<std::size_t>(k), type = static_cast<std::size_t>((kind - 1) % 10);
      LasColumn column = describe(descriptor, static_cast<LasType>(type), part, at + part * type_width[type]);
      if (parts > 1) column.name += fmt::format("_{}", k);
      column.name = unlike(column.name, taken, columns);
      columns.push_back(column);
    }
    at += las_described_length(descriptor);
  }
  return columns;
}

Crs las_crs(const LasFile& file, const std::string& path, std::vector<std::string>& notes) {
  constexpr std::uint16_t wkt_bit = 16;
  const auto data = [&](const char* user, int id) {
    const LasRecord* const record = find_record(file, user, id);
    return record == nullptr ? std::span<const char>() : record->data;
  };
  const auto wkt_from = [&](const char* user) {
    const auto text = data(user, 2112);
    const std::string wkt = fixed_text(text.data(), text.size());
    return wkt.empty() ? Crs{} : crs_from_wkt(wkt, path);
  };
  const auto keys = data("LASF_Projection", 34735);
  Crs crs;
  if ((file.encoding & wkt_bit) != 0) crs = wkt_from("LASF_Projection");
  if (crs.name.empty() && keys.size() > 8)
    crs = crs_from_geokeys(keys, data("LASF_Projection", 34736), data("LASF_Projection", 34737), path);
  if (crs.name.empty()) crs = wkt_from("LASF_Projection");
  if (crs.name.empty()) crs = wkt_from("liblas");
  if (crs.name.empty() && (keys.size() > 8 || !data("LASF_Projection", 2112).empty()))
    notes.emplace_back("the coordinate reference system of the file is not understood, so it says no unit");
  return crs;
}

}  // namespace isopach
