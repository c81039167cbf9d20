#include "isopach/io/output_file.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "isopach/base/error.hpp"

namespace isopach {
namespace {
namespace fs = std::filesystem;

class UnfinishedFiles : public testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }
  void touch(const std::string& name) { std::ofstream(folder_ / name) << "half"; }
  fs::path folder_ = fs::temp_directory_path() / ("output_file_test-" + std::to_string(getpid()));
};

TEST(OutputFile, KnowsUnfinishedNames) {
  EXPECT_TRUE(is_unfinished_folder(unfinished_name()));
  EXPECT_NE(unfinished_name(), unfinished_name());
  for (const char* name : {"", ".isopach-", ".isopach-12", ".isopach-12-", ".isopach-x-12", ".isopach-12-ab-c", "out"})
    EXPECT_FALSE(is_unfinished_folder(name)) << name;
}

TEST(OutputFile, TellsPlacesAsTheUserKnowsThem) {
  EXPECT_EQ(place_of("out/.isopach-12-00ab/new/map.png: full"), "out/map.png: full");
  EXPECT_EQ(place_of("out/.isopach-12-00ab-map.png"), "out/map.png");
  EXPECT_EQ(place_of(".isopach-1-a/new/.isopach-2-b-x.las and y"), "x.las and y");
  EXPECT_EQ(place_of("out/.isopach-12-00ab/commit.json: full"), "out/commit.json: full");
  EXPECT_EQ(place_of("out/.isopach-12-00ab: full"), "out/: full");
  for (const char* plain : {"out/map.png", ".isopach-notes/x", ".isopach-12", "", ".isopach-"})
    EXPECT_EQ(place_of(plain), plain);
}

TEST(OutputFile, FailuresNameTheFileAndHaveOneExitCode) {
  try {
    OutputFile file("/dev/full", "x.las");
    file.write("some bytes");
    file.close();
    FAIL() << "a full device took them";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::internal);
    EXPECT_EQ(std::string(error.what()).rfind("x.las: cannot be written (", 0), 0u) << error.what();
  }
}

TEST_F(UnfinishedFiles, OfDeadRunsAreSwept) {
  for (const char* name : {".isopach-1-a-x.laz", ".isopach-1-a-x.laz.las", ".isopach-1-b-y.ply", ".isopach-notes",
                           ".isopach-1-c-x.laz.las", ".isopach-1-d-x.laz", ".isopach-1-d-x.laz.las", "x.laz"})
    touch(name);
  const int lives = open((folder_ / ".isopach-1-d-x.laz").c_str(), O_RDONLY);
  ASSERT_EQ(flock(lives, LOCK_EX), 0);
  sweep_unfinished_files(folder_.string(), "x.laz");
  const auto left = [&](const char* name) { return fs::exists(folder_ / name); };
  EXPECT_FALSE(left(".isopach-1-a-x.laz") || left(".isopach-1-a-x.laz.las") || left(".isopach-1-c-x.laz.las"));
  EXPECT_TRUE(left(".isopach-1-b-y.ply") && left(".isopach-notes") && left("x.laz"));
  EXPECT_TRUE(left(".isopach-1-d-x.laz") && left(".isopach-1-d-x.laz.las"));
  close(lives);
  sweep_unfinished_files(folder_.string(), "");
  EXPECT_FALSE(left(".isopach-1-b-y.ply") || left(".isopach-1-d-x.laz"));
  EXPECT_TRUE(left(".isopach-notes") && left("x.laz"));
}

}  // namespace
}  // namespace isopach
