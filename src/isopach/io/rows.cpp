#include "isopach/io/rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "isopach/base/error.hpp"
#include "isopach/base/memory.hpp"
#include "isopach/base/parallel.hpp"

namespace isopach {
namespace {

constexpr std::size_t chunk_bytes = std::size_t{1} << 20;

const char* line_end(const char* p, const char* end) {
  const void* const found = std::memchr(p, '\n', static_cast<std::size_t>(end - p));
  return found != nullptr ? static_cast<const char*>(found) : end;
}

bool is_comment(const char* p, const char* end) {
  return *p == '#' || *p == '%' || *p == '!' || (*p == '/' && end - p > 1 && p[1] == '/');
}

// Calls f(begin, end) for each data line, its line end stripped, until f returns false.
template <class F>
void for_data_lines(const char* p, const char* end, bool comments, F&& f) {
  while (p < end) {
    const char* const stop = line_end(p, end);
    const char* last = stop;
    if (last > p && last[-1] == '\r') --last;
    const char* first = p;
    while (first < last && is_blank(*first)) ++first;
    if (first < last && !(comments && is_comment(first, last)) && !f(first, last)) return;
    p = stop + 1;
  }
}

bool is_gap(char c, char separator) { return c == ' ' || (c == '\t' && separator != '\t'); }

void skip_gap(const char*& p, const char* end, char separator) {
  while (p < end && is_gap(*p, separator)) ++p;
}

void skip_field(const char*& p, const char* end, char separator) {
  if (p < end && *p == '"') {
    const void* const close = std::memchr(p + 1, '"', static_cast<std::size_t>(end - p - 1));
    if (close != nullptr) p = static_cast<const char*>(close) + 1;
  }
  if (separator == ' ')
    while (p < end && !is_blank(*p)) ++p;
  else
    while (p < end && *p != separator) ++p;
}

// p stands behind a number: true if the field ends here; p then stands on the separator or the next field.
bool close_field(const char*& p, const char* end, char separator) {
  if (p == end) return true;
  if (separator == ' ') {
    if (!is_blank(*p)) return false;
    skip_gap(p, end, separator);
    return true;
  }
  skip_gap(p, end, separator);
  return p == end || *p == separator;
}

enum class Field { number, decimal_comma, bad };

Field read_field(const char*& p, const char* end, char separator, double& value) {
  const bool quote = p < end && *p == '"';
  if (quote) ++p;
  const char* const begin = p;
  if (!scan_number(p, end, value)) return Field::bad;
  Field kind = Field::number;
  if (p < end && *p == ',' && (separator == ';' || separator == '\t')) {
    p = begin;
    if (!scan_number(p, end, value, ',')) return Field::bad;
    kind = Field::decimal_comma;
  }
  if (quote) {
    if (p == end || *p != '"') return Field::bad;
    ++p;
  }
  return close_field(p, end, separator) ? kind : Field::bad;
}

struct Destination {
  Point3* point;
  Attribute* attributes;
  std::size_t row;
  void put(int target, double value) const {
    if (target == 0)
      point->x = value;
    else if (target == 1)
      point->y = value;
    else if (target == 2)
      point->z = value;
    else if (target > 2)
      attributes[target - 3].values[row] = value;
  }
};

// Returns the first bad column, or -1.
int parse_row(const char* p, const char* end, const RowFormat& format, const Destination& to, bool& comma) {
  const int columns = static_cast<int>(format.targets.size());
  for (int column = 0; column < columns; ++column) {
    const int target = format.targets[static_cast<std::size_t>(column)];
    if (column > 0 && format.separator != ' ') {
      if (p == end) return column;
      ++p;  // the separator
      skip_gap(p, end, format.separator);
    }
    if (target < 0) {
      skip_field(p, end, format.separator);
      if (format.separator == ' ') skip_gap(p, end, ' ');
      continue;
    }
    double value;
    const Field field = read_field(p, end, format.separator, value);
    if (field == Field::bad) return column;
    comma = comma || field == Field::decimal_comma;
    to.put(target, value);
  }
  return -1;
}

struct Chunk {
  const char* begin = nullptr;
  const char* end = nullptr;
  std::size_t rows = 0, first_row = 0;
  const char* bad_line = nullptr;
  int bad_column = -1;
  bool decimal_comma = false;
};

std::vector<Chunk> cut_chunks(const char* begin, const char* end) {
  const auto size = static_cast<std::size_t>(end - begin);
  std::vector<Chunk> chunks((size + chunk_bytes - 1) / chunk_bytes);
  const char* p = begin;
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    chunks[i].begin = p;
    const char* const nominal = begin + std::min(size, (i + 1) * chunk_bytes);
    if (nominal > p) p = nominal == end ? end : std::min(end, line_end(nominal - 1, end) + 1);
    chunks[i].end = p;
  }
  return chunks;
}

std::size_t count_rows(std::vector<Chunk>& chunks, bool comments) {
  for_blocks(chunks.size(), 1, [&](std::size_t i, std::size_t) {
    for_data_lines(chunks[i].begin, chunks[i].end, comments, [&](const char*, const char*) {
      ++chunks[i].rows;
      return true;
    });
  });
  std::size_t total = 0;
  for (Chunk& chunk : chunks) {
    chunk.first_row = total;
    total += chunk.rows;
  }
  return total;
}

void parse_chunk(Chunk& chunk, const RowFormat& format, std::size_t base, Cloud& cloud) {
  std::size_t row = base + chunk.first_row;
  for_data_lines(chunk.begin, chunk.end, format.comments, [&](const char* first, const char* last) {
    const Destination to{&cloud.points[row], cloud.attributes.data(), row};
    chunk.bad_column = parse_row(first, last, format, to, chunk.decimal_comma);
    ++row;
    if (chunk.bad_column < 0) return true;
    chunk.bad_line = first;
    return false;
  });
}

const char* separator_name(char separator) {
  switch (separator) {
    case ',':
      return "commas";
    case ';':
      return "semicolons";
    case '\t':
      return "tabs";
    default:
      return "blanks";
  }
}

[[noreturn]] void fail(std::string_view file, const Chunk& chunk, const RowFormat& format, const std::string& name) {
  const char* const stop = line_end(chunk.bad_line, file.data() + file.size());
  const auto fields =
      split(trimmed({chunk.bad_line, static_cast<std::size_t>(stop - chunk.bad_line)}), format.separator);
  const auto column = static_cast<std::size_t>(chunk.bad_column);
  const std::size_t line =
      format.lines_before + line_number(file, static_cast<std::size_t>(chunk.bad_line - file.data()));
  if (column >= fields.size())
    throw InputError(
        fmt::format("{}: line {}: {} columns separated by {}, but {} are needed: complete or remove the line", name,
                    line, fields.size(), separator_name(format.separator), format.targets.size()));
  throw InputError(fmt::format("{}: line {}: {} in column {} is not a number: correct the line or remove it", name,
                               line, quoted(fields[column]), column + 1));
}

// parse_rows, but for the note: true if there was a decimal comma.
bool parse_text_rows(std::string_view file, std::string_view rows, const RowFormat& format, const std::string& name,
                     Cloud& cloud) {
  std::vector<Chunk> chunks = cut_chunks(rows.data(), rows.data() + rows.size());
  const std::size_t count = count_rows(chunks, format.comments);
  const std::size_t base = cloud.points.size();
  cloud.points.resize(base + count);
  for (Attribute& attribute : cloud.attributes) attribute.values.resize(base + count);
  for_blocks(chunks.size(), 1, [&](std::size_t i, std::size_t) { parse_chunk(chunks[i], format, base, cloud); });
  bool comma = false;
  for (const Chunk& chunk : chunks) {  // in order, so that the first bad line is named whatever thread met it
    if (chunk.bad_line != nullptr) fail(file, chunk, format, name);
    comma = comma || chunk.decimal_comma;
  }
  return comma;
}

void note_commas(const std::string& name, Cloud& cloud) {
  cloud.notes.push_back(fmt::format("{}: decimal commas were read as decimal points", name));
}

}  // namespace

std::vector<int> column_targets(const std::array<int, 3>& axes, const std::vector<int>& attributes) {
  int last = std::max({axes[0], axes[1], axes[2]});
  for (const int column : attributes) last = std::max(last, column);
  std::vector<int> targets(static_cast<std::size_t>(last) + 1, -1);
  for (int k = 0; k < static_cast<int>(attributes.size()); ++k)
    targets[static_cast<std::size_t>(attributes[static_cast<std::size_t>(k)])] = 3 + k;
  for (int k = 0; k < 3; ++k) targets[static_cast<std::size_t>(axes[static_cast<std::size_t>(k)])] = k;
  return targets;
}

char find_separator(std::string_view line) {
  if (line.find(';') != std::string_view::npos) return ';';
  const auto by_tab = split(line, '\t');
  const auto whole = [](std::string_view field) {
    return !field.empty() && field.find(' ') == std::string_view::npos && field.back() != ',';
  };
  if (by_tab.size() >= 3 && std::all_of(by_tab.begin(), by_tab.end(), whole)) return '\t';
  return line.find(',') != std::string_view::npos ? ',' : ' ';
}

std::vector<std::string_view> split(std::string_view line, char separator) {
  std::vector<std::string_view> fields;
  const char* p = line.data();
  const char* const end = p + line.size();
  skip_gap(p, end, separator);
  while (p < end) {
    const char* const begin = p;
    skip_field(p, end, separator);
    std::string_view field = trimmed({begin, static_cast<std::size_t>(p - begin)});
    if (field.size() >= 2 && field.front() == '"' && field.back() == '"') field = field.substr(1, field.size() - 2);
    fields.push_back(field);
    if (p < end && separator != ' ') ++p;
    skip_gap(p, end, separator);
  }
  return fields;
}

std::size_t offset_after_rows(std::string_view text, std::size_t rows, bool comments) {
  if (rows == 0) return 0;
  if (rows > text.size()) return std::string_view::npos;  // a row takes a byte at least
  const char* const begin = text.data();
  const char* const end = begin + text.size();
  std::size_t offset = std::string_view::npos;
  for_data_lines(begin, end, comments, [&](const char*, const char* last) {
    if (--rows > 0) return true;
    offset = static_cast<std::size_t>(std::min(end, line_end(last, end) + 1) - begin);
    return false;
  });
  return offset;
}

std::size_t parse_rows(std::string_view file, std::size_t begin, std::size_t end, const RowFormat& format,
                       const std::string& name, Cloud& cloud) {
  const std::size_t base = cloud.points.size();
  if (parse_text_rows(file, file.substr(begin, end - begin), format, name, cloud)) note_commas(name, cloud);
  return cloud.points.size() - base;
}

RowStream::RowStream(const ByteView& bytes, std::size_t from, std::size_t lines_before, RowFormat format,
                     std::string name)
    : bytes_(bytes), at_(from), format_(std::move(format)), name_(std::move(name)) {
  format_.lines_before = lines_before;
}

bool RowStream::next_piece() {
  constexpr std::size_t piece = std::size_t{32} << 20;
  const std::size_t left = bytes_.size() - at_;
  if (left == 0) return false;
  for (std::size_t length = bytes_.in_memory() ? left : piece;; length *= 2) {
    if (length < left && length > std::max<std::uint64_t>(piece, max_input()))
      throw InputError(fmt::format("{}: line {} is longer than {}, the limit of @max-input: this is no text of points",
                                   name_, format_.lines_before + 1, bytes_in_words(max_input())));
    const std::string_view text = as_text(bytes_.get(at_, std::min(length, left), scratch_));
    const std::size_t end = length >= left ? text.size() : text.rfind('\n') + 1;  // npos + 1 is 0
    if (end == 0) continue;
    rest_ = text.substr(0, end);
    at_ += end;
    return true;
  }
}

std::size_t RowStream::append(Cloud& cloud, std::size_t most) {
  const std::size_t before = cloud.points.size();
  while (cloud.points.size() == before) {
    if (rest_.empty() && !next_piece()) return 0;
    const std::size_t length = std::min(rest_.size(), offset_after_rows(rest_, most, format_.comments));
    const std::string_view rows = rest_.substr(0, length);
    comma_ = parse_text_rows(rest_, rows, format_, name_, cloud) || comma_;
    rest_.remove_prefix(length);
    if (!rest_.empty() || at_ < bytes_.size())  // for the message about a line to come
      format_.lines_before += static_cast<std::size_t>(std::count(rows.begin(), rows.end(), '\n'));
  }
  return cloud.points.size() - before;
}

double RowStream::progress() const {
  return static_cast<double>(at_ - rest_.size()) / static_cast<double>(bytes_.size());
}

void RowStream::note(Cloud& cloud) const {
  if (comma_) note_commas(name_, cloud);
}

}  // namespace isopach
