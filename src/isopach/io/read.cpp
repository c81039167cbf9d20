#include "isopach/io/read.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/io/ascii_grid.hpp"
#include "isopach/io/foreign.hpp"
#include "isopach/io/formats.hpp"
#include "isopach/io/input_file.hpp"
#include "isopach/io/las.hpp"
#include "isopach/io/obj.hpp"
#include "isopach/io/pcd.hpp"
#include "isopach/io/ply.hpp"
#include "isopach/io/raster.hpp"
#include "isopach/io/scan.hpp"
#include "isopach/io/stl.hpp"
#include "isopach/io/text.hpp"

namespace isopach {
namespace {

std::string extension(const std::string& path) {
  const std::size_t slash = path.find_last_of('/');
  const std::size_t dot = path.find_last_of('.');
  if (dot == std::string::npos || (slash != std::string::npos && dot < slash)) return "";
  return lower_case(std::string_view(path).substr(dot));
}

bool starts_with(std::string_view text, std::string_view what) { return text.substr(0, what.size()) == what; }

[[noreturn]] void refuse(const std::string& path, const ForeignFormat& format) {
  throw InputError(fmt::format("{}: this is {}, which is not read: {}", path, format.name, format.remedy));
}

// What is neither text nor a format we know: a NUL byte near the start, but not the many of UTF-16.
bool is_binary(std::string_view head) {
  const std::string_view order_mark = head.substr(0, 2);
  if (order_mark == "\xFF\xFE" || order_mark == "\xFE\xFF") return false;  // the text reader names the remedy
  return head.find('\0') != std::string_view::npos;
}

}  // namespace

Format find_format(const std::string& path, Bytes head, std::uint64_t size) {
  const std::string_view text = as_text(head);
  if (starts_with(text, "ply") && text.size() > 3 && std::strchr("\r\n \t", text[3]) != nullptr) return Format::ply;
  if (is_las(text)) return Format::las;
  if (is_pcd(head)) return Format::pcd;
  if (is_raster(text)) return Format::raster;
  const ForeignFormat foreign = foreign_format(text);
  if (!foreign.name.empty()) refuse(path, foreign);
  if (is_stl(head, size)) return Format::stl;
  const std::string end = extension(path);
  if (end == ".ply") return Format::ply;
  if (end == ".las" || end == ".laz") return Format::las;
  if (end == ".tif" || end == ".tiff") return Format::raster;
  if (end == ".e57") refuse(path, foreign_format("ASTM-E57"));
  if (end == ".pcd") return Format::pcd;
  if (end == ".stl") return Format::stl;
  if (end == ".obj" || is_obj(head)) return Format::obj;
  if (is_binary(text))
    throw InputError(fmt::format("{}: a binary file of unknown format: convert it to PLY, LAS or XYZ text", path));
  return Format::text;
}

std::string format_name(Format format) {
  switch (format) {
    case Format::ply:
      return "ply";
    case Format::obj:
      return "obj";
    case Format::stl:
      return "stl";
    case Format::pcd:
      return "pcd";
    case Format::las:
      return "las";
    case Format::raster:
      return "raster";
    case Format::text:
      break;
  }
  return "xyz";
}

Cloud read_opened(InputFile& file, const std::string& path, const ReadOptions& options, const Context& context) {
  // Only rasters are larger than what they hold in memory, and GDAL reads the files that may stand beside them.
  if (file.is_regular() && is_raster(as_text(file.head())) && !is_ascii_grid(as_text(file.head())))
    return read_raster(path, options, context);
  const Bytes bytes = file.bytes();
  switch (find_format(path, file.head(), bytes.size())) {
    case Format::ply:
      return parse_ply(bytes, path, options, context);
    case Format::obj:
      return parse_obj(bytes, path, options, context);
    case Format::stl:
      return parse_stl(bytes, path, options, context);
    case Format::pcd:
      return parse_pcd(bytes, path, options, context);
    case Format::las:
      return read_las(bytes, path, options, context);
    case Format::raster:
      return read_raster(bytes, path, context);
    case Format::text:
      break;
  }
  return parse_text(bytes, path, options, context);
}

Cloud read_cloud(const std::string& path, const ReadOptions& options, const Context& context) {
  context.check();
  Cloud cloud;
  run_with_threads(context, [&] {
    InputFile file(path, context);
    cloud = read_opened(file, path, options, context);
  });
  cloud.path = path;
  return cloud;
}

}  // namespace isopach
