// Small words shared by the parsers: lines, tokens, numbers, names, and quoting for messages.
#pragma once
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "isopach/cloud/cloud.hpp"
#include "isopach/io/read.hpp"

namespace isopach {

using Bytes = std::span<const char>;

[[nodiscard]] inline std::string_view as_text(Bytes bytes) { return {bytes.data(), bytes.size()}; }
[[nodiscard]] inline bool is_blank(char c) { return c == ' ' || c == '\t'; }
[[nodiscard]] std::string_view trimmed(std::string_view text);

/// The lines of a text, one after the other, without their "\n" or "\r\n"; the last one needs no line end.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text), size_(text.size()) {}
  [[nodiscard]] bool next(std::string_view& line) {
    if (rest_.empty()) return false;
    const std::size_t end = rest_.find('\n');
    line = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    ++number_;
    return true;
  }
  [[nodiscard]] std::size_t offset() const { return size_ - rest_.size(); }  ///< of the line that comes next
  [[nodiscard]] std::size_t number() const { return number_; }               ///< of the last line returned, from 1

 private:
  std::string_view rest_;
  std::size_t size_;
  std::size_t number_ = 0;
};

/// The pieces of a line between blanks and tabs.
[[nodiscard]] std::vector<std::string_view> words(std::string_view line);

/// Reads the number at the start of [p, end) and moves p behind it: the nearest double; "nan", "inf", a leading "+" and
/// the "1.#QNAN" of old compilers are understood. False, p unmoved, if there is none.
[[nodiscard]] bool scan_number(const char*& p, const char* end, double& value, char decimal = '.');

/// True if the whole text is one number.
[[nodiscard]] bool to_number(std::string_view text, double& value);
[[nodiscard]] bool to_count(std::string_view text, std::uint64_t& value);
[[nodiscard]] bool to_integer(std::string_view text, std::int64_t& value);

/// Lower case snake_case: "GpsTime" -> "gps_time", "scalar_Classification" -> "classification".
[[nodiscard]] std::string attribute_name(std::string_view text);
[[nodiscard]] std::string lower_case(std::string_view text);
[[nodiscard]] bool wanted(const ReadOptions& options, const std::string& attribute);

/// A piece of a file made fit for a one-line message: short, printable, in quotes.
[[nodiscard]] std::string quoted(std::string_view text);

/// 1 + the number of line ends before `offset`.
[[nodiscard]] std::size_t line_number(std::string_view text, std::size_t offset);

/// A number stored in a file's own byte order.
template <class T>
[[nodiscard]] T load(const char* p, bool swap) {
  char raw[sizeof(T)];
  if (swap)
    for (std::size_t i = 0; i < sizeof(T); ++i) raw[i] = p[sizeof(T) - 1 - i];
  else
    std::memcpy(raw, p, sizeof(T));
  T value;
  std::memcpy(&value, raw, sizeof(T));
  return value;
}

/// The scalar types of PLY and PCD, and how to read one as a double.
enum class Scalar : std::uint8_t { i8, u8, i16, u16, i32, u32, i64, u64, f32, f64 };
[[nodiscard]] std::size_t size_of(Scalar type);
[[nodiscard]] inline double load_scalar(const char* p, Scalar type, bool swap) {
  switch (type) {
    case Scalar::i8:
      return load<std::int8_t>(p, swap);
    case Scalar::u8:
      return load<std::uint8_t>(p, swap);
    case Scalar::i16:
      return load<std::int16_t>(p, swap);
    case Scalar::u16:
      return load<std::uint16_t>(p, swap);
    case Scalar::i32:
      return load<std::int32_t>(p, swap);
    case Scalar::u32:
      return load<std::uint32_t>(p, swap);
    case Scalar::i64:
      return static_cast<double>(load<std::int64_t>(p, swap));
    case Scalar::u64:
      return static_cast<double>(load<std::uint64_t>(p, swap));
    case Scalar::f32:
      return load<float>(p, swap);
    case Scalar::f64:
      break;
  }
  return load<double>(p, swap);
}

/// One column of fixed-size binary rows: where it stands in a row and where its values go.
struct BinaryColumn {
  std::size_t offset = 0;  ///< in the row, bytes
  Scalar type = Scalar::f32;
  int target = 0;  ///< 0, 1, 2: x, y, z; 3 + k: attribute k
};

/// Reads `count` rows of `stride` bytes into the last points of the cloud, whose points and attributes have been
/// resized; in parallel.
void load_rows(const char* rows, std::size_t count, std::size_t stride, const std::vector<BinaryColumn>& columns,
               bool swap, Cloud& cloud);

/// Adds the fan of a polygon: (0, 1, 2), (0, 2, 3), ...; nothing for fewer than three corners.
void add_fan(std::span<const Index> polygon, Array<std::array<Index, 3>>& faces);

}  // namespace isopach
