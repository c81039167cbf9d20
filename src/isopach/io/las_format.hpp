// The LAS format as data: the header, the variable length records, and the columns of a point record. Layout after the
// ASPRS LAS specification 1.4 R15 (a 1.5 header only appends to it). All numbers in a file are little-endian.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "isopach/io/byte_view.hpp"
#include "isopach/io/crs.hpp"

namespace isopach {

enum class LasType : std::uint8_t { u8, i8, u16, i16, u32, i32, u64, i64, f32, f64 };

/// One number in a point record: ((raw >> shift) & mask) * scale + add.
struct LasColumn {
  std::string name;
  std::size_t offset;
  LasType type;
  unsigned shift = 0;
  std::uint64_t mask = ~std::uint64_t{0};
  double scale = 1, add = 0;
  std::optional<double> nodata = {};  ///< raw value that means "none"; loaded as NaN

  [[nodiscard]] double load(const char* record) const;
  /// Writes a value; false, and nothing is written, if the column cannot hold exactly this value.
  [[nodiscard]] bool store(char* record, double value) const;
};

/// A variable length record, extended or not.
struct LasRecord {
  std::string user;
  int id;
  std::size_t at;               ///< its place in the file
  std::span<const char> whole;  ///< with its own header
  std::span<const char> data;   ///< both empty where an extended one was not kept
};

struct LasFile {
  ByteView bytes;
  std::span<const char> head;  ///< all before the points: header and variable length records
  int minor = 0;
  std::uint16_t encoding = 0;
  std::size_t header_size = 0, points_at = 0;
  int format = 0;
  bool compressed = false;
  std::size_t record_length = 0;
  std::size_t count = 0;
  std::array<double, 3> scale{}, offset{};
  std::size_t waveforms_at = 0;  ///< 0 if none in this file
  std::vector<LasRecord> records, extended;
  std::vector<std::string> notes;
  std::vector<std::shared_ptr<const Array<char>>> kept;  ///< what head and records look at, of a file not in memory
};

inline constexpr int las_formats = 11;
/// Bytes of a point record of each format, without extra bytes.
inline constexpr std::array<std::size_t, las_formats> las_record_length = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
inline constexpr std::size_t las_descriptor_length = 192;

/// Reads and checks the header and the records. Throws InputError: not LAS, version or format unknown, offsets or
/// counts that do not fit into the file. Takes memory only for records that are there. Of a file that is not in memory
/// the points are not touched, and of the extended records those of a CRS alone are kept.
[[nodiscard]] LasFile parse_las(const ByteView& bytes, const std::string& path);
[[nodiscard]] LasFile parse_las(std::span<const char> bytes, const std::string& path);

/// x, y and z.
[[nodiscard]] std::array<LasColumn, 3> las_coordinates(const LasFile& file);

/// Every other column of the format: classification, intensity, return_number, … and "withheld".
[[nodiscard]] std::vector<LasColumn> las_standard_columns(int format);

/// The columns described by the extra-bytes records, names in lower case snake_case and unlike those in `taken`.
/// Descriptors that reach past the end of the point record are left out, with a note.
[[nodiscard]] std::vector<LasColumn> las_extra_columns(const LasFile& file, const std::vector<LasColumn>& taken,
                                                       std::vector<std::string>& notes);

/// The extra-bytes descriptors of the file that fit into a point record, one after another, 192 bytes each.
[[nodiscard]] std::string las_descriptors(const LasFile& file);

/// Bytes in a point record of what a descriptor describes.
[[nodiscard]] std::size_t las_described_length(const char* descriptor);

/// CRS of the file; adds a note if there is one that is not understood.
[[nodiscard]] Crs las_crs(const LasFile& file, const std::string& path, std::vector<std::string>& notes);

template <class T>
[[nodiscard]] T get_le(const char* at) {
  T value;
  __builtin_memcpy(&value, at, sizeof value);
  return value;
}
template <class T>
void put_le(char* at, T value) {
  __builtin_memcpy(at, &value, sizeof value);
}

}  // namespace isopach
