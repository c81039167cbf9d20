#include "tests/support/copc.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>
#include <vector>

#include "isopach/io/las_format.hpp"
#include "isopach/io/laz.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

using Key = std::array<std::int32_t, 4>;  // level, x, y, z

std::string content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void put(std::string& bytes, std::size_t at, const auto& value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}
void append(std::string& bytes, const auto& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// A level holds four times as many points as the one above it, as many nodes as a surface has in it.
std::int32_t level_of(Random& random, int levels) {
  std::size_t points = 0, of_level = 1;
  for (int k = 0; k < levels; ++k, of_level *= 4) points += of_level;
  std::size_t place = random.below(points);
  std::int32_t level = 0;
  for (of_level = 1; place >= of_level; of_level *= 4) place -= of_level, ++level;
  return level;
}

Key key_of(const LasFile& las, const char* record, std::size_t number, const CopcShape& shape) {
  const auto xyz = las_coordinates(las);
  Random random(number);
  Key key{level_of(random, shape.levels), 0, 0, 0};
  const std::int32_t cubes = std::int32_t{1} << key[0];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double before = xyz[axis].load(record) + las.scale[axis] * random.uniform(-0.5, 0.5);
    const double cell = std::floor((before - shape.centre[axis] + shape.half) / (2 * shape.half / cubes));
    key[axis + 1] = std::clamp(static_cast<std::int32_t>(cell), 0, cubes - 1);
  }
  return key;
}

struct Compressed {
  std::string chunk, record;  // the points, and LASzip's own record
};

Compressed compressed(const LasFile& las, const std::string& records, const std::string& beside) {
  const std::string plain = beside + ".part.las", packed = beside + ".part.laz";
  std::string bytes(las.head.data(), las.head.size());
  const std::size_t count = records.size() / las.record_length;
  if (count > 50000) throw std::length_error("LASzip makes two chunks of so many points: take more levels");
  put(bytes, 107, std::uint32_t{0});
  put(bytes, 235, std::uint64_t{0}), put(bytes, 243, std::uint32_t{0});
  put(bytes, 247, static_cast<std::uint64_t>(count));
  std::ofstream(plain, std::ios::binary) << bytes << records;
  compress_las(plain, packed, count, {});
  const std::string out = content(packed);
  std::remove(plain.c_str()), std::remove(packed.c_str());
  const LasFile laz = parse_las(out, packed);
  const auto table = static_cast<std::size_t>(get_le<std::int64_t>(out.data() + laz.points_at));
  Compressed result{out.substr(laz.points_at + 8, table - laz.points_at - 8), ""};
  for (const LasRecord& record : laz.records)
    if (record.user == "laszip encoded") result.record.assign(record.whole.data(), record.whole.size());
  put(result.record, 54 + 12, std::uint32_t{0xFFFFFFFF});  // chunks of any size
  return result;
}

std::string variable_record(const char* user, std::uint16_t id, const std::string& data) {
  std::string record(54, '\0');
  std::strncpy(record.data() + 2, user, 16);
  put(record, 18, id), put(record, 20, static_cast<std::uint16_t>(data.size()));
  return record + data;
}

void append_entry(std::string& page, const Key& key, std::uint64_t at, std::int32_t length, std::int32_t points) {
  for (const std::int32_t part : key) append(page, part);
  append(page, at), append(page, length), append(page, points);
}

struct Node {
  std::uint64_t at;
  std::int32_t length, points;
};

// The pages of the index, the root's last, as they stand in a file from `at` on; where the root's begins.
std::string index_of(const std::map<Key, Node>& nodes, bool pages, std::uint64_t at, std::size_t& root) {
  constexpr std::int32_t paged = 2;
  std::string index, top;
  std::map<Key, std::string> below;
  for (const auto& [key, node] : nodes) {
    Key ancestor = key;
    while (ancestor[0] > paged) {
      --ancestor[0];
      for (std::size_t i = 1; i < 4; ++i) ancestor[i] /= 2;
    }
    append_entry(pages && key[0] >= paged ? below[ancestor] : top, key, node.at, node.length, node.points);
  }
  for (const auto& [key, page] : below) {
    append_entry(top, key, at + index.size(), static_cast<std::int32_t>(page.size()), -1);
    index += page;
  }
  root = index.size();
  return index + top;
}

}  // namespace

void write_copc(const std::string& las_path, const std::string& copc, const CopcShape& shape) {
  const std::string source = content(las_path);
  const LasFile las = parse_las(source, las_path);
  std::map<Key, std::string> parts;
  for (std::size_t i = 0; i < las.count; ++i) {
    const char* const record = source.data() + las.points_at + i * las.record_length;
    parts[key_of(las, record, i, shape)].append(record, las.record_length);
  }
  std::vector<Key> order;
  for (const auto& [key, records] : parts) order.push_back(key);
  Random(1).shuffle(order);
  std::map<Key, Compressed> packed;
  for (const Key& key : order) packed[key] = compressed(las, parts[key], copc);

  std::string head = source.substr(0, 375), info(160, '\0');
  std::string records = variable_record("copc", 1, info) + packed[order.front()].record;
  for (const LasRecord& record : las.records) records.append(record.whole.data(), record.whole.size());
  const std::size_t points_at = 375 + records.size();
  std::string chunks;
  std::map<Key, Node> nodes;
  for (const Key& key : order) {
    const std::string& chunk = packed[key].chunk;
    nodes[key] = {points_at + 8 + chunks.size(), static_cast<std::int32_t>(chunk.size()),
                  static_cast<std::int32_t>(parts[key].size() / las.record_length)};
    chunks += chunk;
  }
  const std::uint64_t index_at = points_at + 8 + chunks.size() + 60;
  std::size_t root = 0;
  const std::string index = index_of(nodes, shape.pages, index_at, root);
  for (std::size_t axis = 0; axis < 3; ++axis) put(info, 8 * axis, shape.centre[axis]);
  put(info, 24, shape.half);
  put(info, 40, index_at + root), put(info, 48, static_cast<std::uint64_t>(index.size() - root));
  records.replace(54, info.size(), info);

  put(head, 94, std::uint16_t{375}), put(head, 96, static_cast<std::uint32_t>(points_at));
  put(head, 100, static_cast<std::uint32_t>(las.records.size() + 2));
  head[104] = static_cast<char>(las.format | 0x80);
  put(head, 107, std::uint32_t{0}), put(head, 227, std::uint64_t{0});
  put(head, 235, index_at - 60), put(head, 243, std::uint32_t{1});
  put(head, 247, static_cast<std::uint64_t>(las.count));
  std::string extended(60, '\0');
  std::strncpy(extended.data() + 2, "copc", 16);
  put(extended, 18, std::uint16_t{1000}), put(extended, 20, static_cast<std::uint64_t>(index.size()));
  std::string table;
  append(table, index_at - 60);
  std::ofstream(copc, std::ios::binary) << head << records << table << chunks << extended << index;
}

}  // namespace isopach::test
