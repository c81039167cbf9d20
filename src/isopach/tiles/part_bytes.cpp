#include "isopach/tiles/part_bytes.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "isopach/base/error.hpp"

namespace isopach {
namespace {

constexpr std::uint64_t magic_of_part = 0x3174726170697369, magic_of_cells = 0x31736c6c65637369;

std::uint64_t checksum(std::span<const char> bytes) {  // FNV-1a, over words
  std::uint64_t hash = 0xcbf29ce484222325;
  for (std::size_t i = 0; i + 8 <= bytes.size(); i += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + i, sizeof word);
    hash = (hash ^ word) * 0x100000001b3;
    hash ^= hash >> 29;
  }
  return hash ^ bytes.size() * 0x9e3779b97f4a7c15;
}

/// Everything begins at a multiple of eight.
class Writer {
 public:
  template <class T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    align();
  }
  void put(const FixedSum& sum) { put(sum.words()); }
  void put(const std::string& text) { put_all(std::span<const char>(text)); }
  template <class T>
  void put_all(std::span<const T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    put(static_cast<std::uint64_t>(values.size()));
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
    align();
  }
  [[nodiscard]] std::string take() { return std::move(bytes_); }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  void align() { bytes_.append((8 - bytes_.size() % 8) % 8, '\0'); }
  std::string bytes_;
};

class Reader {
 public:
  Reader(std::span<const char> bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  template <class T>
  void get(T& value) {
    std::memcpy(&value, take(sizeof value), sizeof value);
  }
  void get(FixedSum& sum) {
    std::array<std::uint64_t, 4> words{};
    get(words);
    sum = FixedSum::of_words(words);
  }
  template <class T>
  std::span<const T> all() {
    std::uint64_t size = 0;
    get(size);
    if (size > bytes_.size() / sizeof(T)) refuse();
    return {reinterpret_cast<const T*>(take(static_cast<std::size_t>(size) * sizeof(T))),
            static_cast<std::size_t>(size)};
  }
  template <class T>
  void get_all(Array<T>& values) {
    const std::span<const T> found = all<T>();
    values.assign(found.begin(), found.end());
  }
  void expect(std::uint64_t magic, const std::string& job) {
    std::uint64_t found = 0;
    get(found);
    if (found != magic) refuse();
    const std::span<const char> of = all<char>();
    if (std::string(of.begin(), of.end()) != job)
      throw InputError(name_ + ": this is of another job: run the tile again (isopach tile run)");
  }
  void expect_end() const {
    if (at_ != bytes_.size()) refuse();
  }
  [[noreturn]] void refuse() const {
    throw InputError(name_ + ": this is no whole part of a tile: remove it, and run the tile again (isopach tile run)");
  }

 private:
  const char* take(std::size_t size) {
    if (size > bytes_.size() - at_) refuse();
    const char* found = bytes_.data() + at_;
    at_ += size;
    at_ += (8 - at_ % 8) % 8;
    if (at_ > bytes_.size()) at_ = bytes_.size();
    return found;
  }
  std::span<const char> bytes_;
  const std::string& name_;
  std::size_t at_ = 0;
};

template <class T>
void put_all(Writer& to, const Array<T>& values) {
  to.put_all(std::span<const T>(values));
}

void put(Writer& to, const ScanPart& scan) {
  put_all(to, scan.xy), put_all(to, scan.z), put_all(to, scan.spread), put_all(to, scan.in_t), put_all(to, scan.asked);
  put_all(to, scan.certified), put_all(to, scan.known);
  to.put(scan.nodes), to.put(scan.triangles), to.put(scan.border_area);
  const DetailSums& sums = scan.detail.as_coarser;
  to.put(sums.area), to.put(sums.above), to.put(sums.below), to.put(sums.averaged), to.put(sums.bare);
  to.put(scan.detail.area), to.put(static_cast<std::uint64_t>(scan.detail.nodes));
  to.put(scan.cleaning), to.put(scan.layers.state());
  put_all(to, scan.points), to.put(scan.compared);
}

void get(Reader& from, ScanPart& scan) {
  from.get_all(scan.xy), from.get_all(scan.z), from.get_all(scan.spread), from.get_all(scan.in_t);
  from.get_all(scan.asked), from.get_all(scan.certified), from.get_all(scan.known);
  from.get(scan.nodes), from.get(scan.triangles), from.get(scan.border_area);
  DetailSums& sums = scan.detail.as_coarser;
  from.get(sums.area), from.get(sums.above), from.get(sums.below), from.get(sums.averaged), from.get(sums.bare);
  std::uint64_t nodes = 0;
  from.get(scan.detail.area), from.get(nodes);
  scan.detail.nodes = static_cast<std::size_t>(nodes);
  LayerCheck::State layers;
  from.get(scan.cleaning), from.get(layers);
  scan.layers = LayerCheck(layers);
  from.get_all(scan.points), from.get(scan.compared);
}

/// Numbers that stay within the arrays they are of.
bool is_whole(const ScanPart& scan, std::uint64_t nodes_of_t) {
  const std::size_t n = scan.xy.size();
  const auto below = [](const auto& values, std::uint64_t end) {
    return std::all_of(values.begin(), values.end(), [&](Index v) { return v < end; });
  };
  return scan.z.size() == n && scan.in_t.size() == n && scan.asked.size() == n &&
         (scan.spread.empty() || scan.spread.size() == n) && (scan.points.empty() || scan.points.size() == n) &&
         scan.known.size() == scan.certified.size() && below(scan.in_t, nodes_of_t) &&
         std::all_of(scan.certified.begin(), scan.certified.end(), [&](const Corners& v) { return below(v, n); });
}

}  // namespace

std::string bytes_of(const Part& part, const std::string& job) {
  Writer to;
  to.put(magic_of_part), to.put(job), to.put(part.square);
  for (const ScanPart& scan : part.scan) put(to, scan);
  to.put(part.nodes), to.put(part.cells), to.put(part.joining), put_all(to, part.open);
  to.put(checksum(std::span<const char>(to.bytes())));
  return to.take();
}

Part part_of(std::span<const char> bytes, const std::string& job, const std::string& name) {
  Reader from(bytes, name);
  from.expect(magic_of_part, job);
  std::uint64_t found = 0;
  if (bytes.size() < 8 || bytes.size() % 8 != 0) from.refuse();
  std::memcpy(&found, bytes.data() + bytes.size() - 8, sizeof found);
  if (found != checksum(bytes.first(bytes.size() - 8))) from.refuse();
  Part part;
  from.get(part.square);
  for (ScanPart& scan : part.scan) get(from, scan);
  from.get(part.nodes), from.get(part.cells), from.get(part.joining), from.get_all(part.open);
  from.get(found);
  from.expect_end();
  const std::size_t nodes = part.scan[0].xy.size() + part.scan[1].xy.size();
  const auto holds = [&](const Corners& v) { return v[0] < nodes && v[1] < nodes && v[2] < nodes; };
  if (!is_whole(part.scan[0], part.nodes) || !is_whole(part.scan[1], part.nodes) ||
      !std::all_of(part.open.begin(), part.open.end(), holds))
    from.refuse();
  return part;
}

std::string bytes_of(const FinalCells& cells, const std::string& job) {
  Writer to;
  to.put(magic_of_cells), to.put(job);
  put_all(to, cells.xy), put_all(to, cells.z1), put_all(to, cells.z2), put_all(to, cells.triangles);
  put_all(to, cells.points);
  to.put(magic_of_cells);
  return to.take();
}

CellPart cells_of(std::span<const char> bytes, const std::string& job, const std::string& name,
                  std::size_t first_node) {
  Reader from(bytes, name);
  from.expect(magic_of_cells, job);
  CellPart part;
  part.xy = from.all<Point2>(), part.z1 = from.all<double>(), part.z2 = from.all<double>();
  part.triangles = from.all<Corners>(), part.points = from.all<std::array<Index, 2>>();
  std::uint64_t end = 0;
  from.get(end);
  from.expect_end();
  if (end != magic_of_cells || part.z1.size() != part.xy.size() || part.z2.size() != part.xy.size() ||
      (!part.points.empty() && part.points.size() != part.xy.size()))
    from.refuse();
  part.first_node = first_node;
  return part;
}

}  // namespace isopach
