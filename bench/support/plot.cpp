#include "bench/support/plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace isopach::bench {
namespace {

constexpr double width = 860, height = 460, left = 76, right = 250, top = 52, bottom = 62;
constexpr std::array<const char*, 8> colours = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                "#e69f00", "#56b4e9", "#555555", "#8c564b"};

/// A logarithmic axis from `low` to `high`, drawn from `from` to `to`.
struct Axis {
  double low, high, from, to;
  [[nodiscard]] double operator()(double value) const {
    return from + (to - from) * std::log10(value / low) / std::log10(high / low);
  }
};

/// 1, 2, 5, 10, …: as many as the axis needs, and all inside it.
std::vector<double> ticks(const Axis& axis) {
  const bool wide = std::log10(axis.high / axis.low) > 2.5;
  std::vector<double> found;
  for (int decade = static_cast<int>(std::floor(std::log10(axis.low))); std::pow(10, decade) <= axis.high * 1.001;
       ++decade)
    for (const double step : {1.0, 2.0, 5.0}) {
      if (wide && step > 1) continue;
      const double value = step * std::pow(10, decade);
      if (value >= axis.low * 0.999 && value <= axis.high * 1.001) found.push_back(value);
    }
  return found;
}

/// The values with a margin, widened to the next 1, 2 or 5.
Axis axis_of(const std::vector<Series>& series, std::vector<double> Series::*values, double from, double to) {
  double low = 1e300, high = 0;
  for (const Series& s : series)
    for (const double v : s.*values) low = std::min(low, v), high = std::max(high, v);
  if (!(high > 0)) return {1, 10, from, to};
  double below = 1e-12, above = 1e-12;
  for (int decade = -12; decade < 13; ++decade)
    for (const double step : {1.0, 2.0, 5.0}) {
      const double value = step * std::pow(10, decade);
      if (value <= low) below = value;
      if (above < high) above = value;
    }
  return {below, std::max(above, 2 * below), from, to};
}

std::string label(double value) {
  static const std::array<const char*, 10> raised = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  if (value < 0.001 || value >= 10000) {
    const int decade = static_cast<int>(std::floor(std::log10(value) + 1e-9));
    const double head = value / std::pow(10, decade);
    const std::string power =
        std::string(decade < 0 ? "⁻" : "") + raised[static_cast<std::size_t>(std::abs(decade) % 10)];
    return head > 1.5 ? fmt::format("{:.0f}·10{}", head, power) : "10" + power;
  }
  return fmt::format("{:g}", value);
}

std::string grid_lines(const Axis& x, const Axis& y) {
  std::string out;
  for (const double v : ticks(x))
    out += fmt::format(
        "<line x1='{0:.1f}' x2='{0:.1f}' y1='{1}' y2='{2}' stroke='#e6e6e6'/>"
        "<text x='{0:.1f}' y='{3}' text-anchor='middle' class='t'>{4}</text>\n",
        x(v), y.to, y.from, y.from + 20, label(v));
  for (const double v : ticks(y))
    out += fmt::format(
        "<line x1='{0}' x2='{1}' y1='{2:.1f}' y2='{2:.1f}' stroke='#e6e6e6'/>"
        "<text x='{3}' y='{4:.1f}' text-anchor='end' class='t'>{5}</text>\n",
        x.from, x.to, y(v), x.from - 8, y(v) + 4, label(v));
  return out + fmt::format("<path d='M{0} {1}V{2}H{3}' fill='none' stroke='#888'/>\n", x.from, y.to, y.from, x.to);
}

std::string drawn(const Series& s, const char* colour, const Axis& x, const Axis& y) {
  std::string path, dots;
  for (std::size_t i = 0; i < s.x.size(); ++i) {
    path += fmt::format("{}{:.1f} {:.1f}", i == 0 ? "M" : "L", x(s.x[i]), y(s.y[i]));
    dots +=
        fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='3.5' fill='{}' stroke='#fff'/>", x(s.x[i]), y(s.y[i]), colour);
  }
  if (s.line) path = fmt::format("<path d='{}' fill='none' stroke='{}' stroke-width='2'/>", path, colour);
  return (s.line ? path : "") + dots + "\n";
}

}  // namespace

std::string svg(const Plot& plot) {
  const Axis x = axis_of(plot.series, &Series::x, left, width - right);
  const Axis y = axis_of(plot.series, &Series::y, height - bottom, top);
  std::string out = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {0} {1}' width='{0}' height='{1}' "
      "font-family='DejaVu Sans, Verdana, sans-serif'>\n"
      "<style>.t{{font-size:12px;fill:#444}}.l{{font-size:13px;fill:#222}}</style>\n"
      "<rect width='{0}' height='{1}' fill='#fff'/>\n"
      "<text x='{2}' y='28' font-size='16' fill='#111'>{3}</text>\n",
      width, height, left, plot.title);
  out += grid_lines(x, y);
  out += fmt::format("<text x='{:.1f}' y='{}' text-anchor='middle' class='l'>{}</text>\n", 0.5 * (x.from + x.to),
                     height - 16, plot.x_label);
  const double middle = 0.5 * (y.from + y.to);
  out += fmt::format(
      "<text x='18' y='{0:.1f}' text-anchor='middle' class='l' transform='rotate(-90 18 {0:.1f})'>{1}</text>\n", middle,
      plot.y_label);
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const char* colour = colours[i % colours.size()];
    const double line = top + 8 + 22 * static_cast<double>(i);
    out += drawn(plot.series[i], colour, x, y);
    out += fmt::format("<circle cx='{}' cy='{}' r='5' fill='{}'/><text x='{}' y='{}' class='l'>{}</text>\n",
                       width - right + 26, line, colour, width - right + 38, line + 4.5, plot.series[i].name);
  }
  return out + "</svg>\n";
}

}  // namespace isopach::bench
