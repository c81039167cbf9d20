// The page: Markdown that is printed while the benchmark runs and written to the documentation at its end.
#pragma once
#include <string>
#include <vector>

namespace isopach::bench {

class Page {
 public:
  void heading(const std::string& text);
  void paragraph(const std::string& text);
  void picture(const std::string& file, const std::string& caption);
  /// First row: names of the columns. The first column is text, the others are numbers set to the right.
  void table(const std::vector<std::vector<std::string>>& rows);
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  void add(const std::string& text);
  std::string text_;
};

[[nodiscard]] std::string number(double x);      ///< three digits, no exponent
[[nodiscard]] std::string count(std::size_t n);  ///< 1 000 000
[[nodiscard]] std::string nanoseconds(double seconds, std::size_t nodes);

/// "0.41 (not reached)" or "0.31": a ratio beside what it must not exceed.
[[nodiscard]] std::string against(double value, double target);

}  // namespace isopach::bench
