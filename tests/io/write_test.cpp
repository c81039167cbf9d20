#include "isopach/io/write.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "tests/io/files.hpp"

namespace isopach {
namespace {

using test::expect_same;
using test::file_content;
using test::hard_cloud;
using test::read_all;
using test::TempFolder;
using test::write_file;

void expect_usage_error(const std::function<void()>& work, const std::string& part) {
  try {
    work();
    ADD_FAILURE() << "no error";
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
  }
}

// A curved grid. A side of 760 gives more rows than are formatted at once, one of 150 several blocks of them.
Cloud grid_cloud(int side) {
  Cloud cloud;
  cloud.attributes = {{"dz", {}}};
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      cloud.points.push_back({501000 + 0.001 * i, 5401000 + 0.003 * j, std::sin(0.01 * i) / (1 + j)});
      cloud.attributes[0].values.push_back(1.0 / (1 + i + j));
    }
  return cloud;
}

TEST(WriteTest, RoundTripsAreExact) {
  const TempFolder folder;
  const Cloud cloud = hard_cloud();
  for (const std::string name : {"a.ply", "a.xyz", "a.txt", "a.csv", "a.pcd", "A.CSV"}) {
    SCOPED_TRACE(name);
    write_cloud(folder / name, cloud, Context{});
    const Cloud back = read_cloud(folder / name, read_all(), Context{});
    Cloud expected = cloud;
    if (name != "a.ply") expected.faces.clear();
    expect_same(expected, back);
    EXPECT_EQ(back.path, folder / name);
  }
  EXPECT_EQ(folder.files(), 6u);  // and no temporary ones
}

TEST(WriteTest, RoundTripOfObj) {
  const TempFolder folder;
  Cloud cloud = hard_cloud();
  cloud.attributes = {{"red", {0.5, 0, 1, 0.1, 0.2}}, {"green", {1, 1, 1, 1, 1}}, {"blue", {0, 0, 0, 0, 0.7}}};
  write_cloud(folder / "a.obj", cloud, Context{});
  expect_same(cloud, read_cloud(folder / "a.obj", read_all(), Context{}));
}

TEST(WriteTest, RoundTripOfStl) {
  const TempFolder folder;
  Cloud cloud;
  cloud.points = {{0, 0, 0.5}, {1024.25, 0, -3}, {1024.25, 100, 0.125}, {0, 100, 7}};
  cloud.faces = {{0, 1, 2}, {0, 2, 3}};
  write_cloud(folder / "a.stl", cloud, Context{});
  expect_same(cloud, read_cloud(folder / "a.stl", read_all(), Context{}));
  EXPECT_EQ(file_content(folder / "a.stl").size(), 84u + 2 * 50u);
  float normal[3];
  std::memcpy(normal, file_content(folder / "a.stl").data() + 84, sizeof normal);
  EXPECT_NEAR(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2], 1, 1e-6);
  EXPECT_GT(normal[2], 0.9);
}

TEST(WriteTest, NotFiniteNumbersComeBack) {
  const TempFolder folder;
  Cloud cloud;
  cloud.points = {{1, 2, NAN}, {INFINITY, -INFINITY, 3}};
  for (const std::string name : {"a.ply", "a.xyz", "a.csv", "a.pcd", "a.obj"}) {
    write_cloud(folder / name, cloud, Context{});
    const Cloud back = read_cloud(folder / name, {}, Context{});
    ASSERT_EQ(back.points.size(), 2u) << name;
    EXPECT_TRUE(std::isnan(back.points[0].z)) << name;
    EXPECT_EQ(back.points[1], cloud.points[1]) << name;
  }
}

TEST(WriteTest, UnitAndCrsTravelInPly) {
  const TempFolder folder;
  Cloud cloud = hard_cloud();
  cloud.unit = "us-ft";
  cloud.vertical_unit = "m";
  cloud.crs = "EPSG:25832";
  write_cloud(folder / "a.ply", cloud, Context{});
  const Cloud back = read_cloud(folder / "a.ply", {}, Context{});
  EXPECT_EQ(back.unit, "us-ft");
  EXPECT_EQ(back.vertical_unit, "m");
  EXPECT_EQ(back.crs, "EPSG:25832");
}

TEST(WriteTest, Npy) {
  const TempFolder folder;
  const Cloud cloud = hard_cloud();
  write_cloud(folder / "a.npy", cloud, Context{});
  const std::string content = file_content(folder / "a.npy");
  ASSERT_EQ(content.substr(0, 8), std::string("\x93NUMPY\x01\x00", 8));
  const std::size_t header = static_cast<unsigned char>(content[8]) + 256u * static_cast<unsigned char>(content[9]);
  EXPECT_EQ((10 + header) % 64, 0u);
  EXPECT_NE(content.find("'shape': (5, 3)"), std::string::npos);
  ASSERT_EQ(content.size(), 10 + header + 5 * 24);
  EXPECT_EQ(std::memcmp(content.data() + 10 + header, cloud.points.data(), 5 * 24), 0);
}

TEST(WriteTest, SameBytesForAnyNumberOfThreads) {
  const TempFolder folder;
  for (const std::string end : {".ply", ".csv"}) {
    const Cloud cloud = grid_cloud(end == ".ply" ? 760 : 150);
    Context context;
    context.threads = 1;
    write_cloud(folder / ("one" + end), cloud, context);
    const std::string one = file_content(folder / ("one" + end));
    for (const int threads : {2, 7}) {
      context.threads = threads;
      write_cloud(folder / ("many" + end), cloud, context);
      EXPECT_EQ(one, file_content(folder / ("many" + end))) << threads;
    }
    expect_same(cloud, read_cloud(folder / ("one" + end), read_all(), Context{}));
  }
}

TEST(WriteTest, WhatAFormatCannotHoldIsRefused) {
  const TempFolder folder;
  Cloud cloud = hard_cloud();
  expect_usage_error([&] { write_cloud(folder / "a.docx", cloud, Context{}); }, ".ply, .xyz");
  expect_usage_error([&] { write_cloud(folder / "a", cloud, Context{}); }, "unknown extension");
  expect_usage_error([&] { write_cloud(folder / "a.tif", cloud, Context{}); }, "raster");
  cloud.points = {{501234.567, 5401234.891, 412.003}, {501235, 5401235, 412}, {501236, 5401234, 412}};
  cloud.attributes.clear();
  cloud.faces = {{0, 1, 2}};
  expect_usage_error([&] { write_cloud(folder / "a.stl", cloud, Context{}); }, "32-bit");
  cloud.faces.clear();
  expect_usage_error([&] { write_cloud(folder / "a.stl", cloud, Context{}); }, "triangles");
  EXPECT_EQ(folder.files(), 0u);
}

TEST(WriteTest, WholeOrNotAtAll) {
  const TempFolder folder;
  const std::string target = folder / "result.txt";
  write_file(target, "old");
  EXPECT_THROW(write_atomically(target,
                                [&](const std::string& temporary) {
                                  EXPECT_NE(temporary, target);
                                  EXPECT_EQ(std::filesystem::path(temporary).extension(), ".txt");
                                  write_file(temporary, "half");
                                  EXPECT_EQ(file_content(target), "old");
                                  throw InputError("stopped");
                                }),
               InputError);
  EXPECT_EQ(file_content(target), "old");
  EXPECT_EQ(folder.files(), 1u);
  write_atomically(target, [](const std::string& temporary) { write_file(temporary, "new"); });
  EXPECT_EQ(file_content(target), "new");
  EXPECT_EQ(folder.files(), 1u);
}

TEST(WriteTest, StoppedByTheUser) {
  const TempFolder folder;
  std::atomic<bool> stop{true};
  Context context;
  context.cancelled = &stop;
  EXPECT_THROW(write_cloud(folder / "a.ply", hard_cloud(), context), Interrupted);
  EXPECT_EQ(folder.files(), 0u);
}

TEST(WriteTest, FolderMustExist) {
  const TempFolder folder;
  expect_usage_error([&] { write_cloud(folder / "none/a.ply", hard_cloud(), Context{}); }, "does not exist");
  std::filesystem::create_directory(folder / "b.ply");
  expect_usage_error([&] { write_cloud(folder / "b.ply", hard_cloud(), Context{}); }, "is a folder");
}

TEST(WriteTest, FolderMustBeWritable) {
  const TempFolder folder;
  std::filesystem::create_directory(folder / "closed");
  std::filesystem::permissions(folder / "closed",
                               std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  // The superuser may write anywhere: as root the test is nobody for a moment.
  const uid_t user = ::geteuid(), nobody = 65534;
  if (user == 0) {
    ASSERT_EQ(::seteuid(nobody), 0);
  }
  expect_usage_error([&] { write_cloud(folder / "closed/a.ply", hard_cloud(), Context{}); }, "may not be written");
  ASSERT_EQ(::seteuid(user), 0);
}

TEST(WriteTest, LinksAreFollowed) {
  const TempFolder folder;
  write_file(folder / "real.xyz", "old");
  std::filesystem::create_symlink(folder / "real.xyz", folder / "link.xyz");
  write_cloud(folder / "link.xyz", hard_cloud(), Context{});
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link.xyz"));
  EXPECT_EQ(read_cloud(folder / "real.xyz", {}, Context{}).points.size(), 5u);
}

TEST(WriteTest, DevicesAreWrittenNotReplaced) {
  write_atomically("/dev/null", [](const std::string& path) { EXPECT_EQ(path, "/dev/null"); });
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

}  // namespace
}  // namespace isopach
