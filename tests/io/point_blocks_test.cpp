#include "isopach/io/point_blocks.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "isopach/base/parallel.hpp"
#include "isopach/io/copc.hpp"
#include "isopach/io/las.hpp"
#include "isopach/io/write.hpp"
#include "tests/io/files.hpp"
#include "tests/support/copc.hpp"
#include "tests/support/random.hpp"
#include "tests/support/shared_data.hpp"

namespace isopach {
namespace {

namespace fs = std::filesystem;

constexpr double infinite = std::numeric_limits<double>::infinity();

ReadOptions everything() {
  ReadOptions options;
  options.all_attributes = true;
  return options;
}

class PointBlocks : public testing::Test {
 protected:
  [[nodiscard]] std::string file(const std::string& name) const { return folder_ / name; }
  test::TempFolder folder_;
};

void append(Cloud& all, const Cloud& block) {
  all.points.insert(all.points.end(), block.points.begin(), block.points.end());
  if (all.attributes.empty()) all.attributes.resize(block.attributes.size());
  for (std::size_t k = 0; k < block.attributes.size(); ++k) {
    all.attributes[k].name = block.attributes[k].name;
    Array<double>& values = all.attributes[k].values;
    values.insert(values.end(), block.attributes[k].values.begin(), block.attributes[k].values.end());
  }
}

// The blocks of a file, one behind the other, and what is known of it beside them; of a box, if there is one.
Cloud from_blocks(const std::string& path, std::size_t most, const PlanBox* box = nullptr) {
  Cloud all;
  const auto take = [&](const Cloud& block) {
    EXPECT_GT(block.points.size(), 0u);
    EXPECT_LE(block.points.size(), most);
    EXPECT_EQ(block.path, path);
    append(all, block);
  };
  Cloud rest = box != nullptr ? for_each_block_in(path, *box, everything(), {}, take, most)
                              : for_each_block(path, everything(), {}, take, most);
  EXPECT_EQ(rest.points.size(), 0u);
  rest.points = std::move(all.points);
  if (!rest.points.empty()) rest.attributes = std::move(all.attributes);
  return rest;
}

void expect_equal(const Cloud& blocks, const Cloud& whole) {
  test::expect_same(blocks, whole);
  EXPECT_EQ(blocks.path, whole.path);
  EXPECT_EQ(blocks.format, whole.format);
  EXPECT_EQ(blocks.unit, whole.unit);
  EXPECT_EQ(blocks.vertical_unit, whole.vertical_unit);
  EXPECT_EQ(blocks.crs, whole.crs);
  EXPECT_EQ(blocks.notes, whole.notes);
  EXPECT_EQ(blocks.nodata, whole.nodata);
  EXPECT_EQ(blocks.grid.has_value(), whole.grid.has_value());
}

void expect_blocks(const std::string& path) {
  const Cloud whole = read_cloud(path, everything(), {});
  for (const std::size_t most : {whole.points.size() / 7 + 1, points_in_block}) {
    SCOPED_TRACE(fmt::format("{} by {}", path, most));
    expect_equal(from_blocks(path, most), whole);
  }
}

Cloud cropped(Cloud cloud, const PlanBox& box) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const Point3 p = cloud.points[i];
    if (!(box.min_x <= p.x && p.x < box.max_x && box.min_y <= p.y && p.y < box.max_y)) continue;
    cloud.points[kept] = p;
    for (Attribute& a : cloud.attributes) a.values[kept] = a.values[i];
    ++kept;
  }
  cloud.points.resize(kept);
  for (Attribute& a : cloud.attributes) a.values.resize(kept);
  return cloud;
}

// A surface of `count` points with 0.01 steps, so that points lie on the sides of boxes.
Cloud surface(std::size_t count, double height, double extent = 100) {
  Cloud cloud;
  test::Random random(7);
  cloud.attributes = {{"classification", {}}, {"intensity", {}}};
  const auto step = [&](double value) { return std::round(value * 100) / 100; };
  for (std::size_t i = 0; i < count; ++i) {
    const double x = step(random.uniform(0, extent)), y = step(random.uniform(0, extent));
    cloud.points.push_back({500000 + x, 5400000 + y, step(300 + height * random.uniform())});
    cloud.attributes[0].values.push_back(static_cast<double>(random.below(20)));
    cloud.attributes[1].values.push_back(static_cast<double>(random.below(60000)));
  }
  return cloud;
}

PlanBox random_box(test::Random& random, const Cloud& cloud) {
  const auto side = [&](double from, double extent, double& low, double& high) {
    low = from + extent * random.uniform(-0.1, 1), high = low + extent * std::pow(random.uniform(), 3);
  };
  PlanBox box;
  side(500000, 100, box.min_x, box.max_x), side(5400000, 100, box.min_y, box.max_y);
  if (random.below(3) == 0) box.min_x = cloud.points[random.below(cloud.points.size())].x;  // exactly on a point
  if (random.below(3) == 0) box.max_y = cloud.points[random.below(cloud.points.size())].y;
  if (random.below(20) == 0) box.max_x = infinite;
  return box;
}

void expect_boxes(const std::string& path, int boxes = 200) {
  const Cloud whole = read_cloud(path, everything(), {});
  test::Random random(11);
  for (int i = 0; i < boxes; ++i) {
    const PlanBox box = random_box(random, whole);
    SCOPED_TRACE(fmt::format("{} box {}: {} {} {} {}", path, i, box.min_x, box.min_y, box.max_x, box.max_y));
    test::expect_same(from_blocks(path, 5000, &box), cropped(whole, box));
    if (testing::Test::HasFailure()) return;
  }
}

test::CopcShape tall_cube(double side = 100) {
  return {{500000 + side / 2, 5400000 + side / 2, 300 + side / 2}, side / 2 + 1, 4, true};
}

TEST_F(PointBlocks, EqualTheWholeFile) {
  Cloud cloud = surface(30000, 20);
  cloud.crs = "EPSG:25832";
  for (const char* const name : {"a.las", "a.laz", "a.ply", "a.xyz", "a.csv", "a.pcd", "a.obj"}) {
    write_cloud(file(name), cloud, {});
    expect_blocks(file(name));
  }
  test::write_copc(file("a.las"), file("a.copc.laz"), tall_cube());
  expect_blocks(file("a.copc.laz"));
}

TEST_F(PointBlocks, DoNotDependOnThreads) {
  write_cloud(file("a.laz"), surface(120000, 20), {});
  const Cloud whole = read_cloud(file("a.laz"), everything(), {});
  for (const int threads : {1, 2, 7}) {
    Context context;
    context.threads = threads;
    Cloud all;
    (void)for_each_block(
        file("a.laz"), everything(), context, [&](const Cloud& block) { append(all, block); }, 40000);
    test::expect_same(all, whole);
  }
}

TEST_F(PointBlocks, TextWithAllThatTextMayHave) {
  const auto expect = [&](const std::string& name, const std::string& text) {
    test::write_file(file(name), text);
    expect_blocks(file(name));
  };
  expect("header.txt",
         "# made by hand\n\nEasting [m];Northing;Height (ft);class\n1,5;2;3;4\n\n# between\n5;6;7;8\n9;10;11;12");
  expect("count.pts", "4\n1 2 3 7\n4 5 6 8\n7 8 9 9\n");
  expect("marked.csv", "\xEF\xBB\xBFx,y,z\r\n1,2,3\r\n4,5,6\r\n\r\n");
  expect("scan.ptx", "2\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n5 0 0 1\n1 2 3 4\n0 0 0 0\n");
}

TEST_F(PointBlocks, PlyOfAllKinds) {
  const std::string vertices =
      "element vertex 3\nproperty float x\nproperty uchar red\nproperty double y\nproperty short z\n";
  const std::string faces = "element face 1\nproperty list uchar int vertex_indices\n";
  const std::string rows = "1 2 3 4\n5 6 7 8\n9 10 11 12\n", ascii = "ply\nformat ascii 1.0\ncomment unit: mm\n";
  const auto expect = [&](const std::string& text) {
    test::write_file(file("a.ply"), text);
    expect_blocks(file("a.ply"));
  };
  expect(ascii + vertices + "end_header\n" + rows);
  expect(ascii + vertices + faces + "end_header\n" + rows + "3 0 1 2\n");
  expect(ascii + "element camera 1\nproperty float f\n" + vertices + "end_header\n1\n" + rows);
  expect(ascii +
         "element vertex 1\nproperty list uchar int n\nproperty float x\nproperty float y\nproperty float z\n"
         "end_header\n2 7 8 1 2 3\n");
  Cloud mesh = surface(5, 1);
  mesh.faces = {{0, 1, 2}, {2, 3, 4}};
  write_cloud(file("mesh.ply"), mesh, {});
  expect_blocks(file("mesh.ply"));
  for (const char* const order : {"little", "big"})
    expect(fmt::format("ply\nformat binary_{}_endian 1.0\nelement camera 2\nproperty uchar f\n", order) + vertices +
           "end_header\n.." + std::string(45, '\1'));
}

// Longer than the pieces a text is read in (32 MiB), so that lines run across their ends.
TEST_F(PointBlocks, LongText) {
  std::string text = "# x y z\n";
  test::Random random(3);
  while (text.size() < (std::size_t{34} << 20)) {
    text +=
        fmt::format("{:.3f} {:.3f} {:.3f}\n", random.uniform(5e5, 6e5), random.uniform(5e6, 6e6), random.uniform(0, 9));
    if (random.below(1000) == 0) text += "# a comment\n\n";
  }
  test::write_file(file("long.xyz"), text);
  const Cloud whole = read_cloud(file("long.xyz"), everything(), {});
  expect_equal(from_blocks(file("long.xyz"), 300000), whole);
  const std::size_t lines = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  test::write_file(file("bad.xyz"), text + "1 2 three\n");
  test::expect_input_error([&] { (void)from_blocks(file("bad.xyz"), 300000); }, "bad.xyz",
                           fmt::format("line {}: \"three\"", lines + 1));
}

// Whatever read_cloud makes of a file, a block at a time or not.
TEST_F(PointBlocks, EqualTheWholeFileForEverythingThatIsShared) {
  ISOPACH_SHARED_OR_SKIP(formats, "formats");
  const auto message = [](auto&& work) -> std::string {
    try {
      work();
      return "";
    } catch (const Error& error) {
      return error.what();
    }
  };
  int read = 0;
  for (const auto& entry : fs::recursive_directory_iterator(formats)) {
    if (!entry.is_regular_file()) continue;
    const std::string path = entry.path().string();
    SCOPED_TRACE(path);
    const std::string failure = message([&] { (void)read_cloud(path, everything(), {}); });
    EXPECT_EQ(message([&] { (void)from_blocks(path, points_in_block); }), failure);
    if (!failure.empty()) continue;
    expect_blocks(path);
    ++read;
  }
  EXPECT_GT(read, 50);
}

TEST_F(PointBlocks, DamagedFilesAreRefused) {
  write_cloud(file("a.las"), surface(1000, 1), {});
  write_cloud(file("a.laz"), surface(1000, 1), {});
  write_cloud(file("a.ply"), surface(1000, 1), {});
  for (const char* const name : {"a.las", "a.laz", "a.ply"}) {
    const std::string good = test::file_content(file(name));
    test::write_file(file(name), good.substr(0, good.size() * 2 / 3));
    test::expect_input_error([&] { (void)from_blocks(file(name), 100); }, name, "");
  }
  test::expect_input_error([&] { (void)from_blocks(file("none.las"), 100); }, "none.las", "no such file");
}

TEST_F(PointBlocks, AFileThatChangesIsRefused) {
  write_cloud(file("a.las"), surface(600000, 1), {});
  test::expect_input_error(
      [&] {
        (void)for_each_block(
            file("a.las"), everything(), {}, [&](const Cloud&) { fs::resize_file(file("a.las"), 400); }, 1000);
      },
      "a.las", "while it was read");
}

TEST_F(PointBlocks, WhatTheTakerThrowsGoesThrough) {
  write_cloud(file("a.ply"), surface(100, 1), {});
  const auto take = [](const Cloud&) { throw Interrupted(); };
  EXPECT_THROW((void)for_each_block(file("a.ply"), everything(), {}, take), Interrupted);
}

TEST_F(PointBlocks, BoxEqualsCroppedRead) {
  const Cloud cloud = surface(20000, 30);
  for (const char* const name : {"a.las", "a.laz", "a.ply", "a.xyz"}) {
    write_cloud(file(name), cloud, {});
    expect_boxes(file(name), std::string(name) == "a.xyz" ? 20 : 200);
  }
}

TEST_F(PointBlocks, BoxOfCopcEqualsCroppedRead) {
  write_cloud(file("a.las"), surface(20000, 90), {});
  for (const bool pages : {false, true}) {
    test::CopcShape shape = tall_cube();
    shape.levels = 3, shape.pages = pages;
    test::write_copc(file("a.las"), file("a.copc.laz"), shape);
    expect_boxes(file("a.copc.laz"));
  }
}

// The sides of nodes lie 0.00003 below a step of the scale: points on that step were below the side before they were
// rounded, stand in the node below, and belong to a box that begins with the step.
TEST_F(PointBlocks, BoxOfCopcWithPointsThatRoundingTookOutOfTheirNodes) {
  Cloud cloud = surface(4000, 90);
  test::CopcShape shape = tall_cube();
  const double side = shape.centre[0] - shape.half / 2;
  for (std::size_t i = 0; i < cloud.points.size(); i += 2) cloud.points[i].x = side;
  shape.centre[0] -= 0.00003, shape.levels = 3;
  write_cloud(file("a.las"), cloud, {});
  test::write_copc(file("a.las"), file("a.copc.laz"), shape);
  const Cloud whole = read_cloud(file("a.copc.laz"), everything(), {});
  const PlanBox box{side, -infinite, infinite, infinite};
  EXPECT_GT(cropped(whole, box).points.size(), 2000u);
  test::expect_same(from_blocks(file("a.copc.laz"), 1000, &box), cropped(whole, box));
}

// The heights of the points, and so the header's, take a thousandth of the cube: what is pruned by them is lost.
TEST_F(PointBlocks, BoxOfCopcThatIsFlatInATallCube) {
  write_cloud(file("flat.las"), surface(20000, 0.1), {});
  test::write_copc(file("flat.las"), file("flat.copc.laz"), tall_cube());
  expect_boxes(file("flat.copc.laz"));
}

TEST_F(PointBlocks, BoxOfSharedCopc) {
  for (const char* const name : {"formats/lasr/example.copc.laz", "formats/pdal-las/1.2-with-color.copc.laz",
                                 "formats/laspy/simple_with_page.copc.laz"}) {
    ISOPACH_SHARED_OR_SKIP(path, name);
    const Cloud whole = read_cloud(path.string(), everything(), {});
    Point3 low{infinite, infinite, 0}, high{-infinite, -infinite, 0};
    for (const Point3& p : whole.points)
      low = {std::min(low.x, p.x), std::min(low.y, p.y), 0}, high = {std::max(high.x, p.x), std::max(high.y, p.y), 0};
    test::Random random(5);
    for (int i = 0; i < 200; ++i) {
      SCOPED_TRACE(fmt::format("{} {}", name, i));
      PlanBox box{random.uniform(low.x, high.x), random.uniform(low.y, high.y), 0, 0};
      box.max_x = box.min_x + (high.x - low.x) * std::pow(random.uniform(), 2);
      box.max_y = box.min_y + (high.y - low.y) * std::pow(random.uniform(), 2);
      test::expect_same(from_blocks(path.string(), points_in_block, &box), cropped(whole, box));
    }
    const std::string bytes = test::file_content(path.string());
    const auto chunks = copc_chunks(parse_las(bytes, name), {-infinite, -infinite, infinite, infinite});
    ASSERT_TRUE(chunks.has_value()) << name;
  }
}

TEST_F(PointBlocks, BoxOfCopcReadsWhatItMeetsAlone) {
  write_cloud(file("a.las"), surface(20000, 90), {});
  test::write_copc(file("a.las"), file("a.copc.laz"), tall_cube());
  const std::string bytes = test::file_content(file("a.copc.laz"));
  const LasFile las = parse_las(bytes, "a.copc.laz");
  const auto points = [&](const PlanBox& box) {
    const std::optional<std::vector<LazChunk>> chunks = copc_chunks(las, box);
    std::size_t sum = 0;
    for (const LazChunk& chunk : chunks.value()) sum += chunk.points;
    return sum;
  };
  EXPECT_EQ(points({-infinite, -infinite, infinite, infinite}), 20000u);
  EXPECT_EQ(points({0, 0, 1, 1}), 0u);
  const std::size_t few = points({500010, 5400010, 500011, 5400011});
  EXPECT_GT(few, 0u);
  EXPECT_LT(few, 9000u);  // the root, and one column of nodes of each level below it
}

// Where the index does not name what is there, nothing is left out because of it.
TEST_F(PointBlocks, BoxOfCopcWithADamagedIndex) {
  write_cloud(file("a.las"), surface(3000, 90), {});
  test::CopcShape shape = tall_cube();
  shape.levels = 3;
  test::write_copc(file("a.las"), file("a.copc.laz"), shape);
  const Cloud whole = read_cloud(file("a.copc.laz"), everything(), {});
  const PlanBox box{500010, 5400010, 500060, 5400060};
  const Cloud wanted = cropped(whole, box);
  const std::string good = test::file_content(file("a.copc.laz"));
  const LasFile las = parse_las(good, "a.copc.laz");
  const std::size_t index = las.extended.front().at + 60;
  test::Random random(2);
  for (int i = 0; i < 200; ++i) {
    std::string bytes = good;
    // A node that moves within the octree cannot be told from a true one: keys are left alone.
    const std::size_t entry = index + 32 * random.below((good.size() - index) / 32);
    const std::size_t at = i % 3 == 0 ? 375 + 54 + 40 + random.below(16) : entry + 16 + random.below(16);
    bytes[at] = static_cast<char>(bytes[at] ^ (1 << random.below(8)));
    test::write_file(file("bad.laz"), bytes);
    try {
      test::expect_same(from_blocks(file("bad.laz"), 1000, &box), wanted);
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("bad.laz"), std::string::npos);
    }
  }
}

TEST_F(PointBlocks, SummaryOfTheHeader) {
  Cloud cloud = surface(500, 10);
  cloud.crs = "EPSG:25832", cloud.unit = "m";
  for (const char* const name : {"a.las", "a.laz", "a.ply", "a.xyz", "a.obj"}) {
    write_cloud(file(name), cloud, {});
    const FileSummary found = summarise(file(name), everything(), {});
    const Cloud whole = read_cloud(file(name), everything(), {});
    EXPECT_EQ(found.bytes, fs::file_size(file(name)));
    EXPECT_GT(found.modified_ns, 0);
    if (std::string(name) == "a.obj") {
      EXPECT_EQ(found.format, "obj");
      continue;
    }
    EXPECT_EQ(found.format, whole.format);
    EXPECT_EQ(found.crs, whole.crs);
    EXPECT_EQ(found.unit, whole.unit);
    EXPECT_EQ(found.attributes.size(), whole.attributes.size());
    if (std::string(name) == "a.xyz") continue;
    EXPECT_EQ(found.points, 500u);
  }
  const FileSummary las = summarise(file("a.las"), everything(), {});
  ASSERT_TRUE(las.bounds.has_value());
  for (const Point3& p : read_cloud(file("a.las"), {}, {}).points) {
    EXPECT_TRUE(las.bounds->min.x <= p.x && las.bounds->min.y <= p.y && las.bounds->min.z <= p.z);
    EXPECT_TRUE(las.bounds->max.x >= p.x && las.bounds->max.y >= p.y && las.bounds->max.z >= p.z);
  }
}

}  // namespace
}  // namespace isopach
