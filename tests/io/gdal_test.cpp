#include "isopach/io/gdal.hpp"

#include <array>
#include <filesystem>
#include <thread>

#include "isopach/io/gdal_memory_file.hpp"
#include "tests/io/files.hpp"

namespace isopach {
namespace {

std::string refusal(const std::string& library) {
  try {
    (void)load_gdal(library, "dem.tif: reading a raster");
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST(Gdal, MissingLibraryIsAnErrorThatSaysWhatToInstall) {
  const std::string said = refusal("libgdal.so.9999");
  EXPECT_TRUE(said.starts_with("dem.tif: reading a raster needs GDAL, which cannot be loaded (")) << said;
  EXPECT_NE(said.find("libgdal.so.9999: "), std::string::npos) << said;  // the loader's own words begin so
  EXPECT_TRUE(said.ends_with("install it (package libgdal9999)")) << said;
  EXPECT_EQ(said.find('\n'), std::string::npos);
  EXPECT_TRUE(refusal("nowhere/gdal").ends_with("install it (package libgdal)"));
}

#ifdef __GLIBC__
TEST(Gdal, LibraryThatIsNotGdalIsRefused) {
  EXPECT_EQ(refusal("libm.so.6"),
            "dem.tif: reading a raster needs GDAL, which cannot be loaded (libm.so.6 has no CPLCalloc): install it "
            "(package libgdal)");
}
#endif

TEST(Gdal, IsLoadedOnceForAllThreads) {
  std::array<const Gdal*, 8> seen{};
  std::vector<std::thread> threads;
  for (const Gdal*& mine : seen) threads.emplace_back([&mine] { mine = &need_gdal("this test"); });
  for (std::thread& t : threads) t.join();
  for (const Gdal* one : seen) EXPECT_EQ(one, &gdal());
  // The tests are linked with GDAL: what was loaded is that same library.
  EXPECT_EQ(gdal().GDALOpenEx, &::GDALOpenEx);
  EXPECT_EQ(gdal().VSIUnlink, &::VSIUnlink);
  EXPECT_NE(gdal().proj_log_level, nullptr);
}

TEST(Gdal, NothingIsAskedOfTheNetworkWhileItIsForbidden) {
  {
    const NoNetwork none;
    CPLHTTPResult* const result = CPLHTTPFetch("http://127.0.0.1:1/", nullptr);
    ASSERT_NE(result, nullptr);
    EXPECT_STREQ(result->pszErrBuf, "the network is not used");
    CPLHTTPDestroyResult(result);
  }
  const GdalMessages quiet;
  CPLHTTPResult* const result = CPLHTTPFetch("http://127.0.0.1:1/", nullptr);  // refused by the system: nobody listens
  ASSERT_NE(result, nullptr);
  EXPECT_STRNE(result->pszErrBuf, "the network is not used");
  CPLHTTPDestroyResult(result);
}

TEST(Gdal, MessagesKeepTheFirstFailureAsOneLine) {
  const GdalMessages outer;
  {
    const GdalMessages messages;
    CPLError(CE_Warning, CPLE_AppDefined, "only a warning");
    EXPECT_EQ(messages.failure(), "");
    CPLError(CE_Failure, CPLE_AppDefined, "first\nfailure");
    CPLError(CE_Failure, CPLE_AppDefined, "second");
    EXPECT_EQ(messages.failure(), "GDAL: first failure");
  }
  EXPECT_EQ(outer.failure(), "");
}

TEST(Gdal, MemoryFileIsThereWhileItLives) {
  const std::string bytes = "some bytes";
  std::string path;
  VSIStatBufL found;
  {
    const GdalMemoryFile file(bytes);
    path = file.path();
    ASSERT_EQ(VSIStatL(path.c_str(), &found), 0);
    EXPECT_EQ(static_cast<std::size_t>(found.st_size), bytes.size());
  }
  EXPECT_NE(VSIStatL(path.c_str(), &found), 0);
}

}  // namespace
}  // namespace isopach
