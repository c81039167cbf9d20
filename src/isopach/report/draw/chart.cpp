#include "isopach/report/draw/chart.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "isopach/report/page/page.hpp"
#include "isopach/report/page/words.hpp"

namespace isopach {
namespace {

constexpr double width = 1000, height = 320, left = 78, right = 18, top = 30, bottom = 52;
constexpr std::array<const char*, 4> colours{"#0072b2", "#d55e00", "#009e73", "#cc79a7"};  // Okabe and Ito

bool finite(const Point2& p) { return std::isfinite(p.x) && std::isfinite(p.y); }

/// 1, 2 or 5 times a power of ten, about `count` of them in `span`.
double tick_step(double span, double count) {
  const double raw = span / count, power = std::pow(10, std::floor(std::log10(raw)));
  for (const double m : {1.0, 2.0, 5.0})
    if (raw <= m * power) return m * power;
  return 10 * power;
}

struct Axis {
  double low, high, from, to;  // values, places
  [[nodiscard]] double place(double v) const { return from + (v - low) / (high - low) * (to - from); }
};

void widen(double& low, double& high) {
  if (high > low) return;
  const double d = low == 0 ? 1 : 0.1 * std::fabs(low);
  low -= d, high += d;
}

class Drawing {
 public:
  explicit Drawing(const Chart& chart) : chart_(chart) {}

  std::string write() {
    for (const ChartSeries& s : chart_.series)
      for (const Point2& p : s.points)
        if (finite(p)) box_.add(p);
    if (box_.empty()) return "";
    set_axes();
    out_ = fmt::format("<figure><svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\" font-size=\"13\">\n", width,
                       height_, escaped(chart_.title));
    ticks();
    std::size_t i = 0;
    for (const ChartSeries& s : chart_.series) draw(s, i++);
    return out_ + "</svg>\n<figcaption>" + escaped(chart_.title) + "</figcaption></figure>\n";
  }

 private:
  void set_axes() {
    widen(box_.min.x, box_.max.x);
    widen(box_.min.y, box_.max.y);
    const double margin = 0.05 * (box_.max.y - box_.min.y);
    box_.min.y -= margin, box_.max.y += margin;
    if (chart_.equal_scales) {
      height_ = 520;
      const double scale = std::min((width - left - right) / (box_.max.x - box_.min.x),
                                    (height_ - top - bottom) / (box_.max.y - box_.min.y));
      const double half = (width - left - right) / scale / 2, middle = (box_.min.x + box_.max.x) / 2;
      const double half_y = (height_ - top - bottom) / scale / 2, middle_y = (box_.min.y + box_.max.y) / 2;
      box_ = {{middle - half, middle_y - half_y}, {middle + half, middle_y + half_y}};
    }
    x_ = {box_.min.x, box_.max.x, left, width - right};
    y_ = {box_.min.y, box_.max.y, height_ - bottom, top};
  }

  void ticks() {
    const double step_x = tick_step(x_.high - x_.low, 8), step_y = tick_step(y_.high - y_.low, 5);
    for (double v = std::ceil(y_.low / step_y) * step_y; v <= y_.high; v += step_y)
      out_ += fmt::format(
          "<path d=\"M{} {:.1f}H{}\" stroke=\"currentColor\" stroke-opacity=\".25\"/><text x=\"{}\" y=\"{:.1f}\" "
          "text-anchor=\"end\" fill=\"currentColor\">{}</text>\n",
          left, y_.place(v), width - right, left - 8, y_.place(v) + 4.5, label(v, step_y));
    for (double v = std::ceil(x_.low / step_x) * step_x; v <= x_.high; v += step_x)
      out_ += fmt::format(
          "<path d=\"M{0:.1f} {1}v5\" stroke=\"currentColor\"/><text x=\"{0:.1f}\" y=\"{2}\" text-anchor=\"middle\" "
          "fill=\"currentColor\">{3}</text>\n",
          x_.place(v), height_ - bottom, height_ - bottom + 19, label(v, step_x));
    out_ += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\" fill=\"currentColor\">{}</text>\n",
                        (left + width - right) / 2, height_ - 10, escaped(chart_.x_label));
    out_ += fmt::format("<text x=\"{}\" y=\"16\" fill=\"currentColor\">{}</text>\n", 8, escaped(chart_.y_label));
  }

  [[nodiscard]] static std::string label(double v, double step) {
    const int decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
    return fixed_number(std::fabs(v) < 1e-9 * step ? 0 : v, decimals, Typography::fine);
  }

  void draw(const ChartSeries& s, std::size_t i) {
    const char* colour = colours[i % colours.size()];
    std::string path;
    bool pen = false;
    for (const Point2& p : s.points) {
      if (!finite(p)) {
        pen = false;
        continue;
      }
      path += fmt::format("{}{:.1f} {:.1f}{}", pen && !s.dots ? "L" : "M", x_.place(p.x), y_.place(p.y),
                          s.dots ? "h0" : "");
      pen = true;
    }
    out_ += fmt::format(
        "<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linecap=\"round\" "
        "stroke-linejoin=\"round\"{}/>\n",
        path, colour, s.dots ? 5 : 2, s.dots ? " stroke-opacity=\".55\"" : "");
    const double x = width - right - 150 * static_cast<double>(chart_.series.size() - i);
    out_ += fmt::format(
        "<path d=\"M{:.0f} 12h18\" stroke=\"{}\" stroke-width=\"4\"/><text x=\"{:.0f}\" y=\"16\" "
        "fill=\"currentColor\">{}</text>\n",
        x, colour, x + 24, escaped(s.name));
  }

  const Chart& chart_;
  std::string out_;
  Box2 box_;
  Axis x_{}, y_{};
  double height_ = height;
};

}  // namespace

std::string chart_svg(const Chart& chart) { return Drawing(chart).write(); }

}  // namespace isopach
