// Fuzz target: any bytes as a file of polygons. The first byte chooses how the file's name ends, by which GDAL knows
// some formats; what is read bounds a comparison of two grids.
#include <filesystem>
#include <fstream>

#include "isopach/compare/compare.hpp"
#include "isopach/io/polygons.hpp"
#include "tests/fuzz/decode.hpp"

namespace {

namespace fs = std::filesystem;

/// A folder that is removed when the program ends.
class Folder {
 public:
  Folder() {
    std::string pattern = (fs::temp_directory_path() / "isopach-fuzz-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) std::abort();
    path_ = pattern;
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  /// Path of a file with this end and these bytes.
  [[nodiscard]] std::string with(const char* end, std::span<const char> bytes) const {
    const std::string path = (path_ / "polygons").string() + end;
    std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return path;
  }

 private:
  fs::path path_;
};

isopach::Cloud grid(double height) {
  isopach::Cloud cloud;
  for (int y = 0; y < 9; ++y)
    for (int x = 0; x < 9; ++x) cloud.points.push_back({x * 1.0, y * 1.0, height * (x - y)});
  return cloud;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace isopach;
  static const Folder folder;
  static const Cloud a = grid(1), b = grid(-0.5);
  if (size < 1) return 0;
  const char* const end =
      fuzz::Input(data, 1).choice({".geojson", ".kml", ".csv", ".fgb", ".mif", ".shz", ".gpkg", ""});
  const fuzz::ExactBytes copy(data + 1, size - 1);
  fuzz::only_errors([&] {
    CompareOptions options;
    const PolygonSet read = read_polygons(folder.with(end, copy.bytes()));
    fuzz::require(!read.polygons.empty(), "a file of polygons has some");
    options.area.budget.push_back(read);
    const Comparison rows = compare(a, b, options, fuzz::one_thread());
    for (const BudgetRow& row : rows.budget)
      fuzz::require_finite("budget", {row.area, row.coverage, row.mean, row.rho, row.volume.net, row.volume.absolute});
    std::swap(options.area.budget, options.area.include);
    const Comparison inside = compare(a, b, options, fuzz::one_thread());
    fuzz::require_finite("comparison", {inside.domain_area, inside.measures.rho, inside.measures.volume.net});
    fuzz::require(inside.domain_area <= rows.domain_area * (1 + 1e-9), "a part is no larger than the whole");
  });
  return 0;
}
