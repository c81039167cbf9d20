#include "isopach/io/scan.hpp"

#include <fast_float/fast_float.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <limits>

#include "isopach/base/parallel.hpp"

namespace isopach {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_lower(char c) { return c >= 'a' && c <= 'z'; }
bool is_upper(char c) { return c >= 'A' && c <= 'Z'; }
char lower(char c) { return is_upper(c) ? static_cast<char>(c - 'A' + 'a') : c; }

// "1.#QNAN", "-1.#IND", "1.#INF00": what old Microsoft run-times print.
bool scan_old_special(const char*& p, const char* end, double& value) {
  const char* q = p;
  const bool negative = q < end && *q == '-';
  if (negative) ++q;
  constexpr std::string_view mark = "1.#";
  if (std::string_view(q, static_cast<std::size_t>(end - q)).substr(0, mark.size()) != mark) return false;
  q += mark.size();
  const char* const word = q;
  while (q < end && (is_upper(*q) || is_digit(*q))) ++q;
  const bool infinite = std::string_view(word, static_cast<std::size_t>(q - word)).substr(0, 3) == "INF";
  value = infinite ? std::numeric_limits<double>::infinity() : std::numeric_limits<double>::quiet_NaN();
  if (negative) value = -value;
  p = q;
  return true;
}

template <class T>
bool to_whole(std::string_view text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (is_blank(text.front()) || text.front() == '\r')) text.remove_prefix(1);
  while (!text.empty() && (is_blank(text.back()) || text.back() == '\r')) text.remove_suffix(1);
  return text;
}

std::vector<std::string_view> words(std::string_view line) {
  std::vector<std::string_view> result;
  std::size_t i = 0;
  while (i < line.size()) {
    while (i < line.size() && is_blank(line[i])) ++i;
    const std::size_t begin = i;
    while (i < line.size() && !is_blank(line[i])) ++i;
    if (i > begin) result.push_back(line.substr(begin, i - begin));
  }
  return result;
}

bool scan_number(const char*& p, const char* end, double& value, char decimal) {
  const char* begin = p;
  if (end - begin > 1 && *begin == '+' && begin[1] != '-') ++begin;
  const auto answer = fast_float::from_chars_advanced(
      begin, end, value, fast_float::parse_options(fast_float::chars_format::general, decimal));
  // Beyond the range of doubles the nearest one is infinity or zero, which newer versions also report as an error.
  if (answer.ec != std::errc() && answer.ec != std::errc::result_out_of_range) return false;
  if (answer.ptr < end && *answer.ptr == '#') return scan_old_special(p, end, value);
  p = answer.ptr;
  return true;
}

bool to_number(std::string_view text, double& value) {
  const char* p = text.data();
  const char* const end = p + text.size();
  return scan_number(p, end, value) && p == end;
}

bool to_count(std::string_view text, std::uint64_t& value) { return to_whole(text, value); }
bool to_integer(std::string_view text, std::int64_t& value) { return to_whole(text, value); }

std::string attribute_name(std::string_view text) {
  constexpr std::string_view prefix = "scalar_";  // CloudCompare's mark of a scalar field
  std::string name;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (i > 0 && is_upper(c) && is_lower(text[i - 1])) name += '_';
    if (is_upper(c) || is_lower(c) || is_digit(c))
      name += lower(c);
    else if (static_cast<unsigned char>(c) >= 0x80)
      name += c;
    else if (!name.empty() && name.back() != '_')
      name += '_';
  }
  while (!name.empty() && name.back() == '_') name.pop_back();
  if (name.size() > prefix.size() && name.compare(0, prefix.size(), prefix) == 0) name.erase(0, prefix.size());
  return name;
}

std::string lower_case(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(), lower);
  return result;
}

bool wanted(const ReadOptions& options, const std::string& attribute) {
  return options.all_attributes ||
         std::find(options.attributes.begin(), options.attributes.end(), attribute) != options.attributes.end();
}

std::string quoted(std::string_view text) {
  constexpr std::size_t most = 40;
  std::string result = "\"";
  for (const char c : text.substr(0, most)) result += c >= ' ' && c <= '~' ? c : '?';
  return result + (text.size() > most ? "...\"" : "\"");
}

std::size_t line_number(std::string_view text, std::size_t offset) {
  return 1 + static_cast<std::size_t>(std::count(
                 text.begin(), text.begin() + static_cast<std::ptrdiff_t>(std::min(offset, text.size())), '\n'));
}

std::size_t size_of(Scalar type) {
  switch (type) {
    case Scalar::i8:
    case Scalar::u8:
      return 1;
    case Scalar::i16:
    case Scalar::u16:
      return 2;
    case Scalar::i32:
    case Scalar::u32:
    case Scalar::f32:
      return 4;
    case Scalar::i64:
    case Scalar::u64:
    case Scalar::f64:
      break;
  }
  return 8;
}

void load_rows(const char* rows, std::size_t count, std::size_t stride, const std::vector<BinaryColumn>& columns,
               bool swap, Cloud& cloud) {
  constexpr std::size_t block = 1 << 15;
  const std::size_t before = cloud.points.size() - count;
  for_blocks(count, block, [&](std::size_t begin, std::size_t end) {
    for (const BinaryColumn& column : columns) {
      const char* row = rows + begin * stride + column.offset;
      // Column by column: the type is the same for the whole inner loop, which the processor then predicts.
      double* const values =
          column.target < 3 ? nullptr : cloud.attributes[static_cast<std::size_t>(column.target - 3)].values.data();
      for (std::size_t i = before + begin; i < before + end; ++i, row += stride) {
        const double value = load_scalar(row, column.type, swap);
        if (values != nullptr)
          values[i] = value;
        else if (column.target == 0)
          cloud.points[i].x = value;
        else if (column.target == 1)
          cloud.points[i].y = value;
        else
          cloud.points[i].z = value;
      }
    }
  });
}

void add_fan(std::span<const Index> polygon, Array<std::array<Index, 3>>& faces) {
  for (std::size_t i = 2; i < polygon.size(); ++i) faces.push_back({polygon[0], polygon[i - 1], polygon[i]});
}

}  // namespace isopach
