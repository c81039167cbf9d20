// Damaged files: small valid files of each format, cut short and with bytes changed, a few hundred times each and
// always the same way. A reader returns or throws isopach::Error; it never crashes and never takes memory out of
// proportion.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "isopach/io/obj.hpp"
#include "isopach/io/pcd.hpp"
#include "isopach/io/ply.hpp"
#include "isopach/io/stl.hpp"
#include "isopach/io/text.hpp"
#include "isopach/io/write.hpp"
#include "tests/io/files.hpp"

namespace isopach {
namespace {

using test::bytes_of;
using test::hard_cloud;
using test::read_all;

using Parser = Cloud (*)(std::span<const char>, const std::string&, const ReadOptions&, const Context&);

std::uint64_t random_bits(std::uint64_t counter) {
  std::uint64_t x = counter * 0x9E3779B97F4A7C15u;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return x ^ (x >> 31);
}

std::string mutated(std::string text, std::uint64_t round) {
  const auto pick = [&](std::uint64_t which, std::size_t below) {
    return static_cast<std::size_t>(random_bits(round * 16 + which) % below);
  };
  if (round % 3 == 0) text.resize(pick(0, text.size()) + 1);
  const std::size_t changes = round % 3 == 0 ? round % 2 : 1 + pick(1, 4);
  for (std::size_t k = 0; k < changes; ++k) {
    const std::size_t at = pick(2 + 3 * k, text.size());
    static constexpr std::string_view digits = "0123456789-.,; \n\"/\\";
    if (round % 2 == 0)
      text[at] = static_cast<char>(pick(3 + 3 * k, 256));
    else
      text[at] = digits[pick(4 + 3 * k, digits.size())];
  }
  return text;
}

void survive(Parser parse, const std::string& valid) {
  ASSERT_NO_THROW((void)parse(bytes_of(valid), "valid", read_all(), Context{}));
  std::size_t read = 0, refused = 0;
  for (std::uint64_t round = 1; round <= 600; ++round) {
    const std::string text = mutated(valid, round);
    SCOPED_TRACE(fmt::format("round {}", round));
    try {
      const Cloud cloud = parse(bytes_of(text), "damaged", read_all(), Context{});
      ++read;
      EXPECT_GT(cloud.points.size(), 0u);
      EXPECT_LE(cloud.points.size(), text.size());
      for (const Attribute& a : cloud.attributes) EXPECT_EQ(a.values.size(), cloud.points.size());
      for (const auto& face : cloud.faces)
        for (const Index corner : face) EXPECT_LT(corner, cloud.points.size());
    } catch (const Error& error) {
      ++refused;
      const std::string message = error.what();
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
      EXPECT_NE(message.find("damaged"), std::string::npos) << message;
    }
  }
  EXPECT_GT(refused, 20u);  // the changes do bite
  EXPECT_GT(read, 5u);
}

std::string written(const std::string& end) {
  const test::TempFolder folder;
  Cloud cloud = hard_cloud();
  if (end == ".stl" || end == ".las") cloud.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  write_cloud(folder / ("a" + end), cloud, Context{});
  return test::file_content(folder / ("a" + end));
}

TEST(MutationTest, Text) {
  survive(parse_text, written(".csv"));
  survive(parse_text, written(".xyz"));
  survive(parse_text, "3\n1,5;2;3;4\n5;6,25;7;8\n9;10;11;12\n");
  survive(parse_text, "2\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n1 2 3 4\n5 6 7 8\n");
}

TEST(MutationTest, Ply) {
  survive(parse_ply, written(".ply"));
  survive(parse_ply,
          "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty list uchar int n\nproperty float y\n"
          "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 1 7 0 0\n1 0 0 0\n"
          "1 2 3 4 1 0\n0 0 1 0\n4 0 1 2 3\n");
}

TEST(MutationTest, Obj) {
  survive(parse_obj, written(".obj"));
  survive(parse_obj, "v 0 0 0 1 0 0\nv 1 0 0\\\n\nv 0 1 0\nv 0 0 1\nf 1/1 2/2 3/3 4/4\nf -1 -2 -3\n");
}

TEST(MutationTest, Stl) {
  survive(parse_stl, written(".stl"));
  survive(parse_stl,
          "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
          "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n");
}

TEST(MutationTest, Pcd) {
  survive(parse_pcd, written(".pcd"));
  survive(parse_pcd,
          "VERSION 0.7\nFIELDS x y z n\nSIZE 4 4 4 2\nTYPE F F F U\nCOUNT 1 1 1 2\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA "
          "ascii\n"
          "1 2 3 4 5\n6 7 8 9 10\n");
  // 1 point of 3 doubles 1.0 in LZF: eight literals, then a reference eight back of sixteen.
  std::string compressed =
      "VERSION 0.7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA "
      "binary_compressed\n";
  compressed += std::string("\x0C\0\0\0\x18\0\0\0\x07\0\0\0\0\0\0\xF0\x3F\xE0\x07\x07", 20);
  survive(parse_pcd, compressed);
}

// Whatever the bytes, the dispatcher finds a reader or a reason.
TEST(MutationTest, Dispatcher) {
  const test::TempFolder folder;
  std::uint64_t round = 0;
  for (const std::string end : {".ply", ".csv", ".pcd", ".obj", ".stl", ".las"}) {
    const std::string valid = written(end);
    for (int i = 0; i < 60; ++i) {
      const std::string path = folder / ("damaged" + end);
      test::write_file(path, mutated(valid, ++round));
      try {
        EXPECT_GT(read_cloud(path, read_all(), Context{}).points.size(), 0u);
      } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("damaged" + end), std::string::npos) << error.what();
      }
    }
  }
}

}  // namespace
}  // namespace isopach
