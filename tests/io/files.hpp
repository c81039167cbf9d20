// Helpers of the io tests: a folder that is removed again, files made from text, and what every error must look like.
#pragma once
#include <gtest/gtest.h>
#include <unistd.h>

#include <bit>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string>

#include "isopach/base/error.hpp"
#include "isopach/cloud/cloud.hpp"
#include "isopach/io/read.hpp"

namespace isopach::test {

class TempFolder {
 public:
  TempFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "isopach-io-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) ADD_FAILURE() << "no temporary folder";
    path_ = pattern;
  }
  ~TempFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  [[nodiscard]] std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  [[nodiscard]] std::size_t files() const {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(path_), std::filesystem::directory_iterator()));
  }

 private:
  std::filesystem::path path_;
};

inline void write_file(const std::string& path, const std::string& content) {
  std::ofstream(path, std::ios::binary) << content;
}

[[nodiscard]] inline std::string file_content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

[[nodiscard]] inline bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}
[[nodiscard]] inline bool same_bits(const Point3& a, const Point3& b) {
  return same_bits(a.x, b.x) && same_bits(a.y, b.y) && same_bits(a.z, b.z);
}

/// Equal points, attributes and faces, bit by bit.
inline void expect_same(const Cloud& a, const Cloud& b) {
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t i = 0; i < a.points.size(); ++i) ASSERT_TRUE(same_bits(a.points[i], b.points[i])) << "point " << i;
  ASSERT_EQ(a.attributes.size(), b.attributes.size());
  for (std::size_t k = 0; k < a.attributes.size(); ++k) {
    EXPECT_EQ(a.attributes[k].name, b.attributes[k].name);
    ASSERT_EQ(b.attributes[k].values.size(), b.points.size());
    for (std::size_t i = 0; i < a.points.size(); ++i)
      ASSERT_TRUE(same_bits(a.attributes[k].values[i], b.attributes[k].values[i])) << a.attributes[k].name << ' ' << i;
  }
  EXPECT_EQ(a.faces, b.faces);
}

/// `work` throws an InputError of one line that contains `name` and `part`.
template <class Work>
void expect_input_error(Work&& work, const std::string& name, const std::string& part) {
  try {
    work();
    ADD_FAILURE() << name << ": no error";
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find(name), std::string::npos) << message;
    EXPECT_NE(message.find(part), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_EQ(error.code(), ExitCode::input);
  }
}

[[nodiscard]] inline ReadOptions read_all() {
  ReadOptions options;
  options.all_attributes = true;
  options.faces = true;
  return options;
}

[[nodiscard]] inline std::span<const char> bytes_of(const std::string& text) { return {text.data(), text.size()}; }

/// Coordinates that do not survive careless arithmetic: map coordinates in millimetres, denormals, huge, minus zero.
[[nodiscard]] inline Cloud hard_cloud() {
  Cloud cloud;
  cloud.points = {{501234.567, 5401234.891, 412.003},
                  {0.1, -0.0, 1.0 / 3.0},
                  {4.9406564584124654e-324, 1.7976931348623157e308, -2.2250738585072014e-308},
                  {1e22, 9007199254740993.0, -123456789.123456789},
                  {500000.001, 5400000.0005, 0.30000000000000004}};
  cloud.attributes = {{"classification", {2, 6, 2, 9, 0}}, {"intensity", {0.1, 1e-300, -7, 65535, 3.0000000000000004}}};
  cloud.faces = {{0, 1, 2}, {2, 3, 4}};
  return cloud;
}

}  // namespace isopach::test
