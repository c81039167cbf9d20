#include "isopach/io/stl.hpp"

#include <fmt/format.h>

#include <bit>

#include "isopach/base/error.hpp"
#include "isopach/io/scan.hpp"

namespace isopach {
namespace {

constexpr std::size_t header_bytes = 84;  // 80 of text, 4 of count
constexpr std::size_t facet_bytes = 50;   // normal, three corners, two bytes of attribute
constexpr bool swap_bytes = std::endian::native == std::endian::big;

// Numbers points in the order of first appearance; exactly equal ones get one number. Open addressing, linear probing.
class UniquePoints {
 public:
  explicit UniquePoints(Array<Point3>& points) : points_(points), slots_(1024, no_index) {}

  Index add(const Point3& p) {
    if (points_.size() * 2 >= slots_.size()) grow();
    std::size_t slot = find(p);
    if (slots_[slot] == no_index) {
      slots_[slot] = static_cast<Index>(points_.size());
      points_.push_back(p);
    }
    return slots_[slot];
  }

 private:
  static std::uint64_t bits(double x) { return std::bit_cast<std::uint64_t>(x == 0 ? 0.0 : x); }
  static bool same(const Point3& a, const Point3& b) {  // by bits, so that a NaN equals itself
    return bits(a.x) == bits(b.x) && bits(a.y) == bits(b.y) && bits(a.z) == bits(b.z);
  }
  static std::uint64_t hash(const Point3& p) {
    std::uint64_t h = 0;
    for (const double c : {p.x, p.y, p.z}) {
      h = (h ^ bits(c)) * 0x9E3779B97F4A7C15u;
      h ^= h >> 32;
    }
    return h;
  }
  [[nodiscard]] std::size_t find(const Point3& p) const {
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = hash(p) & mask;
    while (slots_[slot] != no_index && !same(points_[slots_[slot]], p)) slot = (slot + 1) & mask;
    return slot;
  }
  void grow() {
    slots_.assign(slots_.size() * 2, no_index);
    for (std::size_t i = 0; i < points_.size(); ++i) slots_[find(points_[i])] = static_cast<Index>(i);
  }

  Array<Point3>& points_;
  std::vector<Index> slots_;
};

std::uint64_t announced(Bytes bytes) { return load<std::uint32_t>(bytes.data() + 80, swap_bytes); }

bool is_binary_size(Bytes head, std::uint64_t size) {
  return head.size() >= header_bytes && size == header_bytes + facet_bytes * announced(head);
}

bool starts_as_text(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  return first != std::string_view::npos && lower_case(text.substr(first, 5)) == "solid";
}

class StlReader {
 public:
  StlReader(Bytes bytes, const std::string& name, const ReadOptions& options)
      : bytes_(bytes), name_(name), options_(options), unique_(cloud_.points) {
    cloud_.format = "stl";
  }

  Cloud read_binary(const Context& context) {
    if (bytes_.size() < header_bytes) fail("too short for an STL file: it is incomplete or damaged");
    const std::uint64_t count = announced(bytes_);
    if (count > (bytes_.size() - header_bytes) / facet_bytes)
      fail(fmt::format("{} triangles announced, but the file ends before: it is incomplete or damaged", count));
    if (bytes_.size() != header_bytes + facet_bytes * count)
      cloud_.notes.push_back(fmt::format("{}: bytes behind the last triangle were ignored", name_));
    for (std::uint64_t i = 0; i < count; ++i) {
      if (i % 65536 == 0) context.step("read", static_cast<double>(i) / static_cast<double>(count));
      const char* p = bytes_.data() + header_bytes + i * facet_bytes + 12;  // behind the normal
      std::array<Index, 3> face;
      for (Index& corner : face) {
        corner =
            unique_.add({load<float>(p, swap_bytes), load<float>(p + 4, swap_bytes), load<float>(p + 8, swap_bytes)});
        p += 12;
      }
      if (options_.faces) cloud_.faces.push_back(face);
    }
    return finish();
  }

  Cloud read_ascii(const Context& context) {
    Lines lines(as_text(bytes_));
    std::string_view line;
    std::vector<Index> loop;
    while (lines.next(line)) {
      if (lines.number() % 65536 == 0)
        context.step("read", static_cast<double>(lines.offset()) / static_cast<double>(bytes_.size()));
      const std::string_view content = trimmed(line);
      const std::string word = lower_case(content.substr(0, content.find_first_of(" \t")));
      if (word == "vertex") loop.push_back(unique_.add(read_vertex(content.substr(word.size()), lines.number())));
      if (word != "endloop") continue;
      if (loop.size() != 3)
        fail(fmt::format("line {}: a facet of {} corners: STL has triangles", lines.number(), loop.size()));
      if (options_.faces) add_fan(loop, cloud_.faces);
      loop.clear();
    }
    if (!loop.empty()) fail("ends within a facet: the file is incomplete or damaged");
    return finish();
  }

 private:
  [[noreturn]] void fail(const std::string& why) const { throw InputError(fmt::format("{}: {}", name_, why)); }

  [[nodiscard]] Point3 read_vertex(std::string_view text, std::size_t line) const {
    const auto fields = words(text);
    Point3 p{};
    if (fields.size() != 3 || !to_number(fields[0], p.x) || !to_number(fields[1], p.y) || !to_number(fields[2], p.z))
      fail(fmt::format("line {}: {} is not three numbers: correct the vertex", line, quoted(trimmed(text))));
    return p;
  }

  Cloud finish() {
    if (cloud_.points.empty()) fail("no triangles in it: it holds no points");
    return std::move(cloud_);
  }

  Bytes bytes_;
  const std::string& name_;
  const ReadOptions& options_;
  Cloud cloud_;
  UniquePoints unique_;
};

}  // namespace

bool is_stl(Bytes head, std::uint64_t size) {
  if (is_binary_size(head, size)) return true;
  constexpr std::size_t most = 4096;
  const std::string_view text = as_text(head).substr(0, most);
  if (!starts_as_text(text)) return false;
  const std::string lower = lower_case(text);
  return lower.find("facet") != std::string::npos || lower.find("endsolid") != std::string::npos;
}

Cloud parse_stl(Bytes bytes, const std::string& name, const ReadOptions& options, const Context& context) {
  StlReader reader(bytes, name, options);
  // Some programs begin binary files with "solid" too, so the size decides first.
  const bool ascii = !is_binary_size(bytes, bytes.size()) && starts_as_text(as_text(bytes));
  return ascii ? reader.read_ascii(context) : reader.read_binary(context);
}

}  // namespace isopach
