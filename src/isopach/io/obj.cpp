#include "isopach/io/obj.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "isopach/base/error.hpp"
#include "isopach/io/scan.hpp"

namespace isopach {
namespace {

class ObjReader {
 public:
  ObjReader(std::string_view text, const std::string& name, const ReadOptions& options)
      : lines_(text), text_(text), name_(name), options_(options) {
    for (const char* const color : {"red", "green", "blue"}) colors_.push_back({color, {}});
  }

  Cloud read(const Context& context) {
    cloud_.format = "obj";
    std::string_view line;
    while (next_line(line)) {
      if (lines_.number() % 65536 == 0)
        context.step("read", static_cast<double>(lines_.offset()) / static_cast<double>(text_.size()));
      const std::size_t first = line.find_first_not_of(" \t");
      if (first == std::string_view::npos || first + 1 >= line.size() || !is_blank(line[first + 1])) continue;
      if (line[first] == 'v')
        read_vertex(line.substr(first + 1));
      else if (line[first] == 'f' && options_.faces)
        read_face(line.substr(first + 1));
    }
    if (cloud_.points.empty()) throw InputError(fmt::format("{}: no points in it: expected lines \"v x y z\"", name_));
    check_faces();
    keep_colors();
    return std::move(cloud_);
  }

 private:
  [[noreturn]] void fail(const std::string& why) const {
    throw InputError(fmt::format("{}: line {}: {}", name_, lines_.number(), why));
  }

  // The next line, with those joined that a "\" at the end continues.
  bool next_line(std::string_view& line) {
    if (!lines_.next(line)) return false;
    if (line.empty() || line.back() != '\\') return true;
    joined_.assign(line.substr(0, line.size() - 1));
    while (lines_.next(line)) {
      const bool more = !line.empty() && line.back() == '\\';
      joined_ += ' ';
      joined_ += line.substr(0, line.size() - (more ? 1 : 0));
      if (!more) break;
    }
    line = joined_;
    return true;
  }

  void read_vertex(std::string_view line) {
    std::array<double, 7> numbers{};
    std::size_t count = 0;
    const char* p = line.data();
    const char* const end = p + line.size();
    for (;;) {
      while (p < end && is_blank(*p)) ++p;
      if (p == end || *p == '#' || count == numbers.size()) break;
      const char* const begin = p;
      if (!scan_number(p, end, numbers[count]) || (p < end && !is_blank(*p)))
        fail(fmt::format("{} is not a number: correct the vertex",
                         quoted({begin, static_cast<std::size_t>(end - begin)})));
      ++count;
    }
    if (count < 3) fail("a vertex needs x, y and z: complete the line");
    cloud_.points.push_back({numbers[0], numbers[1], numbers[2]});
    if (count >= 6) add_color(numbers.data() + count - 3);
  }

  void add_color(const double* rgb) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (!wanted(options_, colors_[k].name)) continue;
      colors_[k].values.resize(cloud_.points.size() - 1, std::numeric_limits<double>::quiet_NaN());
      colors_[k].values.push_back(rgb[k]);
    }
  }

  void keep_colors() {
    for (Attribute& color : colors_) {
      if (color.values.empty()) continue;
      color.values.resize(cloud_.points.size(), std::numeric_limits<double>::quiet_NaN());
      cloud_.attributes.push_back(std::move(color));
    }
  }

  void read_face(std::string_view line) {
    polygon_.clear();
    for (const std::string_view word : words(line.substr(0, line.find('#')))) {
      std::int64_t index = 0;
      if (!to_integer(word.substr(0, word.find('/')), index) || index == 0)
        fail(fmt::format("{} is not the number of a vertex: correct the face", quoted(word)));
      if (index < 0)
        index += static_cast<std::int64_t>(cloud_.points.size());
      else
        --index;
      if (index < 0 || static_cast<std::uint64_t>(index) >= no_index)
        fail(fmt::format("{} names no vertex: correct the face", quoted(word)));
      polygon_.push_back(static_cast<Index>(index));
    }
    add_fan(polygon_, cloud_.faces);
  }

  // At the end, because a face may stand before its vertices.
  void check_faces() const {
    for (const auto& face : cloud_.faces)
      for (const Index corner : face)
        if (corner >= cloud_.points.size())
          throw InputError(fmt::format("{}: a face names vertex {}, but there are {}: the file is damaged", name_,
                                       std::uint64_t{corner} + 1, cloud_.points.size()));
  }

  Lines lines_;
  std::string_view text_;
  const std::string& name_;
  const ReadOptions& options_;
  std::string joined_;
  std::vector<Index> polygon_;
  std::vector<Attribute> colors_;
  Cloud cloud_;
};

}  // namespace

bool is_obj(Bytes head) {
  Lines lines(as_text(head));
  std::string_view line;
  while (lines.next(line)) {
    const auto fields = words(line);
    if (fields.empty() || fields[0].front() == '#') continue;
    static constexpr std::string_view keywords[] = {"v", "vn", "vt", "f", "o", "g", "mtllib", "usemtl"};
    return std::find(std::begin(keywords), std::end(keywords), fields[0]) != std::end(keywords);
  }
  return false;
}

Cloud parse_obj(Bytes bytes, const std::string& name, const ReadOptions& options, const Context& context) {
  const std::string_view text = as_text(bytes);
  if (text.substr(0, 2) == "\xFF\xFE" || text.substr(0, 2) == "\xFE\xFF")
    throw InputError(fmt::format("{}: text in UTF-16: save it as UTF-8 or plain ASCII", name));
  return ObjReader(text, name, options).read(context);
}

}  // namespace isopach
