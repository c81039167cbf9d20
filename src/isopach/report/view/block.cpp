#include "isopach/report/view/block.hpp"

#include <zlib.h>
#include <new>

#include <cstdint>
#include <vector>

#include "isopach/base/error.hpp"
#include "isopach/report/page/base64.hpp"

namespace isopach {
namespace {

/// 0, −1, 1, −2, … as 0, 1, 2, 3, …
std::uint32_t folded(std::int64_t v) { return static_cast<std::uint32_t>(v < 0 ? -2 * v - 1 : 2 * v); }

void add_planes(std::string& out, const std::vector<std::uint32_t>& numbers) {
  for (int plane = 0; plane < 4; ++plane)
    for (const std::uint32_t n : numbers) out += static_cast<char>(n >> (8 * plane) & 255);
}

void add_numbers(std::string& out, const Quantised& q) {
  std::vector<std::uint32_t> differences;
  std::int64_t last = 0;
  for (const std::uint32_t n : q.numbers) differences.push_back(folded(n - last)), last = n;
  add_planes(out, differences);
}

void add_triangles(std::string& out, std::span<const std::array<Index, 3>> triangles) {
  std::array<std::vector<std::uint32_t>, 3> columns;
  std::int64_t last = 0;
  for (const auto& v : triangles) {
    const auto first = static_cast<std::int64_t>(v[0]);
    columns[0].push_back(folded(first - last));
    for (std::size_t k = 1; k < 3; ++k) columns[k].push_back(folded(static_cast<std::int64_t>(v[k]) - first));
    last = first;
  }
  for (const auto& column : columns) add_planes(out, column);
}

std::string deflated(const std::string& bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::string out(size, '\0');
  const int status = compress2(reinterpret_cast<Bytef*>(out.data()), &size,
                               reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uLong>(bytes.size()), 6);
  if (status == Z_MEM_ERROR) throw std::bad_alloc();
  if (status != Z_OK) throw Error(ExitCode::internal, "the surface of the report cannot be compressed");
  out.resize(size);
  return out;
}

}  // namespace

std::string numbers_block(std::span<const Quantised* const> columns, std::span<const std::array<Index, 3>> triangles) {
  std::string bytes;
  for (const Quantised* q : columns) add_numbers(bytes, *q);
  add_triangles(bytes, triangles);
  return base64(deflated(bytes));
}

std::string view_block(const ThinSurface& s) {
  const std::array<const Quantised*, 5> columns{&s.x, &s.y, &s.z, &s.d, &s.lod};
  return numbers_block(columns, s.triangles);
}

}  // namespace isopach
