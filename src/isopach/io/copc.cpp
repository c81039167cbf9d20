#include "isopach/io/copc.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace isopach {
namespace {

constexpr std::size_t info_length = 160, entry_length = 32;

struct Octree {
  std::array<double, 3> centre{};
  double half = 0;
  std::uint64_t root_at = 0, root_length = 0;
};

// An entry of the index: a node with its chunk, or, with points = -1, a page of more entries.
struct Entry {
  std::int32_t level, x, y, z;
  std::uint64_t at;
  std::int32_t length, points;
};

const LasRecord* info_record(const LasFile& file) {
  for (const LasRecord& record : file.records)
    if (record.user == "copc" && record.id == 1 && record.data.size() >= info_length) return &record;
  return nullptr;
}

Octree octree_of(const LasRecord& record) {
  const char* const data = record.data.data();
  return {{get_le<double>(data), get_le<double>(data + 8), get_le<double>(data + 16)},
          get_le<double>(data + 24),
          get_le<std::uint64_t>(data + 40),
          get_le<std::uint64_t>(data + 48)};
}

Entry entry_at(const char* data) {
  return {get_le<std::int32_t>(data),      get_le<std::int32_t>(data + 4),   get_le<std::int32_t>(data + 8),
          get_le<std::int32_t>(data + 12), get_le<std::uint64_t>(data + 16), get_le<std::int32_t>(data + 24),
          get_le<std::int32_t>(data + 28)};
}

bool is_node_of_octree(const Entry& e) {
  constexpr std::int32_t deepest = 30;
  if (e.level < 0 || e.level > deepest) return false;
  const std::int32_t cubes = std::int32_t{1} << e.level;
  return std::min({e.x, e.y, e.z}) >= 0 && std::max({e.x, e.y, e.z}) < cubes;
}

using Pages = std::vector<std::pair<std::uint64_t, std::uint64_t>>;  // place and length

// Adds what a page names; false if it holds what is no entry.
bool read_page(std::span<const char> page, std::vector<Entry>& nodes, Pages& pages) {
  for (std::size_t i = 0; i < page.size(); i += entry_length) {
    const Entry entry = entry_at(page.data() + i);
    if (!is_node_of_octree(entry) || entry.points < -1 || entry.length < 0) return false;
    if (entry.points == -1)
      pages.emplace_back(entry.at, static_cast<std::uint64_t>(entry.length));
    else if (entry.points > 0)
      nodes.push_back(entry);
  }
  return true;
}

// All entries with chunks; nothing if a page lies outside of the file or over another, or holds what is no entry.
std::optional<std::vector<Entry>> nodes_of(const LasFile& file, const Octree& octree) {
  constexpr std::uint64_t at_once = entry_length << 15;
  const std::uint64_t size = file.bytes.size();
  std::vector<Entry> nodes;
  Pages pages{{octree.root_at, octree.root_length}};
  std::uint64_t read = 0;  // more than the file has: pages lie over one another
  Array<char> scratch;
  while (!pages.empty()) {
    const auto [at, length] = pages.back();
    pages.pop_back();
    if (at > size || length > size - at || length % entry_length != 0 || length == 0 || (read += length) > size)
      return std::nullopt;
    for (std::uint64_t done = 0; done < length; done += at_once)
      if (!read_page(file.bytes.get(at + done, std::min(at_once, length - done), scratch), nodes, pages))
        return std::nullopt;
  }
  return nodes;
}

// Does the cube of a node, grown by what rounding may move a point, meet [low, high)?
bool meets(const LasFile& file, const Octree& octree, std::size_t axis, const Entry& entry, double low, double high) {
  const double side = std::ldexp(octree.half, 1 - entry.level);
  const double from = octree.centre[axis] - octree.half + (axis == 0 ? entry.x : entry.y) * side;
  const double rounding = 8 * std::numeric_limits<double>::epsilon() *
                          (std::fabs(octree.centre[axis]) + 2 * std::fabs(octree.half) + std::fabs(file.offset[axis]));
  const double room = std::fabs(file.scale[axis]) + rounding;
  return !(from + side + room < low) && !(from - room >= high);  // not a number: meets all
}

}  // namespace

bool is_copc(const LasFile& file) { return has_layered_chunks(file) && info_record(file) != nullptr; }

std::optional<std::vector<LazChunk>> copc_chunks(const LasFile& file, const PlanBox& box) {
  const LasRecord* const info = info_record(file);
  if (info == nullptr) return std::nullopt;
  const Octree octree = octree_of(*info);
  std::optional<std::vector<Entry>> nodes = nodes_of(file, octree);
  if (!nodes || !(octree.half >= 0)) return std::nullopt;
  std::sort(nodes->begin(), nodes->end(), [](const Entry& a, const Entry& b) { return a.at < b.at; });
  std::vector<LazChunk> chunks;
  std::uint64_t at = file.points_at + 8, points = 0;
  for (const Entry& node : *nodes) {
    if (node.at != at) return std::nullopt;
    at += static_cast<std::uint64_t>(node.length), points += static_cast<std::uint64_t>(node.points);
    if (at > file.bytes.size()) return std::nullopt;
    if (meets(file, octree, 0, node, box.min_x, box.max_x) && meets(file, octree, 1, node, box.min_y, box.max_y))
      chunks.push_back({node.at, static_cast<std::size_t>(node.length), static_cast<std::size_t>(node.points)});
  }
  if (points != file.count) return std::nullopt;
  return chunks;
}

}  // namespace isopach
