#include "isopach/io/write.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <limits>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/geom/vec.hpp"
#include "isopach/io/las.hpp"
#include "isopach/io/output_file.hpp"
#include "isopach/io/raster.hpp"
#include "isopach/io/scan.hpp"

namespace isopach {
namespace {

static_assert(std::endian::native == std::endian::little, "the binary formats are written in the machine's byte order");

// Rows are formatted in parallel, a wave of blocks at a time so that memory stays bounded, and written in order.
// fill(begin, end, text) appends rows [begin, end) to `text`.
template <class Fill>
void write_rows(OutputFile& file, std::size_t rows, const Context& context, Fill&& fill) {
  constexpr std::size_t block = 1 << 14;
  constexpr std::size_t wave = 32;  // blocks
  std::vector<std::string> texts(wave);
  for (std::size_t first = 0; first < rows; first += wave * block) {
    const std::size_t count = std::min(rows - first, wave * block);
    for (std::string& text : texts) text.clear();
    for_blocks(count, block,
               [&](std::size_t begin, std::size_t end) { fill(first + begin, first + end, texts[begin / block]); });
    for (const std::string& text : texts) file.write(text);
    context.step("write", static_cast<double>(first + count) / static_cast<double>(rows));
  }
}

template <class T>
void append(std::string& text, T value) {
  text.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

void append_number(std::string& text, double value) {
  fmt::memory_buffer buffer;
  fmt::format_to(std::back_inserter(buffer), "{}", value);  // the shortest that reads back as the same double
  text.append(buffer.data(), buffer.size());
}

// x y z and the attributes as doubles: the row of PLY and PCD.
void append_binary_rows(const Cloud& cloud, std::size_t begin, std::size_t end, std::string& text) {
  text.reserve((end - begin) * (3 + cloud.attributes.size()) * sizeof(double));
  for (std::size_t i = begin; i < end; ++i) {
    append(text, cloud.points[i]);
    for (const Attribute& a : cloud.attributes) append(text, a.values[i]);
  }
}

std::string one_word(const std::string& name) {
  std::string result = name.empty() ? "unnamed" : name;
  std::replace_if(
      result.begin(), result.end(), [](char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == ','; },
      '_');
  return result;
}

// ---- the formats

void check_ply(const std::string& path, const Cloud& cloud) {
  if (cloud.points.size() > std::numeric_limits<std::uint32_t>::max() && !cloud.faces.empty())
    throw UsageError(
        fmt::format("{}: PLY cannot number the corners of so many points: write them without faces", path));
}

void write_ply(const std::string& path, const Cloud& cloud, const Context& context) {
  OutputFile file(path);
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  if (cloud.unit != "unknown") header += fmt::format("comment unit: {}\n", cloud.unit);
  if (cloud.vertical_unit != "unknown") header += fmt::format("comment vertical_unit: {}\n", cloud.vertical_unit);
  if (!cloud.crs.empty() && cloud.crs.find('\n') == std::string::npos)
    header += fmt::format("comment crs: {}\n", cloud.crs);
  header +=
      fmt::format("element vertex {}\nproperty double x\nproperty double y\nproperty double z\n", cloud.points.size());
  for (const Attribute& a : cloud.attributes) header += fmt::format("property double {}\n", one_word(a.name));
  if (!cloud.faces.empty())
    header += fmt::format("element face {}\nproperty list uchar uint vertex_indices\n", cloud.faces.size());
  file.write(header + "end_header\n");
  write_rows(file, cloud.points.size(), context, [&](std::size_t begin, std::size_t end, std::string& text) {
    append_binary_rows(cloud, begin, end, text);
  });
  write_rows(file, cloud.faces.size(), context, [&](std::size_t begin, std::size_t end, std::string& text) {
    for (std::size_t i = begin; i < end; ++i) {
      append(text, std::uint8_t{3});
      for (const Index corner : cloud.faces[i]) append(text, static_cast<std::uint32_t>(corner));
    }
  });
  file.close();
}

std::string column_names(const Cloud& cloud, char separator) {
  std::string names = fmt::format("x{0}y{0}z", separator);
  for (const Attribute& a : cloud.attributes) names += separator + one_word(a.name);
  return names + "\n";
}

void write_text(const std::string& path, const Cloud& cloud, bool csv, const Context& context) {
  OutputFile file(path);
  const char separator = csv ? ',' : ' ';
  if (csv)
    file.write(column_names(cloud, separator));
  else if (!cloud.attributes.empty())
    file.write("# " + column_names(cloud, separator));
  write_rows(file, cloud.points.size(), context, [&](std::size_t begin, std::size_t end, std::string& text) {
    for (std::size_t i = begin; i < end; ++i) {
      const Point3& p = cloud.points[i];
      append_number(text, p.x);
      append_number(text += separator, p.y);
      append_number(text += separator, p.z);
      for (const Attribute& a : cloud.attributes) append_number(text += separator, a.values[i]);
      text += '\n';
    }
  });
  file.close();
}

void write_obj(const std::string& path, const Cloud& cloud, const Context& context) {
  OutputFile file(path);
  const std::array<const Attribute*, 3> color = {cloud.find_attribute("red"), cloud.find_attribute("green"),
                                                 cloud.find_attribute("blue")};
  const bool colored = std::all_of(color.begin(), color.end(), [](const Attribute* a) { return a != nullptr; });
  write_rows(file, cloud.points.size(), context, [&](std::size_t begin, std::size_t end, std::string& text) {
    for (std::size_t i = begin; i < end; ++i) {
      const Point3& p = cloud.points[i];
      text += 'v';
      for (const double value : {p.x, p.y, p.z}) append_number(text += ' ', value);
      if (colored)
        for (const Attribute* a : color) append_number(text += ' ', a->values[i]);
      text += '\n';
    }
  });
  write_rows(file, cloud.faces.size(), context, [&](std::size_t begin, std::size_t end, std::string& text) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto& f = cloud.faces[i];
      text += fmt::format("f {} {} {}\n", f[0] + std::uint64_t{1}, f[1] + std::uint64_t{1}, f[2] + std::uint64_t{1});
    }
  });
  file.close();
}

// STL holds 32-bit numbers. Fine for a scan near its origin, useless for map coordinates: those are refused.
void check_stl(const std::string& path, const Cloud& cloud) {
  constexpr double relative_error = 1e-6;  // of the extent
  if (cloud.faces.empty())
    throw UsageError(fmt::format("{}: STL holds triangles and the cloud has none: write .ply or .xyz", path));
  if (cloud.faces.size() > std::numeric_limits<std::uint32_t>::max())
    throw UsageError(fmt::format("{}: more triangles than STL can count: write .ply", path));
  Box3 box;
  double error = 0;
  for (const Point3& p : cloud.points) {
    if (!is_finite(p)) continue;
    box.add(p);
    for (const double c : {p.x, p.y, p.z})
      error = std::max(error, std::fabs(c - static_cast<double>(static_cast<float>(c))));
  }
  const double extent = std::max({box.max.x - box.min.x, box.max.y - box.min.y, box.max.z - box.min.z});
  if (!box.empty() && error > relative_error * extent)
    throw UsageError(fmt::format("{}: the coordinates do not fit the 32-bit numbers of STL (error {:.3g}): write .ply",
                                 path, error));
}

std::array<float, 3> normal(const Point3& a, const Point3& b, const Point3& c) {
  const Point3 u{b.x - a.x, b.y - a.y, b.z - a.z}, v{c.x - a.x, c.y - a.y, c.z - a.z};
  const Point3 n{u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
  const double length = std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
  if (!(length > 0)) return {0, 0, 0};
  return {static_cast<float>(n.x / length), static_cast<float>(n.y / length), static_cast<float>(n.z / length)};
}

void write_stl(const std::string& path, const Cloud& cloud, const Context& context) {
  OutputFile file(path);
  std::string header("binary STL, coordinates as 32-bit numbers");
  header.resize(80, ' ');
  append(header, static_cast<std::uint32_t>(cloud.faces.size()));
  file.write(header);
  write_rows(file, cloud.faces.size(), context, [&](std::size_t begin, std::size_t end, std::string& text) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto& f = cloud.faces[i];
      append(text, normal(cloud.points[f[0]], cloud.points[f[1]], cloud.points[f[2]]));
      for (const Index corner : f) {
        const Point3& p = cloud.points[corner];
        append(text, std::array<float, 3>{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
      }
      append(text, std::uint16_t{0});
    }
  });
  file.close();
}

void write_pcd(const std::string& path, const Cloud& cloud, const Context& context) {
  OutputFile file(path);
  std::string fields = "x y z", sizes = "8 8 8", types = "F F F", counts = "1 1 1";
  for (const Attribute& a : cloud.attributes) {
    fields += ' ' + one_word(a.name);
    sizes += " 8";
    types += " F";
    counts += " 1";
  }
  file.write(
      fmt::format("# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS {}\nSIZE {}\nTYPE {}\nCOUNT {}\n"
                  "WIDTH {}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
                  fields, sizes, types, counts, cloud.points.size(), cloud.points.size()));
  write_rows(file, cloud.points.size(), context, [&](std::size_t begin, std::size_t end, std::string& text) {
    append_binary_rows(cloud, begin, end, text);
  });
  file.close();
}

// NumPy format 1.0: magic, version, length of the header, header padded to a multiple of 64, the numbers.
void write_npy(const std::string& path, const Cloud& cloud, const Context& context) {
  OutputFile file(path);
  constexpr std::size_t before = 10, align = 64;
  std::string header =
      fmt::format("{{'descr': '<f8', 'fortran_order': False, 'shape': ({}, 3), }}", cloud.points.size());
  header.append(align - (before + header.size() + 1) % align, ' ');
  header += '\n';
  std::string start = "\x93NUMPY\x01";
  start += '\0';
  append(start, static_cast<std::uint16_t>(header.size()));
  file.write(start + header);
  write_rows(file, cloud.points.size(), context, [&](std::size_t begin, std::size_t end, std::string& text) {
    text.append(reinterpret_cast<const char*>(cloud.points.data() + begin), (end - begin) * sizeof(Point3));
  });
  file.close();
}

// What a format cannot hold is refused before any file is made.
void check_contents(const std::string& path, const std::string& end, const Cloud& cloud) {
  if (end == ".ply") check_ply(path, cloud);
  if (end == ".stl") check_stl(path, cloud);
  if ((end == ".tif" || end == ".tiff") && !cloud.grid)
    throw UsageError(fmt::format("{}: a raster needs points that were read from one: write .ply, .las or .xyz", path));
}

using Writer = std::function<void(const std::string&)>;

Writer find_writer(const std::string& path, const std::string& end, const Cloud& cloud, const Context& context) {
  if (end == ".ply") return [&](const std::string& p) { write_ply(p, cloud, context); };
  if (end == ".csv") return [&](const std::string& p) { write_text(p, cloud, true, context); };
  if (end == ".xyz" || end == ".txt") return [&](const std::string& p) { write_text(p, cloud, false, context); };
  if (end == ".obj") return [&](const std::string& p) { write_obj(p, cloud, context); };
  if (end == ".stl") return [&](const std::string& p) { write_stl(p, cloud, context); };
  if (end == ".pcd") return [&](const std::string& p) { write_pcd(p, cloud, context); };
  if (end == ".npy") return [&](const std::string& p) { write_npy(p, cloud, context); };
  throw UsageError(fmt::format(
      "{}: unknown extension: use .ply, .xyz, .txt, .csv, .las, .laz, .obj, .stl, .pcd, .npy or .tif", path));
}

}  // namespace

void write_cloud(const std::string& path, const Cloud& cloud, const Context& context) {
  for ([[maybe_unused]] const Attribute& a : cloud.attributes) assert(a.values.size() == cloud.points.size());
  const std::string end = lower_case(std::filesystem::path(path).extension().string());
  check_contents(path, end, cloud);
  run_with_threads(context, [&] {
    if (end == ".las" || end == ".laz")
      write_las(path, cloud, context);  // these two are atomic by themselves
    else if (end == ".tif" || end == ".tiff")
      write_raster(path, cloud, context);
    else
      write_atomically(path, find_writer(path, end, cloud, context));
  });
}

}  // namespace isopach
