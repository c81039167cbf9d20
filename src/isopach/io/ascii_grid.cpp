#include "isopach/io/ascii_grid.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>

#include "isopach/base/error.hpp"
#include "isopach/io/crs.hpp"
#include "isopach/io/raster.hpp"
#include "isopach/io/scan.hpp"

namespace isopach {
namespace {

class Reader {
 public:
  Reader(std::string_view text, const std::string& path)
      : text_(text), at_(text.data()), end_(text.data() + text.size()), path_(path) {}

  [[nodiscard]] RasterGrid header() {
    skip_space();
    for (std::string name = lower_case(word()); is_key(name); name = lower_case(word())) {
      at_ += name.size();
      skip_space();
      if (!scan_number(at_, end_, values_[name])) fail(fmt::format("{} is not followed by a number", name));
      skip_space();
    }
    if (values_.count("nodata_value") != 0) none_ = values_["nodata_value"];
    return grid();
  }

  // The next height; "*" is an old mark of no data.
  [[nodiscard]] double height() {
    skip_space();
    double value = 0;
    if (at_ < end_ && *at_ == '*') return ++at_, std::nan("");
    if (at_ >= end_) fail("the file ends before the last row");
    if (!scan_number(at_, end_, value)) fail(fmt::format("{} is not a number", quoted(word())));
    return none_ && value == *none_ ? std::nan("") : value;
  }

  void finish() {
    skip_space();
    if (at_ < end_) fail(fmt::format("there are more heights than cells: {}", quoted(word())));
  }

  [[noreturn]] void fail(const std::string& cause) const {
    const std::size_t line = line_number(text_, static_cast<std::size_t>(at_ - text_.data()));
    throw InputError(fmt::format("{}: line {}: {}: correct the grid", path_, line, cause));
  }

 private:
  void skip_space() {
    while (at_ < end_ && std::strchr(" \t\r\n", *at_) != nullptr && *at_ != '\0') ++at_;
  }
  [[nodiscard]] std::string_view word() const {
    const std::string_view rest(at_, static_cast<std::size_t>(end_ - at_));
    return rest.substr(0, rest.find_first_of(" \t\r\n"));
  }
  // Not just any word: heights may be "nan" or "inf".
  [[nodiscard]] static bool is_key(const std::string& name) {
    for (const char* key :
         {"ncols", "nrows", "xllcorner", "xllcenter", "yllcorner", "yllcenter", "cellsize", "dx", "dy", "nodata_value"})
      if (name == key) return true;
    return false;
  }

  [[nodiscard]] double need(const char* name) const {
    const auto found = values_.find(name);
    if (found == values_.end()) fail(fmt::format("the header has no {}", name));
    return found->second;
  }
  [[nodiscard]] std::size_t count(const char* name) const {
    const double value = need(name);
    // Each cell takes two bytes at least.
    if (!(value >= 1) || value != std::floor(value) || value > static_cast<double>(text_.size()))
      fail(fmt::format("{} {} does not fit a file of {} bytes", name, value, text_.size()));
    return static_cast<std::size_t>(value);
  }
  [[nodiscard]] RasterGrid grid() const {
    RasterGrid grid;
    grid.columns = count("ncols");
    grid.rows = count("nrows");
    if (grid.columns > text_.size() / grid.rows)
      fail(fmt::format("{} by {} cells do not fit a file of {} bytes", grid.columns, grid.rows, text_.size()));
    const bool square = values_.count("cellsize") != 0;
    const double dx = need(square ? "cellsize" : "dx"), dy = need(square ? "cellsize" : "dy");
    if (!(dx > 0 && dy > 0 && std::isfinite(dx) && std::isfinite(dy))) fail("the size of the cells is not positive");
    const double west = values_.count("xllcenter") != 0 ? need("xllcenter") - dx / 2 : need("xllcorner");
    const double south = values_.count("yllcenter") != 0 ? need("yllcenter") - dy / 2 : need("yllcorner");
    if (!std::isfinite(west) || !std::isfinite(south)) fail("the corner of the grid is not finite");
    grid.geotransform = {west, dx, 0, south + dy * static_cast<double>(grid.rows), 0, -dy};
    if (!has_places(grid))
      fail(fmt::format("cells of {} by {} at ({}, {}) have no places of their own in double precision", dx, dy, west,
                       south));
    return grid;
  }

  std::string_view text_;
  const char* at_;
  const char* end_;
  std::string path_;
  std::map<std::string, double> values_;
  std::optional<double> none_;
};

Crs crs_beside(const std::string& path) {
  for (const char* extension : {".prj", ".PRJ"}) {
    std::ifstream in(std::filesystem::path(path).replace_extension(extension));
    if (in) return crs_from_esri({std::istreambuf_iterator<char>(in), {}}, path);
  }
  return {};
}

}  // namespace

bool is_ascii_grid(std::string_view head) {
  const std::vector<std::string_view> first = words(trimmed(head.substr(0, 256)));
  if (first.size() < 2) return false;
  const std::string name = lower_case(first[0]);
  double value = 0;
  const char* p = first[1].data();
  return (name == "ncols" || name == "nrows") && scan_number(p, p + first[1].size(), value);
}

Cloud read_ascii_grid(std::span<const char> bytes, const std::string& path, const Context& context) {
  Reader reader(as_text(bytes), path);
  Cloud cloud;
  cloud.path = path;
  cloud.format = "raster";
  cloud.grid = reader.header();
  for (std::size_t row = 0; row < cloud.grid->rows; ++row) {
    context.step("read", static_cast<double>(row) / static_cast<double>(cloud.grid->rows));
    for (std::size_t column = 0; column < cloud.grid->columns; ++column) {
      const double z = reader.height();
      if (std::isfinite(z))
        cloud.points.push_back(cell_centre(*cloud.grid, column, row, z));
      else
        ++cloud.nodata;
    }
  }
  reader.finish();
  set_crs(cloud, crs_beside(path));
  return cloud;
}

}  // namespace isopach
