#include "isopach/io/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <optional>
#include <unordered_set>

#include "isopach/base/error.hpp"
#include "isopach/geom/rigid.hpp"
#include "isopach/io/point_source.hpp"
#include "isopach/io/rows.hpp"

namespace isopach {
namespace {

struct ColumnName {
  std::string name;  // as attribute_name() makes it
  std::string unit;  // of "X [m]" or "x(ft)"
};

struct Layout {
  RowFormat format;
  std::array<int, 3> axes{0, 1, 2};
  std::vector<ColumnName> names;  // empty if the file does not name its columns
  std::vector<bool> numeric;      // per column of the first line of data
  std::size_t body = 0;           // offset of the first line that may be data
  std::optional<std::uint64_t> announced;
  std::string note;
};

std::optional<std::string_view> comment_text(std::string_view line) {
  if (line.substr(0, 2) == "//") return line.substr(2);
  if (line.find_first_of("#%!") == 0) return line.substr(std::min(line.find_first_not_of("#%!"), line.size()));
  return std::nullopt;
}

ColumnName column_name(std::string_view field) {
  const std::size_t open = field.find_first_of("[(");
  if (open == std::string_view::npos || open == 0) return {attribute_name(field), ""};
  const std::size_t close = field.find_first_of("])", open);
  const std::size_t length = close == std::string_view::npos ? close : close - open - 1;
  return {attribute_name(field.substr(0, open)), lower_case(field.substr(open + 1, length))};
}

std::vector<ColumnName> column_names(std::string_view line) {
  std::vector<ColumnName> names;
  for (const std::string_view field : split(line, find_separator(line))) names.push_back(column_name(field));
  return names;
}

int find_column(const std::vector<ColumnName>& names, std::initializer_list<std::string_view> synonyms) {
  for (const std::string_view synonym : synonyms)
    for (std::size_t i = 0; i < names.size(); ++i)
      if (names[i].name == synonym) return static_cast<int>(i);
  return -1;
}

std::array<int, 3> find_axes(const std::vector<ColumnName>& names) {
  return {find_column(names, {"x", "easting", "east", "x_coord", "coord_x", "point_x", "longitude", "lon", "e"}),
          find_column(names, {"y", "northing", "north", "y_coord", "coord_y", "point_y", "latitude", "lat", "n"}),
          find_column(names,
                      {"z", "height", "elevation", "elev", "altitude", "alt", "z_coord", "coord_z", "point_z", "h"})};
}

bool complete(const std::array<int, 3>& axes) { return axes[0] >= 0 && axes[1] >= 0 && axes[2] >= 0; }

bool any_number(const std::vector<std::string_view>& fields) {
  double value;
  return std::any_of(fields.begin(), fields.end(), [&](std::string_view field) {
    const char* p = field.data();
    return scan_number(p, field.data() + field.size(), value);  // a number with a decimal comma starts with one too
  });
}

void check_encoding(std::string_view text, const std::string& name) {
  const std::string_view head = text.substr(0, 2);
  if (head == "\xFF\xFE" || head == "\xFE\xFF")
    throw InputError(fmt::format("{}: text in UTF-16: save it as UTF-8 or plain ASCII", name));
  const std::size_t line_end = text.find('\n');
  const std::size_t old_end = text.substr(0, line_end).find('\r');
  if (old_end != std::string_view::npos && old_end + 1 < std::min(line_end, text.size()))
    throw InputError(fmt::format("{}: lines end in CR alone: convert the line ends to LF", name));
}

[[noreturn]] void no_points(const std::string& name) {
  throw InputError(fmt::format("{}: no points in it: expected lines of x y z", name));
}

// What stands before the data: comments (the last may name the columns), a line of names, the count of a PTS file.
class Preamble {
 public:
  Preamble(std::string_view text, const std::string& name) : lines_(text), name_(name) {}

  /// Nothing if there is no line of data.
  std::optional<Layout> read() {
    std::string_view line;
    while (lines_.next(line)) {
      const std::string_view content = trimmed(line);
      if (content.empty()) continue;
      if (const auto comment = comment_text(content)) {
        comment_names_ = column_names(*comment);
      } else if (first_data_line(content)) {
        return layout_;
      }
      layout_.body = lines_.offset();
    }
    return std::nullopt;
  }

 private:
  // True if `line` is data and the layout is settled; false if it was a header or a count.
  bool first_data_line(std::string_view line) {
    const char separator = find_separator(line);
    const auto fields = split(line, separator);
    if (fields.size() == 1 && !layout_.announced) {
      std::uint64_t count = 0;
      if (to_count(fields[0], count)) {
        layout_.announced = count;
        return false;
      }
    }
    if (layout_.names.empty() && !any_number(fields)) {
      take_header(line);
      return false;
    }
    layout_.format.separator = separator;
    for (const std::string_view field : fields) layout_.numeric.push_back(any_number({field}));
    settle_columns(fields.size());
    return true;
  }

  void take_header(std::string_view line) {
    layout_.names = column_names(line);
    layout_.axes = find_axes(layout_.names);
    if (!complete(layout_.axes))
      throw InputError(
          fmt::format("{}: line {}: {} is neither numbers nor column names with x, y and z: name the columns "
                      "or put # before the line",
                      name_, lines_.number(), quoted(line)));
  }

  void settle_columns(std::size_t columns) {
    if (layout_.names.empty() && comment_names_.size() == columns && complete(find_axes(comment_names_))) {
      layout_.names = comment_names_;
      layout_.axes = find_axes(comment_names_);
    }
    if (!layout_.names.empty() && layout_.names.size() < columns)
      layout_.note = fmt::format("{}: its header names {} of {} columns, taken from the left", name_,
                                 layout_.names.size(), columns);
    if (columns < 3)
      throw InputError(fmt::format("{}: line {}: {} column(s), but x, y and z are needed: expected lines of x y z",
                                   name_, lines_.number(), columns));
    if (layout_.names.empty()) layout_.names = default_names(columns);
  }

  [[nodiscard]] std::vector<ColumnName> default_names(std::size_t columns) const {
    std::vector<ColumnName> names = {{"x", ""}, {"y", ""}, {"z", ""}};
    if (layout_.announced) {  // PTS
      if (columns == 4 || columns >= 7) names.push_back({"intensity", ""});
      if (columns >= 6) names.insert(names.end(), {{"red", ""}, {"green", ""}, {"blue", ""}});
    }
    while (names.size() < columns) names.push_back({fmt::format("column_{}", names.size() + 1), ""});
    return names;
  }

  Lines lines_;
  const std::string& name_;
  Layout layout_;
  std::vector<ColumnName> comment_names_;
};

std::string color_name(const std::string& name) {
  return name == "r" ? "red" : name == "g" ? "green" : name == "b" ? "blue" : name;
}

// Adds the wanted attributes to the cloud and returns their columns. Columns of text are no attributes.
std::vector<int> choose_attributes(const Layout& layout, const ReadOptions& options, Cloud& cloud) {
  std::vector<int> columns;
  std::unordered_set<std::string> taken;
  for (int i = 0; i < static_cast<int>(layout.names.size()); ++i) {
    const std::string name = color_name(layout.names[static_cast<std::size_t>(i)].name);
    if (std::find(layout.axes.begin(), layout.axes.end(), i) != layout.axes.end()) continue;
    if (name.empty() || !wanted(options, name) || taken.count(name) != 0) continue;
    if (static_cast<std::size_t>(i) < layout.numeric.size() && !layout.numeric[static_cast<std::size_t>(i)]) continue;
    taken.insert(name);
    cloud.attributes.push_back({name, {}});
    columns.push_back(i);
  }
  return columns;
}

std::string known_unit(const ColumnName& column) {
  for (const char* const unit : {"m", "mm", "ft", "us-ft", "deg"})
    if (column.unit == unit) return unit;
  const bool degrees = column.name.substr(0, 3) == "lon" || column.name.substr(0, 3) == "lat";
  return degrees ? "deg" : "unknown";
}

bool is_row_of(std::string_view line, std::size_t numbers) {
  const auto fields = words(line);
  double value;
  return fields.size() == numbers &&
         std::all_of(fields.begin(), fields.end(), [&](std::string_view f) { return to_number(f, value); });
}

// One scan of a PTX file: its header of ten lines, then columns × rows points.
class PtxReader {
 public:
  PtxReader(std::string_view text, const std::string& name, const ReadOptions& options, Cloud& cloud)
      : text_(text), name_(name), options_(options), cloud_(cloud) {}

  void read(const Context& context) {
    while (!trimmed_rest().empty()) {
      read_scan();
      context.step("read", static_cast<double>(offset_) / static_cast<double>(text_.size()));
    }
  }

 private:
  [[nodiscard]] std::string_view trimmed_rest() const {
    const std::size_t first = text_.find_first_not_of(" \t\r\n", offset_);
    return first == std::string_view::npos ? std::string_view() : text_.substr(first);
  }

  void read_scan() {
    const std::uint64_t count = read_count() * read_count();
    for (int i = 0; i < 4; ++i) (void)read_row(3);  // where the scanner stood: the pose below says it again
    const Pose pose = read_pose();
    const std::size_t length = offset_after_rows(text_.substr(offset_), count, false);
    if (length == std::string_view::npos) fail("fewer points than its header says: the file is incomplete");
    const std::size_t first = cloud_.points.size();
    parse_rows(text_, offset_, offset_ + length, format(), name_, cloud_);
    offset_ += length;
    place(first, pose);
  }

  RowFormat format() {
    std::string_view line;
    Lines lines(text_.substr(offset_));
    (void)lines.next(line);
    const std::size_t columns = words(line).size();
    if (cloud_.points.empty() && cloud_.attributes.empty()) choose(columns);
    RowFormat result;
    result.comments = false;
    result.targets = column_targets({0, 1, 2}, attribute_columns_);
    return result;
  }

  void choose(std::size_t columns) {
    Layout layout;
    for (const char* const name : {"x", "y", "z", "intensity", "red", "green", "blue"})
      if (layout.names.size() < columns) layout.names.push_back({name, ""});
    attribute_columns_ = choose_attributes(layout, options_, cloud_);
  }

  // Drops the "no return" points of the scan just read and moves the others by its pose.
  void place(std::size_t first, const Pose& pose) {
    std::size_t kept = first;
    for (std::size_t i = first; i < cloud_.points.size(); ++i) {
      const Point3 p = cloud_.points[i];
      if (p.x == 0 && p.y == 0 && p.z == 0) continue;
      cloud_.points[kept] = pose.is_identity() ? p : pose.apply(p);
      for (Attribute& a : cloud_.attributes) a.values[kept] = a.values[i];
      ++kept;
    }
    cloud_.nodata += cloud_.points.size() - kept;
    cloud_.points.resize(kept);
    for (Attribute& a : cloud_.attributes) a.values.resize(kept);
  }

  std::string_view next_line() {
    Lines lines(text_.substr(offset_));
    std::string_view line;
    do {
      line_offset_ = offset_ + lines.offset();
      if (!lines.next(line)) fail("the header of a scan is incomplete: the file is cut short");
    } while (trimmed(line).empty());
    offset_ += lines.offset();
    return line;
  }

  std::uint64_t read_count() {
    std::uint64_t count = 0;
    if (!to_count(trimmed(next_line()), count) || count > text_.size())
      fail("not a count of a PTX scan: correct the header");
    return count;
  }

  std::vector<double> read_row(std::size_t numbers) {
    const auto fields = words(next_line());
    std::vector<double> row(numbers);
    bool good = fields.size() >= numbers;
    for (std::size_t i = 0; i < numbers && good; ++i) good = to_number(fields[i], row[i]);
    if (!good) fail(fmt::format("expected {} numbers in the header of a PTX scan: correct the header", numbers));
    return row;
  }

  Pose read_pose() {  // stored transposed: a point is a row vector
    Pose pose;
    for (std::size_t row = 0; row < 4; ++row) {
      const std::vector<double> numbers = read_row(4);
      for (std::size_t column = 0; column < 4; ++column) pose.m[column * 4 + row] = numbers[column];
    }
    return pose;
  }

  [[noreturn]] void fail(const std::string& why) const {
    throw InputError(fmt::format("{}: line {}: {}", name_, line_number(text_, line_offset_), why));
  }

  std::string_view text_;
  const std::string& name_;
  const ReadOptions& options_;
  Cloud& cloud_;
  std::vector<int> attribute_columns_;
  std::size_t offset_ = 0, line_offset_ = 0;
};

Cloud parse_ptx(std::string_view text, const std::string& name, const ReadOptions& options, const Context& context) {
  Cloud cloud;
  cloud.format = "xyz";
  PtxReader(text, name, options, cloud).read(context);
  if (cloud.points.empty()) no_points(name);
  if (cloud.nodata > 0)
    cloud.notes.push_back(fmt::format("{}: {} directions without a return were left out", name, cloud.nodata));
  return cloud;
}

// Points one a line, of whatever is not PTX.
class TextSource : public PointSource {
 public:
  TextSource(const ByteView& bytes, const std::string& name, const ReadOptions& options) : name_(name) {
    find_layout(bytes);
    layout_.format.targets = column_targets(layout_.axes, choose_attributes(layout_, options, wanted_));
    rows_.emplace(bytes, body_, lines_before_, layout_.format, name_);
  }

  void begin(Cloud& cloud) override {
    cloud.format = "xyz";
    cloud.attributes = wanted_.attributes;
    cloud.unit = known_unit(layout_.names[static_cast<std::size_t>(layout_.axes[0])]);
    cloud.vertical_unit = known_unit(layout_.names[static_cast<std::size_t>(layout_.axes[2])]);
  }

  bool append(Cloud& cloud, std::size_t most, const Context& context) override {
    const std::size_t rows = rows_->append(cloud, most);
    count_ += rows;
    context.step("read", rows_->progress());
    return rows > 0;
  }

  void end(Cloud& cloud) override {
    if (count_ == 0) no_points(name_);
    rows_->note(cloud);
    const auto put = [&](const std::string& note) {
      if (!note.empty()) cloud.notes.push_back(note);
    };
    put(layout_.note);
    if (layout_.announced && *layout_.announced != count_)
      cloud.notes.push_back(fmt::format("{}: announces {} points but holds {}", name_, *layout_.announced, count_));
  }

 private:
  // What stands before the data is looked for in the first bytes, and in more of them until it is found.
  void find_layout(const ByteView& bytes) {
    constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
    constexpr std::size_t first = std::size_t{1} << 20;
    Array<char> scratch;
    for (std::size_t length = first;; length *= 2) {
      const bool all = length >= bytes.size();
      std::string_view text = as_text(bytes.get(0, all ? bytes.size() : length, scratch));
      const std::size_t end = text.rfind('\n');
      if (!all && end == std::string_view::npos && length < max_input()) continue;
      check_encoding(text, name_);
      if (!all && end != std::string_view::npos) text = text.substr(0, end + 1);  // whole lines alone
      const std::size_t start = text.substr(0, 3) == byte_order_mark ? 3 : 0;
      const std::optional<Layout> found = Preamble(text.substr(start), name_).read();
      if (!found && !all && length < max_input()) continue;
      if (!found) no_points(name_);
      layout_ = *found;
      body_ = start + layout_.body;
      lines_before_ = line_number(text, body_) - 1;
      return;
    }
  }

  std::string name_;
  Layout layout_;
  Cloud wanted_;  // its attributes
  std::size_t body_ = 0, lines_before_ = 0, count_ = 0;
  std::optional<RowStream> rows_;
};

}  // namespace

std::unique_ptr<PointSource> text_source(const ByteView& bytes, const std::string& path, const ReadOptions& options) {
  constexpr std::size_t header_bytes = 4096;
  Array<char> scratch;
  if (is_ptx(bytes.get(0, std::min(bytes.size(), header_bytes), scratch))) return nullptr;
  return std::make_unique<TextSource>(bytes, path, options);
}

bool is_ptx(Bytes bytes) {
  constexpr std::size_t header_bytes = 4096;
  Lines lines(as_text(bytes).substr(0, header_bytes));
  std::string_view line;
  std::uint64_t count;
  for (int i = 0; i < 2; ++i)
    if (!lines.next(line) || !to_count(trimmed(line), count)) return false;
  for (int i = 0; i < 8; ++i)
    if (!lines.next(line) || !is_row_of(line, i < 4 ? 3 : 4)) return false;
  return true;
}

Cloud parse_text(Bytes bytes, const std::string& name, const ReadOptions& options, const Context& context) {
  const std::string_view text = as_text(bytes);
  check_encoding(text, name);
  if (is_ptx(bytes)) return parse_ptx(text, name, options, context);
  TextSource source(ByteView(bytes), name, options);
  return read_all(source, context);
}

}  // namespace isopach
