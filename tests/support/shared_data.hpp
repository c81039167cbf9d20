// Data that lives outside the project: real scans in a folder named by the environment variable ISOPACH_SHARED, else
// <source dir>/../shared. Tests that need it are skipped, with a message, where it is absent.
#pragma once
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>

namespace isopach::test {

[[nodiscard]] std::filesystem::path source_folder();

/// The file or folder `relative` of the shared data, e.g. "santacruz/blanca_strip8706_120m.las"; nothing if absent.
[[nodiscard]] inline std::optional<std::filesystem::path> shared_data(const std::string& relative) {
  const char* named = std::getenv("ISOPACH_SHARED");
  const std::filesystem::path root =
      named != nullptr && *named != 0 ? std::filesystem::path(named) : source_folder() / ".." / "shared";
  std::error_code ignored;
  for (const std::filesystem::path& folder : {root / "data", root})
    if (std::filesystem::exists(folder / relative, ignored)) return folder / relative;
  return std::nullopt;
}

}  // namespace isopach::test

/// Defines `variable` (a std::filesystem::path), or skips the running test with a message.
#define ISOPACH_SHARED_OR_SKIP(variable, relative)                                                             \
  const std::optional<std::filesystem::path> variable##_found = ::isopach::test::shared_data(relative);        \
  if (!variable##_found)                                                                                       \
    GTEST_SKIP() << "shared data absent: " << (relative) << " (set ISOPACH_SHARED to the folder of the data)"; \
  const std::filesystem::path variable = *variable##_found
