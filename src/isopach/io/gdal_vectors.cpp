#include "isopach/io/gdal_vectors.hpp"

#include <vector>

#include "isopach/io/gdal.hpp"
#include "isopach/io/gdal_memory_file.hpp"
#include "isopach/io/output_file.hpp"

namespace isopach {
namespace {

/// While it lives, files of GDAL carry one and the same date in this thread, so that their bytes do not depend on the
/// hour.
class FixedDate {
 public:
  FixedDate() { gdal().CPLSetThreadLocalConfigOption("OGR_CURRENT_DATE", "2000-01-01T00:00:00.000Z"); }
  ~FixedDate() { gdal().CPLSetThreadLocalConfigOption("OGR_CURRENT_DATE", nullptr); }
  FixedDate(const FixedDate&) = delete;
  FixedDate& operator=(const FixedDate&) = delete;
};

using Options = GdalOwned<GDALVectorTranslateOptions*, &Gdal::GDALVectorTranslateOptionsFree>;

Options options_of(const std::string& driver, const std::string& wkt) {
  std::vector<std::string> words{"-f", driver, "-nlt", "PROMOTE_TO_MULTI"};
  if (!wkt.empty()) words.insert(words.end(), {"-a_srs", wkt});
  std::vector<char*> list;
  for (std::string& word : words) list.push_back(word.data());
  list.push_back(nullptr);
  return Options(gdal().GDALVectorTranslateOptionsNew(list.data(), nullptr));
}

}  // namespace

void gdal_need_vectors(const std::string& path) { need_gdal(path + ": writing this format"); }

std::string gdal_vectors(const std::string& geojson, const std::string& driver, const std::string& ending,
                         const std::string& crs, const std::string& path) {
  gdal_need_vectors(path);
  const GdalMessages messages;
  const NoNetwork alone;
  const FixedDate date;
  gdal().GDALAllRegister();
  const GdalMemoryFile source({geojson.data(), geojson.size()});
  const char* const drivers[] = {"GeoJSON", nullptr};
  const GdalDataset from(
      gdal().GDALOpenEx(source.path().c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, drivers, nullptr, nullptr));
  if (!from) fail_to_write(path, messages.failure());
  const Options options = options_of(driver, wkt_of_crs(crs, path));
  const std::string file = source.path() + "." + ending;
  GDALDatasetH sources[] = {from.get()};
  int misused = 0;
  GdalDataset to(gdal().GDALVectorTranslate(file.c_str(), nullptr, 1, sources, options.get(), &misused));
  const bool made = to != nullptr;
  to.reset();
  vsi_l_offset size = 0;
  const GByte* const bytes = made ? gdal().VSIGetMemFileBuffer(file.c_str(), &size, FALSE) : nullptr;
  std::string content;
  if (bytes != nullptr) content.assign(reinterpret_cast<const char*>(bytes), size);
  gdal().VSIUnlink(file.c_str());
  if (content.empty() || !messages.failure().empty()) fail_to_write(path, messages.failure());
  return content;
}

}  // namespace isopach
