#include "bench/support/page.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>

namespace isopach::bench {
namespace {

std::string row(const std::vector<std::string>& cells) {
  std::string line = "|";
  for (const std::string& cell : cells) line += " " + cell + " |";
  return line + "\n";
}

}  // namespace

void Page::add(const std::string& text) {
  text_ += text;
  fmt::print("{}", text);
  std::fflush(stdout);
}

void Page::heading(const std::string& text) { add("\n## " + text + "\n"); }
void Page::paragraph(const std::string& text) { add("\n" + text + "\n"); }
void Page::picture(const std::string& file, const std::string& caption) { add("\n![" + caption + "](" + file + ")\n"); }

void Page::table(const std::vector<std::vector<std::string>>& rows) {
  if (rows.empty()) return;
  std::string text = "\n" + row(rows[0]) + "|---|";
  for (std::size_t i = 1; i < rows[0].size(); ++i) text += "--:|";
  text += "\n";
  for (std::size_t i = 1; i < rows.size(); ++i) text += row(rows[i]);
  add(text);
}

std::string number(double x) {
  const double size = std::fabs(x);
  if (size >= 99.95) return fmt::format("{:.0f}", x);
  if (size >= 9.995) return fmt::format("{:.1f}", x);
  return fmt::format("{:.2f}", x);
}

std::string count(std::size_t n) {
  std::string digits = std::to_string(n);
  for (std::size_t i = digits.size(); i > 3; i -= 3) digits.insert(i - 3, " ");
  return digits;
}

std::string nanoseconds(double seconds, std::size_t nodes) {
  return number(1e9 * seconds / static_cast<double>(nodes));
}

std::string against(double value, double target) { return number(value) + (value <= target ? "" : " (not reached)"); }

}  // namespace isopach::bench
