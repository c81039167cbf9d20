#include "isopach/report/draw/agreement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "isopach/base/error.hpp"
#include "isopach/report/page/words.hpp"

namespace isopach {
namespace {

constexpr Rgb paper{1, 1, 1}, ink{0.13, 0.14, 0.16}, faint{0.42, 0.44, 0.47}, rule{0.55, 0.57, 0.6};
constexpr std::size_t kinds = 4;
// By the numbers of PointVerdict. The three that matter differ in lightness too.
constexpr std::array<Rgb, kinds> colours{Rgb{0.83, 0.84, 0.85}, Rgb{0.35, 0.62, 0.84}, Rgb{0.84, 0.37, 0.0},
                                         Rgb{0.36, 0.12, 0.42}};
constexpr std::array<const char*, kinds> names{"not in view", "agrees", "in front", "behind"};

struct Panel {
  Box2 box;
  double scale = 1;
  int columns = 1, rows = 1;
};

/// Each point a square about as wide as the points are apart.
Image paint(const Array<Point3>& places, const Array<PointVerdict>& labels, const Panel& panel) {
  Image image{panel.columns, panel.rows, {}};
  const auto width = static_cast<std::size_t>(panel.columns), height = static_cast<std::size_t>(panel.rows);
  image.rgb.assign(3 * width * height, 255);
  std::vector<float> depth(width * height, -std::numeric_limits<float>::infinity());
  const double area = static_cast<double>(width * height) / std::max<double>(1, static_cast<double>(places.size()));
  const long half = std::clamp(std::lround(0.8 * std::sqrt(area)), 0L, 12L);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Point3& p = places[i];
    if (!is_finite(p)) continue;
    const long x = std::lround((p.x - panel.box.min.x) * panel.scale),
               y = std::lround((panel.box.max.y - p.y) * panel.scale);
    const Rgb& c = colours[static_cast<std::size_t>(labels[i])];
    for (long row = std::max(0L, y - half); row <= std::min<long>(panel.rows - 1, y + half); ++row)
      for (long column = std::max(0L, x - half); column <= std::min<long>(panel.columns - 1, x + half); ++column) {
        const std::size_t at = static_cast<std::size_t>(row) * width + static_cast<std::size_t>(column);
        const auto z = static_cast<float>(p.z);
        if (!(z > depth[at])) continue;
        depth[at] = z;
        const std::array<double, 3> rgb{c.r, c.g, c.b};
        for (std::size_t k = 0; k < 3; ++k)
          image.rgb[3 * at + k] = static_cast<unsigned char>(std::lround(255 * rgb[k]));
      }
  }
  return image;
}

std::array<double, kinds> shares(const Array<PointVerdict>& labels) {
  std::array<double, kinds> result{};
  for (const PointVerdict a : labels) result[static_cast<std::size_t>(a)] += 1;
  for (double& r : result) r /= std::max<double>(1, static_cast<double>(labels.size()));
  return result;
}

void draw_key(Canvas& canvas, const Array<PointVerdict>& labels, double x, double y, double s) {
  const Canvas::Font soft{16 * s, false, ink};
  const std::array<double, kinds> part = shares(labels);
  for (const std::size_t k : {1u, 2u, 3u, 0u}) {
    const std::string words = fmt::format("{}: {:.0f} % of the points", names[k], 100 * part[k]);
    canvas.box(x, y - 13 * s, 26 * s, 15 * s, colours[k]);
    canvas.frame(x, y - 13 * s, 26 * s, 15 * s, s, rule);
    canvas.text(x + 34 * s, y, words, soft);
    x += 34 * s + canvas.text_width(words, soft) + 36 * s;
  }
}

}  // namespace

Image render_agreement(const CloudView& moving, const Matching& m, const Frame& frame, int width,
                       const Context& context) {
  if (width < 300 || width > 20000)
    throw UsageError("map width " + std::to_string(width) + ": must be between 300 and 20000 pixels");
  context.check();
  Array<Point3> places(moving.points.size());
  Panel panel;
  for (std::size_t i = 0; i < places.size(); ++i) {
    places[i] = frame.to_field(m.pose.apply(moving.points[i]));
    if (is_finite(places[i])) panel.box.add(Point2{places[i].x, places[i].y});
  }
  if (panel.box.empty()) panel.box.add(Point2{0, 0});
  const double s = width / 1600.0, margin = 44 * s;
  const double wide = std::max(panel.box.max.x - panel.box.min.x, 1e-300),
               tall = std::max(panel.box.max.y - panel.box.min.y, 1e-300);
  panel.scale = std::min((width - 2 * margin) / wide, 1100 * s / tall);
  panel.columns = std::max(1, static_cast<int>(std::lround(wide * panel.scale)) + 1);
  panel.rows = std::max(1, static_cast<int>(std::lround(tall * panel.scale)) + 1);

  const Canvas::Font title{31 * s, true, ink}, strong{21.5 * s, false, ink}, soft{16 * s, false, faint};
  Canvas ruler(8, 8, paper);
  const std::vector<std::string> lines =
      m.verdict ? ruler.wrapped(message_text(sentence(*m.verdict, unit_text(m.unit))), strong, width - 2 * margin)
                : std::vector<std::string>{};
  const double top = (80 + 30 * static_cast<double>(lines.size())) * s;
  Canvas canvas(width, static_cast<int>(std::lround(top + panel.rows + 136 * s)), paper);
  canvas.text(margin, 56 * s,
              canvas.fitted(input_name(m.moving) + " on " + input_name(m.fixed), title, width - 2 * margin), title);
  for (std::size_t k = 0; k < lines.size(); ++k)
    canvas.text(margin, (95 + 30 * static_cast<double>(k)) * s, lines[k], strong);
  const int left = (width - panel.columns) / 2, at = static_cast<int>(std::lround(top));
  canvas.picture(left, at, paint(places, m.agreement, panel));
  canvas.frame(left - 0.5 * s, at - 0.5 * s, panel.columns + s, panel.rows + s, 1.5 * s, rule);
  draw_key(canvas, m.agreement, margin, top + panel.rows + 44 * s, s);
  const double below = top + panel.rows;
  canvas.text(
      margin, below + 84 * s,
      "the moving scan in place; in front: where the fixed scan saw through; behind: where it cannot have seen; "
      "agrees: within three standard deviations of the noise of both",
      soft);
  canvas.text(
      margin, below + 110 * s,
      "these percentages count points of the moving scan; those above count area seen by either scan, and allow "
      "for what a scan differs from itself",
      soft);
  return canvas.image();
}

void write_agreement(const std::string& path, const CloudView& moving, const Matching& m, const Frame& frame, int width,
                     const Context& context) {
  write_png(path, render_agreement(moving, m, frame, width, context));
}

}  // namespace isopach
