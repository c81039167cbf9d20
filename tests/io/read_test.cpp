#include "isopach/io/read.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <sstream>
#include <vector>

#include "isopach/io/write.hpp"
#include "tests/io/files.hpp"
#include "tests/support/shared_data.hpp"

namespace isopach {
namespace {

using test::expect_input_error;
using test::read_all;
using test::TempFolder;
using test::write_file;

void expect_unreadable(const std::string& path, const std::string& part) {
  expect_input_error([&] { (void)read_cloud(path, {}, Context{}); }, path, part);
}

TEST(ReadTest, FilesThatCannotBeRead) {
  const TempFolder folder;
  expect_unreadable(folder / "none.ply", "no such file");
  std::filesystem::create_directory(folder / "folder.ply");
  expect_unreadable(folder / "folder.ply", "is a folder");
  write_file(folder / "empty.xyz", "");
  expect_unreadable(folder / "empty.xyz", "is empty");
  write_file(folder / "scan.bin", std::string("\x01\x02\x00\x03garbage", 11));
  expect_unreadable(folder / "scan.bin", "binary file of unknown format");
  write_file(folder / "scan.xyz", std::string("ASTM-E57\x01\x00\x00\x00", 12));
  expect_unreadable(folder / "scan.xyz", "this is an E57 file, which is not read: convert it to PLY or LAS");
  write_file(folder / "scan.ply", "1 2 3\n");
  expect_unreadable(folder / "scan.ply", "not a PLY file");
  write_file(folder / "scan.tif", "1 2 3\n");
  expect_unreadable(folder / "scan.tif", "scan.tif");
}

TEST(ReadTest, ContentBeforeExtension) {
  const TempFolder folder;
  Cloud cloud = test::hard_cloud();
  cloud.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  for (const std::string end : {"ply", "pcd", "stl", "obj", "las"}) {
    write_cloud(folder / ("a." + end), cloud, Context{});
    std::filesystem::rename(folder / ("a." + end), folder / "renamed.txt");
    EXPECT_EQ(read_cloud(folder / "renamed.txt", {}, Context{}).format, end);
  }
  write_file(folder / "a.dat", "1 2 3\n");
  EXPECT_EQ(read_cloud(folder / "a.dat", {}, Context{}).format, "xyz");
  write_file(folder / "grid.xyz", "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n3 4\n");
  EXPECT_EQ(read_cloud(folder / "grid.xyz", {}, Context{}).format, "raster");
}

TEST(ReadTest, OptionThreadsAndStop) {
  const TempFolder folder;
  write_cloud(folder / "a.ply", test::hard_cloud(), Context{});
  Context context;
  context.threads = 3;
  EXPECT_EQ(read_cloud(folder / "a.ply", {}, context).points.size(), 5u);
  std::atomic<bool> stop{true};
  context.cancelled = &stop;
  EXPECT_THROW((void)read_cloud(folder / "a.ply", {}, context), Interrupted);
}

// ---- real files

struct Expected {
  std::size_t points = 0, not_numbers = 0;
  std::array<double, 3> min{}, max{};
  bool scientific = false;  // printed with seven digits, else with four decimals
};

std::array<double, 3> numbers_after(const std::string& line, const std::string& key) {
  std::istringstream stream(line.substr(line.find(key) + key.size()));
  std::array<double, 3> numbers{};
  stream >> numbers[0] >> numbers[1] >> numbers[2];
  return numbers;
}

// What the list's own reader takes otherwise: it does not decode compressed points, takes x, y, x for x, y, z, and
// decimal commas in grids for points, which are refused here.
bool read_otherwise(const std::string& line) {
  for (const char* mark : {"not decoded", "binary_compressed", "badheader", "pixel_per_line_comma"})
    if (line.find(mark) != std::string::npos) return true;
  return false;
}

// Lines such as "formats/pcl/bun0.pcd: n=397 nan=0 min=[a b c] max=[a b c] ...".
std::map<std::string, Expected> read_expected(const std::filesystem::path& check) {
  std::map<std::string, Expected> files;
  std::ifstream stream(check);
  std::string line;
  while (std::getline(stream, line)) {
    const std::size_t end = line.find(": n=");
    if (line.rfind("formats/", 0) != 0 || end == std::string::npos || read_otherwise(line)) continue;
    if (line.find("max=[") == std::string::npos || line.find(']', line.find("max=[")) == std::string::npos) continue;
    Expected& expected = files[line.substr(8, end - 8)];
    expected.points = std::stoull(line.substr(end + 4));
    expected.not_numbers = std::stoull(line.substr(line.find("nan=") + 4));
    expected.min = numbers_after(line, "min=[");
    expected.max = numbers_after(line, "max=[");
    expected.scientific = line.find("e+") != std::string::npos;
  }
  return files;
}

void expect_cloud(const Cloud& cloud, const Expected& expected) {
  ASSERT_EQ(cloud.points.size(), expected.points);
  Box3 box;
  std::size_t not_numbers = 0;
  for (const Point3& p : cloud.points) {
    if (is_finite(p))
      box.add(p);
    else
      ++not_numbers;
  }
  EXPECT_EQ(not_numbers, expected.not_numbers);
  const std::array<double, 3> min = {box.min.x, box.min.y, box.min.z}, max = {box.max.x, box.max.y, box.max.z};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto tolerance = [&](double value) { return expected.scientific ? 1e-6 * std::fabs(value) + 6e-5 : 6e-5; };
    EXPECT_NEAR(min[k], expected.min[k], tolerance(expected.min[k])) << "axis " << k;
    EXPECT_NEAR(max[k], expected.max[k], tolerance(expected.max[k])) << "axis " << k;
  }
}

TEST(ReadTest, RealFilesReadRightOrFailClearly) {
  ISOPACH_SHARED_OR_SKIP(formats, "formats");
  const auto expected = read_expected(formats / "CHECK.txt");
  std::size_t compared = 0, files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(formats)) {
    if (!entry.is_regular_file() || entry.path().parent_path() == formats) continue;
    const std::string name = std::filesystem::relative(entry.path(), formats).string();
    SCOPED_TRACE(name);
    ++files;
    const auto known = expected.find(name);
    if (known != expected.end()) {
      ++compared;
      Cloud cloud;
      ASSERT_NO_THROW(cloud = read_cloud(entry.path().string(), read_all(), Context{}));
      expect_cloud(cloud, known->second);
      continue;
    }
    try {
      EXPECT_GT(read_cloud(entry.path().string(), read_all(), Context{}).points.size(), 0u);
    } catch (const InputError& error) {
      const std::string message = error.what();
      EXPECT_NE(message.find(entry.path().filename().string()), std::string::npos) << message;
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
  }
  EXPECT_GT(compared, files / 4) << "CHECK.txt names too few of the files";
}

// Pairs of files that hold the same points in two formats or encodings.
TEST(ReadTest, RealFilesAgreeAcrossFormats) {
  ISOPACH_SHARED_OR_SKIP(formats, "formats");
  const std::pair<const char*, const char*> pairs[] = {
      {"loadersgl-ripple/ripple_ascii.ply", "loadersgl-ripple/ripple_bin.ply"},
      {"happly/platonic_shelf_ascii.ply", "happly/platonic_shelf.ply"},
      {"pdal-ply/simple_text.ply", "pdal-ply/simple_binary.ply"},
      {"assimp/Spider_ascii.stl", "assimp/Spider_binary.stl"},
      {"pdal-pcd/utm17_comma.pcd", "pdal-pcd/utm17_space.pcd"},
      {"pdal-txt/utm17_1.txt", "pdal-txt/utm17_2.txt"},
      {"pdal-txt/utm17_1.txt", "pdal-txt/crlf_test.txt"},
      {"pdal-las/simple.las", "pdal-pts/1.2-with-color.ptx"},
  };
  for (const auto& [first, second] : pairs) {
    if (!std::filesystem::exists(formats / first) || !std::filesystem::exists(formats / second)) continue;
    SCOPED_TRACE(first);
    const Cloud a = read_cloud((formats / first).string(), read_all(), Context{});
    const Cloud b = read_cloud((formats / second).string(), read_all(), Context{});
    ASSERT_EQ(a.points.size(), b.points.size());
    for (std::size_t i = 0; i < a.points.size(); ++i) {
      EXPECT_NEAR(a.points[i].x, b.points[i].x, 1e-5);
      EXPECT_NEAR(a.points[i].y, b.points[i].y, 1e-5);
      EXPECT_NEAR(a.points[i].z, b.points[i].z, 1e-5);
    }
  }
}

}  // namespace
}  // namespace isopach
