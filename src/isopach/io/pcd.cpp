#include "isopach/io/pcd.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <optional>

#include "isopach/base/error.hpp"
#include "isopach/io/rows.hpp"

namespace isopach {
namespace {

constexpr bool swap_bytes = std::endian::native == std::endian::big;

struct Field {
  std::string name;
  std::uint64_t size = 4, count = 1;
  char type = 'F';
  [[nodiscard]] std::uint64_t bytes() const { return size * count; }
};

// One wanted number of a row.
struct Wanted {
  std::size_t field = 0;
  std::uint64_t element = 0;  // within the field
  int target = 0;             // as in BinaryColumn
};

std::optional<Scalar> scalar_type(const Field& field) {
  const auto pick = [&](Scalar s1, Scalar s2, Scalar s4, Scalar s8) -> std::optional<Scalar> {
    switch (field.size) {
      case 1:
        return s1;
      case 2:
        return s2;
      case 4:
        return s4;
      case 8:
        return s8;
      default:
        return std::nullopt;
    }
  };
  if (field.type == 'I') return pick(Scalar::i8, Scalar::i16, Scalar::i32, Scalar::i64);
  if (field.type == 'U') return pick(Scalar::u8, Scalar::u16, Scalar::u32, Scalar::u64);
  if (field.type != 'F' || field.size < 4) return std::nullopt;
  return pick(Scalar::f32, Scalar::f32, Scalar::f32, Scalar::f64);
}

class PcdReader {
 public:
  PcdReader(Bytes bytes, const std::string& name, const ReadOptions& options)
      : bytes_(bytes), text_(as_text(bytes)), name_(name), options_(options) {}

  Cloud read(const Context& context) {
    cloud_.format = "pcd";
    read_header();
    check_header();
    choose_fields();
    if (data_ == "ascii")
      read_ascii();
    else if (data_ == "binary")
      read_binary(bytes_.subspan(body_));
    else if (data_ == "binary_compressed")
      read_compressed();
    else
      fail(fmt::format("DATA {} is unknown: expected ascii, binary or binary_compressed", quoted(data_)));
    context.step("read", 1);
    return std::move(cloud_);
  }

 private:
  [[noreturn]] void fail(const std::string& why) const { throw InputError(fmt::format("{}: {}", name_, why)); }

  // ---- header

  void read_header() {
    Lines lines(text_);
    std::string_view line;
    while (data_.empty()) {
      if (!lines.next(line)) fail("no DATA line in the header: the file is cut short or damaged");
      const auto fields = words(line);
      if (fields.empty() || fields[0].front() == '#') continue;
      read_header_line(fields, lines.number());
    }
    body_ = lines.offset();
  }

  void read_header_line(const std::vector<std::string_view>& line, std::size_t number) {
    const std::string_view key = line[0];
    const std::size_t values = line.size() - 1;
    if (key == "FIELDS" || key == "COLUMNS") {
      fields_.resize(values);
      for (std::size_t i = 0; i < values; ++i) fields_[i].name = line[i + 1];
    } else if (key == "SIZE" || key == "COUNT" || key == "TYPE") {
      if (values != fields_.size()) bad_line(key, number);
      for (std::size_t i = 0; i < values; ++i) read_field_value(key, line[i + 1], fields_[i], number);
    } else if (key == "WIDTH" || key == "HEIGHT" || key == "POINTS") {
      std::uint64_t& value = key == "WIDTH" ? width_ : key == "HEIGHT" ? height_ : points_;
      if (values < 1 || !to_count(line[1], value)) bad_line(key, number);
      points_given_ = points_given_ || key == "POINTS";
    } else if (key == "VIEWPOINT") {
      read_viewpoint(line);
    } else if (key == "DATA") {
      if (values < 1) bad_line(key, number);
      data_ = lower_case(line[1]);
    } else if (key != "VERSION") {
      bad_line(key, number);
    }
  }

  void read_field_value(std::string_view key, std::string_view value, Field& field, std::size_t number) const {
    if (key == "TYPE")
      field.type = value.front();
    else if (!to_count(value, key == "SIZE" ? field.size : field.count))
      bad_line(key, number);
  }

  [[noreturn]] void bad_line(std::string_view key, std::size_t number) const {
    fail(fmt::format("line {}: {} is not understood in a PCD header: correct the header", number, quoted(key)));
  }

  void read_viewpoint(const std::vector<std::string_view>& line) {
    static constexpr std::array<double, 7> identity = {0, 0, 0, 1, 0, 0, 0};
    bool same = line.size() == identity.size() + 1;
    for (std::size_t i = 0; same && i < identity.size(); ++i) {
      double value = 0;
      same = to_number(line[i + 1], value) && value == identity[i];
    }
    if (!same) cloud_.notes.push_back(fmt::format("{}: its VIEWPOINT is not applied to the points", name_));
  }

  void check_header() {
    if (fields_.empty()) fail("no FIELDS line in the header: the file is damaged");
    if (!points_given_) points_ = width_ * height_;
    if (points_ == 0) fail("no points in it: the header announces none");
    std::uint64_t numbers = 0;
    for (const Field& field : fields_) {
      if (field.size > 8 || field.count > bytes_.size())
        fail(fmt::format("field {} is absurdly large: the file is damaged", quoted(field.name)));
      stride_ += field.bytes();
      numbers += field.count;
    }
    // A number takes at least two bytes as text, but the last one may end with the file; LZF cannot shrink by more than
    // this, see read_compressed.
    const std::uint64_t left = bytes_.size() - body_;
    const bool ascii = data_ == "ascii";
    const std::uint64_t most = ascii ? left + 1 : data_ == "binary_compressed" ? left * lzf_ratio : left;
    const std::uint64_t row = ascii ? numbers * 2 : stride_;
    if (row == 0 || points_ > most / row)
      fail(fmt::format("{} points announced, but the file ends before: it is incomplete or damaged", points_));
  }

  void choose_fields() {
    std::array<bool, 3> found{};
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      const std::string name = lower_case(fields_[i].name);
      const int axis = name == "x" ? 0 : name == "y" ? 1 : name == "z" ? 2 : -1;
      if (axis >= 0 && !found[static_cast<std::size_t>(axis)] && fields_[i].count == 1) {
        found[static_cast<std::size_t>(axis)] = true;
        choose(i, 0, axis);
      } else if (axis < 0 && name != "_") {  // "_" is padding
        choose_attributes(i);
      }
    }
    if (!(found[0] && found[1] && found[2])) fail("the fields have no x, y and z: name the three coordinates so");
  }

  void choose_attributes(std::size_t i) {
    const std::string base = attribute_name(fields_[i].name);
    const bool one = fields_[i].count == 1;
    if (!one && !options_.all_attributes && options_.attributes.empty()) return;
    for (std::uint64_t k = 0; k < fields_[i].count; ++k) {
      const std::string name = one ? base : fmt::format("{}_{}", base, k);
      if (!wanted(options_, name) || (one && cloud_.find_attribute(name) != nullptr)) continue;
      choose(i, k, 3 + static_cast<int>(cloud_.attributes.size()));
      cloud_.attributes.push_back({name, {}});
    }
  }

  void choose(std::size_t field, std::uint64_t element, int target) {
    if (!scalar_type(fields_[field]))
      fail(fmt::format("field {} has type {} of {} bytes: expected I, U or F of 1, 2, 4 or 8 bytes",
                       quoted(fields_[field].name), quoted({&fields_[field].type, 1}), fields_[field].size));
    wanted_.push_back({field, element, target});
  }

  // ---- body

  void read_ascii() {
    const std::size_t length = offset_after_rows(text_.substr(body_), points_, false);
    if (length == std::string_view::npos)
      fail(fmt::format("{} points announced, but the file ends before: it is incomplete or damaged", points_));
    RowFormat format;
    format.comments = false;
    format.separator = first_row_separator();
    format.targets.resize(targets_size(), -1);
    for (const Wanted& w : wanted_) format.targets[column(w)] = w.target;
    parse_rows(text_, body_, body_ + length, format, name_, cloud_);
  }

  [[nodiscard]] std::size_t column(const Wanted& w) const {
    std::size_t result = w.element;
    for (std::size_t i = 0; i < w.field; ++i) result += fields_[i].count;
    return result;
  }

  [[nodiscard]] std::size_t targets_size() const {
    std::size_t size = 0;
    for (const Wanted& w : wanted_) size = std::max(size, column(w) + 1);
    return size;
  }

  [[nodiscard]] char first_row_separator() const {  // blanks by the format, commas from some programs
    Lines lines(text_.substr(body_));
    std::string_view line;
    while (lines.next(line))
      if (!trimmed(line).empty()) return line.find(',') != std::string_view::npos ? ',' : ' ';
    return ' ';
  }

  void resize() {
    cloud_.points.resize(points_);
    for (Attribute& a : cloud_.attributes) a.values.resize(points_);
  }

  [[nodiscard]] BinaryColumn binary_column(const Wanted& w) const {
    BinaryColumn column{0, *scalar_type(fields_[w.field]), w.target};
    for (std::size_t i = 0; i < w.field; ++i) column.offset += fields_[i].bytes();
    column.offset += w.element * fields_[w.field].size;
    return column;
  }

  void read_binary(Bytes rows) {
    resize();
    std::vector<BinaryColumn> columns;
    for (const Wanted& w : wanted_) columns.push_back(binary_column(w));
    load_rows(rows.data(), points_, stride_, columns, swap_bytes, cloud_);
  }

  void read_compressed() {
    constexpr std::size_t sizes = 8;
    if (bytes_.size() - body_ < sizes) fail("ends before its compressed points: it is incomplete or damaged");
    const auto packed = load<std::uint32_t>(bytes_.data() + body_, swap_bytes);
    const auto unpacked = load<std::uint32_t>(bytes_.data() + body_ + 4, swap_bytes);
    if (packed > bytes_.size() - body_ - sizes || unpacked != points_ * stride_ || unpacked / lzf_ratio > packed)
      fail("the sizes of its compressed points do not fit the header: it is incomplete or damaged");
    Array<char> fields(unpacked);
    if (!decode_lzf(bytes_.subspan(body_ + sizes, packed), fields))
      fail("its compressed points do not decode: it is damaged");
    resize();
    for (const Wanted& w : wanted_) {  // field after field: each is an array of its own
      BinaryColumn column = binary_column(w);
      std::size_t start = 0;
      for (std::size_t i = 0; i < w.field; ++i) start += fields_[i].bytes() * points_;
      column.offset = w.element * fields_[w.field].size;
      load_rows(fields.data() + start, points_, fields_[w.field].bytes(), {column}, swap_bytes, cloud_);
    }
  }

  // The longest reference of LZF is three bytes for 264.
  static constexpr std::uint64_t lzf_ratio = 88;

  Bytes bytes_;
  std::string_view text_;
  const std::string& name_;
  const ReadOptions& options_;
  std::vector<Field> fields_;
  std::vector<Wanted> wanted_;
  std::string data_;
  std::uint64_t width_ = 0, height_ = 1, points_ = 0, stride_ = 0;
  bool points_given_ = false;
  std::size_t body_ = 0;
  Cloud cloud_;
};

}  // namespace

bool is_pcd(Bytes head) {
  Lines lines(as_text(head));
  std::string_view line;
  while (lines.next(line)) {
    const auto fields = words(line);
    if (fields.empty()) continue;
    if (fields[0].front() == '#') {
      if (line.find(".PCD") != std::string_view::npos) return true;
      continue;
    }
    double version;
    return fields.size() == 2 && fields[0] == "VERSION" && to_number(fields[1], version) && lines.next(line) &&
           line.substr(0, 6) == "FIELDS";
  }
  return false;
}

Cloud parse_pcd(Bytes bytes, const std::string& name, const ReadOptions& options, const Context& context) {
  return PcdReader(bytes, name, options).read(context);
}

// LZF: a control byte below 32 is followed by that many literal bytes plus one; otherwise its upper three bits are the
// length of a reference minus two (7: the next byte is added), its lower five and the next byte the distance minus one.
bool decode_lzf(Bytes input, std::span<char> output) {
  std::size_t in = 0, out = 0;
  const auto next = [&] { return static_cast<std::size_t>(static_cast<unsigned char>(input[in++])); };
  while (in < input.size()) {
    const std::size_t control = next();
    if (control < 32) {
      const std::size_t length = control + 1;
      if (length > input.size() - in || length > output.size() - out) return false;
      std::memcpy(output.data() + out, input.data() + in, length);
      in += length;
      out += length;
      continue;
    }
    std::size_t length = control >> 5;
    if (length == 7) {
      if (in == input.size()) return false;
      length += next();
    }
    length += 2;
    if (in == input.size()) return false;
    const std::size_t distance = ((control & 31) << 8) + next() + 1;
    if (distance > out || length > output.size() - out) return false;
    for (std::size_t i = 0; i < length; ++i, ++out) output[out] = output[out - distance];  // may overlap itself
  }
  return out == output.size();
}

}  // namespace isopach
