// A small plot of lines and dots as SVG, both axes logarithmic. Colours can be told apart by colour-blind readers.
#pragma once
#include <string>
#include <vector>

namespace isopach::bench {

struct Series {
  std::string name;
  std::vector<double> x, y;  ///< positive
  bool line = true;          ///< false: dots alone
};

struct Plot {
  std::string title, x_label, y_label;
  std::vector<Series> series;
};

[[nodiscard]] std::string svg(const Plot& plot);

}  // namespace isopach::bench
