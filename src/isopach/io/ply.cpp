#include "isopach/io/ply.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

#include "isopach/base/error.hpp"
#include "isopach/io/point_source.hpp"
#include "isopach/io/rows.hpp"

namespace isopach {
namespace {

enum class Encoding { ascii, little, big };

struct Property {
  std::string name;  // lower case
  Scalar type = Scalar::f32;
  std::optional<Scalar> count_type;  // set for a list
  int target = -1;                   // vertices: 0, 1, 2 = x, y, z; 3 + k = attribute k. Faces: 0 = the corners
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;

  [[nodiscard]] bool has_list() const {
    return std::any_of(properties.begin(), properties.end(),
                       [](const Property& p) { return p.count_type.has_value(); });
  }
  // Bytes a binary row takes at least (exactly, if it has no list).
  [[nodiscard]] std::size_t stride() const {
    std::size_t bytes = 0;
    for (const Property& p : properties) bytes += size_of(p.count_type.value_or(p.type));
    return bytes;
  }
};

struct Header {
  Encoding encoding = Encoding::ascii;
  std::vector<Element> elements;
  std::size_t size = 0;  // bytes
};

std::optional<Scalar> scalar_type(std::string_view word) {
  struct Name {
    std::string_view word;
    Scalar type;
  };
  static constexpr Name names[] = {{"char", Scalar::i8},     {"int8", Scalar::i8},    {"uchar", Scalar::u8},
                                   {"uint8", Scalar::u8},    {"short", Scalar::i16},  {"int16", Scalar::i16},
                                   {"ushort", Scalar::u16},  {"uint16", Scalar::u16}, {"int", Scalar::i32},
                                   {"int32", Scalar::i32},   {"uint", Scalar::u32},   {"uint32", Scalar::u32},
                                   {"int64", Scalar::i64},   {"uint64", Scalar::u64}, {"float", Scalar::f32},
                                   {"float32", Scalar::f32}, {"double", Scalar::f64}, {"float64", Scalar::f64}};
  for (const Name& name : names)
    if (name.word == word) return name.type;
  return std::nullopt;
}

// Where the numbers of a binary row without lists go.
std::vector<BinaryColumn> binary_columns(const Element& element) {
  std::vector<BinaryColumn> columns;
  std::size_t offset = 0;
  for (const Property& property : element.properties) {
    if (property.target >= 0) columns.push_back({offset, property.type, property.target});
    offset += size_of(property.type);
  }
  return columns;
}

// The columns of an ascii row up to the last that is wanted; nothing if one of them comes after a list.
std::optional<RowFormat> row_format(const Element& element) {
  const auto first_list = std::find_if(element.properties.begin(), element.properties.end(),
                                       [](const Property& p) { return p.count_type.has_value(); });
  if (std::any_of(first_list, element.properties.end(), [](const Property& p) { return p.target >= 0; }))
    return std::nullopt;
  RowFormat format;
  format.comments = false;
  for (auto p = element.properties.begin(); p != first_list; ++p) format.targets.push_back(p->target);
  while (format.targets.back() < 0) format.targets.pop_back();
  return format;
}

[[noreturn]] void cut_short(const Element& element, const std::string& name) {
  throw InputError(fmt::format("{}: {} of element {} announced, but the file ends before: it is incomplete or damaged",
                               name, element.count, quoted(element.name)));
}

class PlyReader {
 public:
  PlyReader(Bytes bytes, const std::string& name, const ReadOptions& options)
      : bytes_(bytes), text_(as_text(bytes)), name_(name), options_(options) {}

  /// The header alone, and what of the file is to be kept.
  void prepare() {
    cloud_.format = "ply";
    read_header();
    choose_targets();
    offset_ = header_.size;
  }
  [[nodiscard]] const Header& header() const { return header_; }
  [[nodiscard]] const Element& vertices() const { return *vertices_; }
  /// Format, unit, CRS and attributes; after read, points.
  [[nodiscard]] const Cloud& cloud() const { return cloud_; }

  Cloud read(const Context& context) {
    prepare();
    for (const Element& element : header_.elements) {
      read_element(element);
      context.step("read", static_cast<double>(offset_) / static_cast<double>(bytes_.size()));
      if (&element == last_needed_) break;
    }
    return std::move(cloud_);
  }

 private:
  [[noreturn]] void fail(const std::string& why) const { throw InputError(fmt::format("{}: {}", name_, why)); }

  // ---- header

  void read_header() {
    Lines lines(text_);
    std::string_view line;
    if (!lines.next(line) || trimmed(line) != "ply") fail("does not start with \"ply\": not a PLY file, or damaged");
    bool format_seen = false;
    while (lines.next(line)) {
      const auto fields = words(line);
      if (fields.empty()) continue;
      if (fields[0] == "end_header") {
        header_.size = lines.offset();
        if (!format_seen) fail("no \"format\" line in the header: the file is damaged");
        return;
      }
      if (fields[0] == "format")
        format_seen = read_format(fields);
      else if (fields[0] == "element")
        read_element_line(fields, lines.number());
      else if (fields[0] == "property")
        read_property_line(fields, lines.number());
      else if (fields[0] == "comment" || fields[0] == "obj_info")
        read_comment(trimmed(line).substr(fields[0].size()));
      else
        bad_line(fields[0], lines.number());
    }
    fail("no \"end_header\" line: the file is cut short or has line ends that are neither LF nor CRLF");
  }

  [[noreturn]] void bad_line(std::string_view what, std::size_t number) const {
    fail(fmt::format("line {}: {} is not understood in a PLY header: correct the header", number, quoted(what)));
  }

  bool read_format(const std::vector<std::string_view>& fields) {
    const std::string_view kind = fields.size() > 1 ? fields[1] : std::string_view();
    if (kind == "ascii")
      header_.encoding = Encoding::ascii;
    else if (kind == "binary_little_endian")
      header_.encoding = Encoding::little;
    else if (kind == "binary_big_endian")
      header_.encoding = Encoding::big;
    else
      fail(
          fmt::format("format {} is unknown: expected ascii, binary_little_endian or binary_big_endian", quoted(kind)));
    return true;
  }

  void read_element_line(const std::vector<std::string_view>& fields, std::size_t number) {
    Element element;
    if (fields.size() < 3 || !to_count(fields[2], element.count)) bad_line("element", number);
    element.name = lower_case(fields[1]);
    header_.elements.push_back(element);
  }

  void read_property_line(const std::vector<std::string_view>& fields, std::size_t number) {
    if (header_.elements.empty()) bad_line("property", number);
    const bool list = fields.size() > 1 && fields[1] == "list";
    if (fields.size() < (list ? 5u : 3u)) bad_line("property", number);
    Property property;
    const auto type = scalar_type(fields[list ? 3 : 1]);
    if (!type) bad_line(fields[list ? 3 : 1], number);
    property.type = *type;
    if (list) {
      property.count_type = scalar_type(fields[2]);
      if (!property.count_type || *property.count_type >= Scalar::f32) bad_line(fields[2], number);
    }
    property.name = lower_case(fields[list ? 4 : 2]);
    header_.elements.back().properties.push_back(property);
    original_names_.emplace_back(fields[list ? 4 : 2]);
  }

  void read_comment(std::string_view comment) {
    comment = trimmed(comment);
    const std::size_t end = comment.find_first_of(":= ");
    if (end == std::string_view::npos) return;
    const std::string key = lower_case(comment.substr(0, end));
    const std::string_view value =
        trimmed(comment.substr(std::min(comment.find_first_not_of(":= ", end), comment.size())));
    if (key == "crs") {
      cloud_.crs = value;
      return;
    }
    const std::string unit = lower_case(value);
    for (const char* const known : {"m", "mm", "ft", "us-ft", "deg"}) {
      if (unit != known) continue;
      if (key == "unit" || key == "units") cloud_.unit = known;
      if (key == "unit" || key == "units" || key == "vertical_unit") cloud_.vertical_unit = known;
    }
  }

  // ---- what to keep

  void choose_targets() {
    std::size_t first_name = 0;
    for (Element& element : header_.elements) {
      if (element.name == "vertex" && vertices_ == nullptr) choose_vertex_targets(element, first_name);
      if (element.name == "face" && options_.faces) choose_face_target(element);
      first_name += element.properties.size();
    }
    if (vertices_ == nullptr) fail("no element \"vertex\" in the header: it holds no points");
    if (vertices_->count == 0) fail("no points in it: \"element vertex 0\"");
  }

  void choose_vertex_targets(Element& element, std::size_t first_name) {
    vertices_ = last_needed_ = &element;
    std::array<bool, 3> found{};
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      Property& property = element.properties[i];
      if (property.count_type) continue;
      const int axis = property.name == "x" ? 0 : property.name == "y" ? 1 : property.name == "z" ? 2 : -1;
      if (axis >= 0 && !found[static_cast<std::size_t>(axis)]) {
        found[static_cast<std::size_t>(axis)] = true;
        property.target = axis;
        continue;
      }
      const std::string attribute = attribute_name(original_names_[first_name + i]);
      if (axis >= 0 || !wanted(options_, attribute) || cloud_.find_attribute(attribute) != nullptr) continue;
      property.target = 3 + static_cast<int>(cloud_.attributes.size());
      cloud_.attributes.push_back({attribute, {}});
    }
    if (!(found[0] && found[1] && found[2])) fail("the vertices have no x, y and z: name the three coordinates so");
  }

  void choose_face_target(Element& element) {
    if (vertices_ != nullptr && vertices_->count > no_index)
      fail("more points than the faces of this build can number: build with ISOPACH_INDEX_BITS=64");
    for (Property& property : element.properties)
      if (property.count_type && (property.name == "vertex_indices" || property.name == "vertex_index")) {
        property.target = 0;
        last_needed_ = &element;
        return;
      }
  }

  // ---- body

  void read_element(const Element& element) {
    const std::size_t left = bytes_.size() - std::min(offset_, bytes_.size());
    const bool ascii = header_.encoding == Encoding::ascii;
    // A row takes at least this much, so a count beyond it is known to be wrong before any memory is taken.
    const std::size_t least = ascii ? element.properties.size() * 2 : element.stride();
    if (least > 0 && element.count > (left + 1) / least) cut_short(element);
    if (&element == vertices_) {
      if (ascii)
        read_ascii_vertices(element);
      else
        read_binary_vertices(element);
    } else {
      if (ascii)
        read_ascii_other(element);
      else
        read_binary_other(element);
    }
  }

  [[noreturn]] void cut_short(const Element& element) const { isopach::cut_short(element, name_); }

  void resize_vertices(const Element& element) {
    cloud_.points.resize(element.count);
    for (Attribute& attribute : cloud_.attributes) attribute.values.resize(element.count);
  }

  void put(const Property& property, std::size_t row, double value) {
    Point3& p = cloud_.points[row];
    if (property.target == 0)
      p.x = value;
    else if (property.target == 1)
      p.y = value;
    else if (property.target == 2)
      p.z = value;
    else if (property.target > 2)
      cloud_.attributes[static_cast<std::size_t>(property.target - 3)].values[row] = value;
  }

  void read_binary_vertices(const Element& element) {
    resize_vertices(element);
    const bool swap = (header_.encoding == Encoding::big) == (std::endian::native == std::endian::little);
    if (element.has_list()) {
      for (std::size_t row = 0; row < element.count; ++row)
        step_binary_row(element, swap,
                        [&](const Property& p, const char* at) { put(p, row, load_scalar(at, p.type, swap)); });
      return;
    }
    const std::size_t stride = element.stride();
    if (element.count * stride > bytes_.size() - offset_) cut_short(element);
    load_rows(bytes_.data() + offset_, element.count, stride, binary_columns(element), swap, cloud_);
    offset_ += element.count * stride;
  }

  void read_binary_other(const Element& element) {
    const bool swap = (header_.encoding == Encoding::big) == (std::endian::native == std::endian::little);
    if (!element.has_list()) {
      if (element.count * element.stride() > bytes_.size() - offset_) cut_short(element);
      offset_ += element.count * element.stride();
      return;
    }
    std::vector<Index> corners;
    for (std::uint64_t row = 0; row < element.count; ++row) {
      corners.clear();
      step_binary_row(element, swap, [&](const Property& p, const char* at) {
        corners.push_back(corner(load_scalar(at, p.type, swap)));
      });
      add_fan(corners, cloud_.faces);
    }
  }

  // Calls keep(property, address) for each wanted number of the row at offset_, which it then steps over.
  template <class Keep>
  void step_binary_row(const Element& element, bool swap, Keep&& keep) {
    for (const Property& property : element.properties) {
      std::size_t count = 1;
      if (property.count_type) {
        const double read = load_scalar(take(element, size_of(*property.count_type)), *property.count_type, swap);
        if (read < 0 || read > static_cast<double>(bytes_.size())) cut_short(element);
        count = static_cast<std::size_t>(read);
      }
      const std::size_t size = size_of(property.type);
      const char* const at = take(element, count * size);
      if (property.target >= 0)
        for (std::size_t i = 0; i < count; ++i) keep(property, at + i * size);
    }
  }

  const char* take(const Element& element, std::size_t size) {
    if (size > bytes_.size() - offset_) cut_short(element);
    const char* const at = bytes_.data() + offset_;
    offset_ += size;
    return at;
  }

  void read_ascii_vertices(const Element& element) {
    const std::optional<RowFormat> format = row_format(element);
    if (!format) {
      read_ascii_list_vertices(element);
      return;
    }
    const std::size_t length = offset_after_rows(text_.substr(offset_), element.count, false);
    if (length == std::string_view::npos) cut_short(element);
    parse_rows(text_, offset_, offset_ + length, *format, name_, cloud_);
    offset_ += length;
  }

  void read_ascii_list_vertices(const Element& element) {
    resize_vertices(element);
    for (std::size_t row = 0; row < element.count; ++row)
      step_ascii_row(element, [&](const Property& p, double value) { put(p, row, value); });
  }

  void read_ascii_other(const Element& element) {
    if (element.properties.empty()) return;
    if (std::none_of(element.properties.begin(), element.properties.end(),
                     [](const Property& p) { return p.target >= 0; })) {
      const std::size_t length = offset_after_rows(text_.substr(offset_), element.count, false);
      if (length == std::string_view::npos) cut_short(element);
      offset_ += length;
      return;
    }
    std::vector<Index> corners;
    for (std::uint64_t row = 0; row < element.count; ++row) {
      corners.clear();
      step_ascii_row(element, [&](const Property&, double value) { corners.push_back(corner(value)); });
      add_fan(corners, cloud_.faces);
    }
  }

  // Calls keep(property, value) for each wanted number of the next row that is not blank.
  template <class Keep>
  void step_ascii_row(const Element& element, Keep&& keep) {
    std::string_view line;
    std::size_t line_offset = 0;
    do {
      Lines lines(text_.substr(offset_));
      line_offset = offset_;
      if (!lines.next(line)) cut_short(element);
      offset_ += lines.offset();
    } while (trimmed(line).empty());
    const char* p = line.data();
    const char* const end = p + line.size();
    for (const Property& property : element.properties) {
      double count = 1;
      if (property.count_type) count = next_number(p, end, line_offset);
      if (!(count >= 0 && count <= static_cast<double>(line.size()))) bad_row(line_offset);
      for (double i = 0; i < count; ++i) {
        const double value = next_number(p, end, line_offset);
        if (property.target >= 0) keep(property, value);
      }
    }
  }

  double next_number(const char*& p, const char* end, std::size_t line_offset) const {
    while (p < end && is_blank(*p)) ++p;
    double value = 0;
    if (!scan_number(p, end, value) || (p < end && !is_blank(*p))) bad_row(line_offset);
    return value;
  }

  [[noreturn]] void bad_row(std::size_t line_offset) const {
    fail(fmt::format("line {}: not the numbers its header announces: the file is damaged",
                     line_number(text_, line_offset)));
  }

  [[nodiscard]] Index corner(double value) const {
    if (!(value >= 0 && value < static_cast<double>(vertices_->count)) || value != std::floor(value))
      fail(fmt::format("a face names vertex {}, but there are {}: the file is damaged", value, vertices_->count));
    return static_cast<Index>(value);
  }

  Bytes bytes_;
  std::string_view text_;
  const std::string& name_;
  const ReadOptions& options_;
  Header header_;
  std::vector<std::string> original_names_;  // of all properties, in the order of the header
  const Element* vertices_ = nullptr;
  const Element* last_needed_ = nullptr;  // nothing behind it is read
  std::size_t offset_ = 0;
  Cloud cloud_;
};

// Vertices without lists, with nothing before them or, in a binary file, elements without lists.
class PlySource : public PointSource {
 public:
  PlySource(const ByteView& bytes, const std::string& name, const ReadOptions& options)
      : bytes_(bytes), name_(name), reader_(head_of(bytes), name_, options) {
    reader_.prepare();
  }

  /// Whether it can read the file; where it can, it finds out where the vertices stand.
  [[nodiscard]] bool finds_vertices() {
    const Element& vertices = reader_.vertices();
    const bool ascii = reader_.header().encoding == Encoding::ascii;
    at_ = reader_.header().size;
    for (const Element& element : reader_.header().elements) {
      if (ascii ? &element != &vertices : element.has_list()) return false;
      check_count(element);
      if (&element == &vertices) break;
      at_ += element.count * element.stride();
    }
    if (!ascii) return true;
    const std::optional<RowFormat> format = row_format(vertices);
    if (format) rows_.emplace(bytes_, at_, header_lines(), *format, name_);
    return format.has_value();
  }

  void begin(Cloud& cloud) override {
    const Cloud& known = reader_.cloud();
    cloud.format = known.format, cloud.crs = known.crs;
    cloud.unit = known.unit, cloud.vertical_unit = known.vertical_unit;
    cloud.attributes = known.attributes;
  }

  bool append(Cloud& cloud, std::size_t most, const Context& context) override {
    const Element& vertices = reader_.vertices();
    const std::size_t count = std::min<std::size_t>(most, vertices.count - done_);
    if (count == 0) return false;
    const std::size_t got = rows_ ? rows_->append(cloud, count) : append_binary(cloud, count);
    if (got == 0) cut_short(vertices, name_);
    done_ += got;
    context.step("read", static_cast<double>(done_) / static_cast<double>(vertices.count));
    return true;
  }

  void end(Cloud& cloud) override {
    if (rows_) rows_->note(cloud);
  }

  void describe(FileSummary& summary) const override { summary.points = reader_.vertices().count; }

 private:
  // The first bytes of the file, with all of its header.
  Bytes head_of(const ByteView& bytes) {
    constexpr std::size_t first = std::size_t{1} << 16;
    for (std::size_t length = first;; length *= 2) {
      const bool all = length >= bytes.size();
      const Bytes head = bytes.get(0, all ? bytes.size() : length, head_);
      const std::size_t end = as_text(head).find("end_header");
      const bool whole = end != std::string_view::npos && as_text(head).find('\n', end) != std::string_view::npos;
      if (all || whole || length >= max_input()) return head;
    }
  }

  [[nodiscard]] std::size_t header_lines() const {
    Array<char> scratch;
    const std::size_t size = reader_.header().size;
    return line_number(as_text(bytes_.get(0, size, scratch)), size) - 1;
  }

  // A count beyond the size of the file is known to be wrong before any memory is taken.
  void check_count(const Element& element) const {
    const bool ascii = reader_.header().encoding == Encoding::ascii;
    const std::size_t left = bytes_.size() - std::min<std::size_t>(at_, bytes_.size());
    const std::size_t least = ascii ? element.properties.size() * 2 : element.stride();
    if (least > 0 && element.count > (left + (ascii ? 1 : 0)) / least) cut_short(element, name_);
  }

  std::size_t append_binary(Cloud& cloud, std::size_t most) {
    const Element& vertices = reader_.vertices();
    const bool swap = (reader_.header().encoding == Encoding::big) == (std::endian::native == std::endian::little);
    constexpr std::size_t bytes_at_once = std::size_t{64} << 20;
    const std::size_t stride = vertices.stride();
    const std::size_t count = std::min(most, std::max<std::size_t>(1, bytes_at_once / stride));
    const Bytes rows = bytes_.get(at_ + done_ * stride, count * stride, scratch_);
    cloud.points.resize(cloud.points.size() + count);
    for (Attribute& attribute : cloud.attributes) attribute.values.resize(cloud.points.size());
    load_rows(rows.data(), count, stride, binary_columns(vertices), swap, cloud);
    return count;
  }

  ByteView bytes_;
  std::string name_;
  Array<char> head_, scratch_;
  PlyReader reader_;
  std::size_t at_ = 0, done_ = 0;
  std::optional<RowStream> rows_;  // of an ascii file
};

}  // namespace

std::unique_ptr<PointSource> ply_source(const ByteView& bytes, const std::string& path, const ReadOptions& options) {
  if (options.faces) return nullptr;
  auto source = std::make_unique<PlySource>(bytes, path, options);
  if (!source->finds_vertices()) return nullptr;
  return source;
}

Cloud parse_ply(Bytes bytes, const std::string& name, const ReadOptions& options, const Context& context) {
  return PlyReader(bytes, name, options).read(context);
}

}  // namespace isopach
