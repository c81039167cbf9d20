// difference.png, difference.svg, the map of report.pdf. Layout: title and numbers on top; the map with coordinates on
// its frame; the colour bar with the histogram beside it (under it, for wide maps); scale bar and notes at the foot.
// All lengths in 1/1600 of the width.
#include "isopach/report/draw/map.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/io/output_file.hpp"
#include "isopach/report/draw/hillshade.hpp"
#include "isopach/report/draw/palette.hpp"
#include "isopach/report/draw/raster.hpp"
#include "isopach/report/draw/svg.hpp"
#include "isopach/report/page/furniture.hpp"
#include "isopach/report/page/uncertainty.hpp"
#include "isopach/report/page/words.hpp"

namespace isopach {
namespace {

constexpr Rgb paper{1, 1, 1}, ink{0.13, 0.14, 0.16}, faint{0.42, 0.44, 0.47}, rule{0.55, 0.57, 0.60};
constexpr Rgb outside{0.965, 0.965, 0.96}, footprint{0.925, 0.925, 0.92}, hatch{0.80, 0.80, 0.795},
    bars{0.66, 0.68, 0.71};
constexpr int samples = 2;                // each way in a pixel: smooth rims
constexpr double longest_aspect = 25;     // longer scenes get empty margins
constexpr double margin_share = 0.15;     // how much of what lies outside the domain is shown
constexpr double own_colours = 1.6;       // times the 99th percentile: a largest |d| up to this is not cut off
constexpr double least_over_noise = 1.5;  // times the level of detection: colours reach at least so far
constexpr Typography fine = Typography::fine;

double round_up_2_digits(double v) {
  const double step = std::pow(10.0, std::floor(std::log10(v)) - 1);
  return std::ceil(v / step - 1e-9) * step;
}

/// The greatest of 1, 2, 5 × 10^k that is ≤ v.
double nice_below(double v) {
  const double power = std::pow(10.0, std::floor(std::log10(v)));
  return (v >= 5 * power ? 5 : v >= 2 * power ? 2 : 1) * power;
}
double largest(const DifferenceStatistics& d) { return std::max(d.max_above, d.max_below); }

// Without a level of detection.
double natural_limit(const Comparison& c) {
  const DifferenceStatistics& d = c.measures.difference;
  const double p99 = d.abs_percentiles.back(), most = largest(d);
  return round_up_2_digits(p99 > 0 && most > own_colours * p99 ? p99 : std::max(p99, most));
}

double nice_above(double v) {
  const double below = nice_below(v);
  return below >= v ? below : nice_below(v * 2.5);
}

Box2 node_box(const Cells& cells, bool domain_only) {
  Box2 all = reduce_blocks<Box2>(
      cells.triangulation.real, 1 << 16,
      [&](std::size_t begin, std::size_t end) {
        Box2 box;
        for (std::size_t t = begin; t < end; ++t)
          if (!domain_only || cells.in_domain[t] != 0)
            for (const Index v : cells.triangulation.triangles[t].v) box.add(cells.xy[v]);
        return box;
      },
      [](Box2& left, const Box2& right) { left.add(right); });
  for (const CellPiece& piece : cells.pieces)
    for (const Corner& corner : piece.at) all.add(Point2{corner.x, corner.y});
  return all;
}

/// What is shown: the domain, some of its surroundings, a thin margin. Never empty.
Box2 shown_box(const Cells& cells) {
  const Box2 all = node_box(cells, false), domain = node_box(cells, true);
  if (all.empty()) return {{0, 0}, {1, 1}};
  Box2 box = all;
  if (!domain.empty()) {
    const double reach = margin_share * std::max(domain.max.x - domain.min.x, domain.max.y - domain.min.y);
    box.min = {std::max(all.min.x, domain.min.x - reach), std::max(all.min.y, domain.min.y - reach)};
    box.max = {std::min(all.max.x, domain.max.x + reach), std::min(all.max.y, domain.max.y + reach)};
  }
  double width = box.max.x - box.min.x, height = box.max.y - box.min.y;
  const double size = std::max(width, height) > 0 ? std::max(width, height) : 1;
  const auto grow = [](double& low, double& high, double to) {
    const double by = (to - (high - low)) / 2;
    low -= by, high += by;
  };
  grow(box.min.x, box.max.x, std::max(width, size / longest_aspect) + 0.02 * size);
  grow(box.min.y, box.max.y, std::max(height, size / longest_aspect) + 0.02 * size);
  return box;
}

bool meet(const Box2& a, const Box2& b) {
  return !a.empty() && !b.empty() && a.min.x <= b.max.x && b.min.x <= a.max.x && a.min.y <= b.max.y &&
         b.min.y <= a.max.y;
}

/// The extent that was asked for, in the frame. Errors: as render_map.
Box2 asked_box(const Comparison& c, const Box2& extent) {
  const auto text = [](const Box2& b) { return fmt::format("{},{},{},{}", b.min.x, b.min.y, b.max.x, b.max.y); };
  constexpr std::array<double, 9> upright{1, 0, 0, 0, 1, 0, 0, 0, 1};
  if (c.frame.rotation != upright)
    throw UsageError("@extent: it is in x and y, so it goes with @direction z alone; leave the one or the other out");
  const Point3& o = c.frame.origin;
  const Box2 box{{extent.min.x - o.x, extent.min.y - o.y}, {extent.max.x - o.x, extent.max.y - o.y}};
  const double width = box.max.x - box.min.x, height = box.max.y - box.min.y;
  if (!(width > 0 && height > 0) || std::max(width, height) > longest_aspect * std::min(width, height))
    throw UsageError(
        fmt::format("@extent {}: a map of {:.6g} by {:.6g} would be a line; take sides that differ by at "
                    "most {} times",
                    text(extent), width, height, longest_aspect));
  const Box2 all = node_box(c.cells, false);
  if (meet(all, box)) return box;
  const Box2 there{{all.min.x + o.x, all.min.y + o.y}, {all.max.x + o.x, all.max.y + o.y}};
  throw UsageError(
      fmt::format("@extent {}: the scans do not reach into it: they lie in {}; give x and y as in the "
                  "files, or leave it out",
                  text(extent), all.empty() ? "no place" : text(there)));
}

Box2 box_of(const Comparison& c, const MapOptions& options, const MapScale& scale) {
  if (options.extent) return asked_box(c, *options.extent);
  return scale.box ? *scale.box : shown_box(c.cells);
}

/// How one axis of the map reads in input coordinates.
struct Axis {
  std::string name;
  double sign = 1, offset = 0;  // coordinate = offset + sign · frame coordinate
};
Axis axis_of(const Frame& frame, std::size_t row) {
  const std::array<double, 3> origin{frame.origin.x, frame.origin.y, frame.origin.z};
  if (frame.axis_aligned)
    for (std::size_t k = 0; k < 3; ++k)
      if (std::fabs(frame.rotation[3 * row + k]) == 1)
        return {std::string(1, static_cast<char>('x' + static_cast<char>(k))), frame.rotation[3 * row + k], origin[k]};
  return {row == 0 ? "u" : "v", 1, 0};
}

/// The middle of a label of half-width `half`, moved to stay between the two ends where there is room.
double within(double middle, double low, double high, double half) {
  return high - low < 2 * half ? middle : std::clamp(middle, low + half, high - half);
}

struct Tick {
  double at;  // frame coordinate
  std::string label;
};
/// Round coordinates at least `spacing` apart; at least one where any round number can be found.
std::vector<Tick> ticks(const Axis& axis, double low, double high, double spacing) {
  const double first = axis.offset + axis.sign * low, last = axis.offset + axis.sign * high;
  const double a = std::min(first, last), b = std::max(first, last);
  double step = nice_above(std::max(spacing, (b - a) / 12));
  bool crowded = false;
  for (int k = 0; k < 60 && std::ceil(a / step) * step > b; ++k) step = nice_below(step / 2), crowded = true;
  const int decimals = std::clamp(-static_cast<int>(std::floor(std::log10(step) + 1e-9)), 0, 9);
  std::vector<Tick> out;
  for (double k = std::ceil(a / step); k * step <= b && out.size() < 40; ++k)
    out.push_back({(k * step - axis.offset) * axis.sign, fixed_number(k * step, decimals, fine)});
  if (crowded && out.size() > 1) out = {out[out.size() / 2]};
  return out;
}

/// `stripe`: width of the hatching in samples.
Image shade_and_colour(const CellRaster& raster, const Hillshade& shade, const Palette& palette, double limit,
                       std::size_t stripe) {
  Image image;
  image.width = raster.view.columns / samples;
  image.height = raster.view.rows / samples;
  image.rgb.resize(3 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  const auto colour = [&](std::size_t i) -> Rgb {
    if (raster.cover[i] == CellRaster::Cover::none) return outside;
    if (raster.cover[i] == CellRaster::Cover::footprint) {
      const std::size_t columns = static_cast<std::size_t>(raster.view.columns);
      return (i / columns + i % columns) / stripe % 9 == 0 ? hatch : footprint;
    }
    const bool is_noise = !raster.lod.empty() && std::fabs(raster.d[i]) <= raster.lod[i];
    const Rgb& c = is_noise ? noise_colour : palette(raster.d[i] / limit);
    const double g = shade.grey[i];
    return {c.r * g, c.g * g, c.b * g};
  };
  const auto byte = [](double v) { return static_cast<unsigned char>(std::lround(255 * std::clamp(v, 0.0, 1.0))); };
  for_blocks(static_cast<std::size_t>(image.height), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row)
      for (std::size_t column = 0; column < static_cast<std::size_t>(image.width); ++column) {
        Rgb sum{0, 0, 0};
        for (std::size_t k = 0; k < samples * samples; ++k) {
          const Rgb c = colour((row * samples + k / samples) * static_cast<std::size_t>(raster.view.columns) +
                               column * samples + k % samples);
          sum.r += c.r, sum.g += c.g, sum.b += c.b;
        }
        constexpr double share = 1.0 / (samples * samples);
        unsigned char* out = &image.rgb[3 * (row * static_cast<std::size_t>(image.width) + column)];
        out[0] = byte(sum.r * share), out[1] = byte(sum.g * share), out[2] = byte(sum.b * share);
      }
  });
  return image;
}

/// The colour bar in its own coordinates: `along` from −L to +L, `across` away from the histogram.
struct BarPlace {
  double x, y;  // of −L, on the side of the histogram
  double length, thickness;
  bool upright;
  struct Pixel {
    double x, y;
  };
  [[nodiscard]] Pixel at(double along, double across) const {
    return upright ? Pixel{x + across, y - along} : Pixel{x + along, y + across};
  }
};

}  // namespace

class MapDrawing::Map {
 public:
  Map(const Comparison& c, const MapOptions& options, const MapScale& scale)
      : c_(c),
        options_(options),
        is_paired_(scale.colour_limit > 0 && !(options.range > 0)),
        bare_(scale.bare),
        s_(scale.words * options.width / 1600.0),
        limit_(is_paired_ ? scale.colour_limit : colour_limit(c, options)),
        palette_(options.palette, options.flip != paints_excess_red(c.unit)),
        box_(box_of(c, options, scale)),
        signature_(signature(c, options, "   ·   ")) {
    place();
  }

  [[nodiscard]] int height() const { return height_; }

  void draw(Pen& canvas) {
    MapView view{box_.min.x, box_.max.y, scale_ * samples, columns_ * samples, rows_ * samples};
    const CellRaster raster = rasterise(c_.cells, view);
    const Hillshade shade = hillshade(raster);
    has_footprint_ =
        std::find(raster.cover.begin(), raster.cover.end(), CellRaster::Cover::footprint) != raster.cover.end();
    exaggeration_ = shade.exaggeration;

    const auto stripe = static_cast<std::size_t>(std::max(1L, std::lround(1.8 * s_ * samples)));
    canvas.picture(panel_x_, panel_y_, shade_and_colour(raster, shade, palette_, limit_, stripe));
    canvas.frame(panel_x_ - 0.5 * s_, panel_y_ - 0.5 * s_, columns_ + s_, rows_ + s_, 1.5 * s_, rule);
    canvas.clip(panel_x_, panel_y_, columns_, rows_);
    draw_lines(canvas);
    canvas.unclip();
    if (!bare_) draw_header(canvas);
    draw_axes(canvas);
    draw_bar(canvas);
    draw_foot(canvas);
  }

 private:
  void place() {
    const double width = box_.max.x - box_.min.x, height = box_.max.y - box_.min.y;
    upright_ = width < 1.9 * height;
    const double left = 100 * s_, right = upright_ ? 330 * s_ : 44 * s_, tallest = upright_ ? 1180 * s_ : 700 * s_;
    const double room = options_.width - left - right;
    scale_ = std::min(room / width, tallest / height);
    columns_ = std::max(1, static_cast<int>(std::lround(width * scale_)));
    rows_ = std::max(1, static_cast<int>(std::lround(height * scale_)));
    panel_x_ = static_cast<int>(std::lround(left + (room - columns_) / 2));
    panel_y_ = static_cast<int>(std::lround((bare_ ? 24 : direction_is_z() ? 158 : 190) * s_));
    const double content = upright_ ? std::max<double>(rows_, 460 * s_) : rows_;
    panel_y_ += static_cast<int>(std::lround((content - rows_) / 2));
    const double below = panel_y_ + rows_ / 2.0 + content / 2;
    if (upright_) {
      const double length = std::min(content - 110 * s_, 640 * s_);
      bar_ = {panel_x_ + columns_ + 138 * s_, below - (content - length) / 2, length, 30 * s_, true};
    } else {
      bar_ = {options_.width / 2.0 - 340 * s_, below + 156 * s_, 680 * s_, 26 * s_, false};
    }
    foot_y_ = below + (upright_ ? 96 : 262) * s_;
    key_y_ = foot_y_ + (bare_ ? 32 * s_ : 0);
    Canvas ruler(8, 8, paper);
    note_lines_ = std::min<std::size_t>(3, note_in_lines(ruler).size());
    signature_y_ = key_y_ + (38 + 24 * static_cast<double>(note_lines_)) * s_;
    const bool is_signed = !signature_.empty() && !bare_;
    height_ = static_cast<int>(
        std::lround(key_y_ + (50 + 24 * static_cast<double>(note_lines_)) * s_ + (is_signed ? 26 * s_ : 0)));
  }

  /// What is hatched. Under the hull rule a scan counts as far as its hull goes, points or not.
  [[nodiscard]] std::string left_out_words() const {
    std::string words = c_.options.border == BorderRule::hull ? "in the hull of one scan only, points or not"
                                                              : "points of one scan only, up to their border";
    if (c_.folds.area > 0 && c_.options.folds == FoldRule::leave_out) words += ", or folded";
    if (!c_.cells.unclipped.empty()) words += ", or cut off";
    return words + ": not compared";
  }
  [[nodiscard]] bool direction_is_z() const {
    return c_.frame.rotation[6] == 0 && c_.frame.rotation[7] == 0 && c_.frame.rotation[8] == 1;
  }
  [[nodiscard]] std::string with_unit(const std::string& text, int power) const {
    return text + "\u00a0" + measured_unit(c_, power);
  }

  void draw_header(Pen& canvas) const {
    const double x = 44 * s_, room = options_.width - 88 * s_ - draw_logo(canvas);
    const Pen::Font title{31 * s_, true, ink}, strong{21.5 * s_, false, ink}, soft{19 * s_, false, faint};
    const std::string name = options_.title.empty() ? input_name(c_.a) + " → " + input_name(c_.b) : options_.title;
    canvas.text(x, 56 * s_, canvas.fitted(name, title, room), title);
    const Volume& v = c_.measures.volume;
    const MapWords& words = options_.words;
    const std::string volumes = !words.headline.empty() ? words.headline
                                : shows_no_difference(c_)
                                    ? std::string("no difference")
                                    : "net " + with_unit(told(c_, "volume.net", v.net, fine, true), 3) +
                                          "   ·   gained " + with_unit(told(c_, "volume.above", v.above, fine), 3) +
                                          "   ·   lost " + with_unit(told(c_, "volume.below", v.below, fine), 3) +
                                          "   ·   mean |d| (ρ) " +
                                          with_unit(told(c_, "measure.rho", c_.measures.rho, fine), 1);
    canvas.text(x, 95 * s_, canvas.fitted(volumes, strong, room), strong);
    const std::string where = where_compared(c_);
    canvas.text(x, 125 * s_, canvas.fitted(words.where.empty() ? where : words.where, soft, room), soft);
    if (direction_is_z()) return;
    const auto& r = c_.frame.rotation;
    canvas.text(x, 155 * s_,
                "seen along (" + number(r[6], fine) + ", " + number(r[7], fine) + ", " + number(r[8], fine) + ")",
                soft);
  }

  /// In the upper right corner; the width that it takes.
  double draw_logo(Pen& canvas) const {
    if (options_.logo.image == nullptr) return 0;
    const Image& logo = *options_.logo.image;
    const double scale = std::min(240 * s_ / logo.width, 84 * s_ / logo.height), width = logo.width * scale;
    canvas.picture(options_.width - 44 * s_ - width, 30 * s_, logo, scale);
    return width + 30 * s_;
  }

  void draw_lines(Pen& canvas) const {
    const Pen::Font font{17 * s_, true, ink};
    const auto pixel = [&](const Point2& p) {
      return Point2{panel_x_ + (p.x - box_.min.x) * scale_, panel_y_ + (box_.max.y - p.y) * scale_};
    };
    for (const MapLine& line : options_.lines) {
      std::vector<Point2> corners;
      for (const Point2& p : line.xy) corners.push_back(pixel(p));
      canvas.path(corners, 2 * s_, ink);
      if (corners.empty()) continue;
      const Point2 p = corners.front();
      const Box2 panel{{panel_x_ - 1.0, panel_y_ - 1.0}, {panel_x_ + columns_ + 1.0, panel_y_ + rows_ + 1.0}};
      if (options_.extent && !meet(panel, {p, p})) continue;
      const double half = canvas.text_width(line.label, font) / 2;
      canvas.text(within(p.x, panel_x_, panel_x_ + columns_, half + 4 * s_),
                  std::clamp(p.y - 6 * s_, panel_y_ + 20 * s_, panel_y_ + rows_ - 4 * s_), line.label, font,
                  TextAlign::centre);
    }
  }

  void draw_axes(Pen& canvas) const {
    const Pen::Font font{17 * s_, false, faint};
    const Axis across = axis_of(c_.frame, 0), up = axis_of(c_.frame, 1);
    const double bottom = panel_y_ + rows_, tick = 7 * s_;
    const std::string unit = " (" + unit_text(c_.unit) + ")";
    const double label = 1.5 * canvas.text_width(widest(across, box_.min.x, box_.max.x), font);
    for (const Tick& t : ticks(across, box_.min.x, box_.max.x, label / scale_)) {
      const double x = panel_x_ + (t.at - box_.min.x) * scale_;
      canvas.line(x, bottom, x, bottom + tick, 1.5 * s_, rule);
      const double half = canvas.text_width(t.label, font) / 2;
      canvas.text(within(x, panel_x_, panel_x_ + columns_, half), bottom + 27 * s_, t.label, font, TextAlign::centre);
    }
    const double tall = 1.5 * canvas.text_width(widest(up, box_.min.y, box_.max.y), font);
    for (const Tick& t : ticks(up, box_.min.y, box_.max.y, tall / scale_)) {
      const double y = panel_y_ + (box_.max.y - t.at) * scale_;
      canvas.line(panel_x_ - tick, y, panel_x_, y, 1.5 * s_, rule);
      const double half = canvas.text_width(t.label, font) / 2;
      canvas.text_upwards(panel_x_ - 14 * s_, within(y, panel_y_, bottom, half), t.label, font, TextAlign::centre);
    }
    canvas.text(panel_x_ + columns_ / 2.0, bottom + 52 * s_, named_or(options_.words.across, across.name) + unit, font,
                TextAlign::centre);
    canvas.text_upwards(panel_x_ - 42 * s_, panel_y_ + rows_ / 2.0, named_or(options_.words.up, up.name) + unit, font,
                        TextAlign::centre);
  }
  [[nodiscard]] static const std::string& named_or(const std::string& name, const std::string& otherwise) {
    return name.empty() ? otherwise : name;
  }
  [[nodiscard]] std::string widest(const Axis& axis, double low, double high) const {
    const double a = axis.offset + axis.sign * low, b = axis.offset + axis.sign * high;
    const int decimals = std::max(0, decimals_for(high - low) - 2);
    return fixed_number(std::fabs(a) > std::fabs(b) ? a : b, decimals, fine);
  }

  void draw_histogram(Pen& canvas) const {
    const Histogram& h = c_.measures.difference.histogram;
    const double deep = (bar_.upright ? 96 : 74) * s_;
    double most = 0;
    const auto density = [&](std::size_t i) { return h.areas[i] / (h.edges[i + 1] - h.edges[i]); };
    const auto visible = [&](std::size_t i) { return h.edges[i + 1] > -limit_ && h.edges[i] < limit_; };
    for (std::size_t i = 0; i < h.areas.size(); ++i)
      if (visible(i)) most = std::max(most, density(i));
    for (std::size_t i = 0; i < h.areas.size() && most > 0; ++i) {
      if (!visible(i)) continue;
      const double low = std::max(h.edges[i], -limit_), high = std::min(h.edges[i + 1], limit_);
      // A square root, so that the tails are seen beside the peak.
      const double length = deep * std::sqrt(density(i) / most);
      const auto p = bar_.at(along(low), -4 * s_ - length), q = bar_.at(along(high), -4 * s_);
      canvas.box(std::min(p.x, q.x), std::min(p.y, q.y), std::fabs(q.x - p.x), std::fabs(q.y - p.y), bars);
    }
  }
  [[nodiscard]] double along(double d) const { return (d / limit_ + 1) / 2 * bar_.length; }

  void draw_bar(Pen& canvas) const {
    draw_histogram(canvas);
    constexpr int steps = 256;
    for (int i = 0; i < steps; ++i) {
      const auto p = bar_.at(bar_.length * i / steps, 0), q = bar_.at(bar_.length * (i + 1) / steps, bar_.thickness);
      // Half a pixel over, so that no seam of paper shows.
      const double over = i + 1 < steps ? 0.6 : 0;
      canvas.box(std::min(p.x, q.x), std::min(p.y, q.y) - (bar_.upright ? over : 0),
                 std::fabs(q.x - p.x) + (bar_.upright ? 0 : over), std::fabs(q.y - p.y) + (bar_.upright ? over : 0),
                 std::fabs((2.0 * i + 1) / steps - 1) * limit_ <= c_.uncertainty.lod.value_or(-1)
                     ? noise_colour
                     : palette_((2.0 * i + 1) / steps - 1));
    }
    const auto a = bar_.at(0, 0), b = bar_.at(bar_.length, bar_.thickness);
    canvas.frame(std::min(a.x, b.x), std::min(a.y, b.y), std::fabs(b.x - a.x), std::fabs(b.y - a.y), s_, rule);
    const DifferenceStatistics& d = c_.measures.difference;
    if (d.max_above > limit_) draw_arrow(canvas, bar_.length, 20 * s_, palette_(1));
    if (d.max_below > limit_) draw_arrow(canvas, 0, -20 * s_, palette_(-1));
    draw_bar_labels(canvas);
  }
  void draw_arrow(Pen& canvas, double from, double reach, const Rgb& colour) const {
    const double gap = std::copysign(3 * s_, reach);
    const auto p = bar_.at(from + gap, 0), q = bar_.at(from + gap, bar_.thickness);
    const auto tip = bar_.at(from + gap + reach, bar_.thickness / 2);
    canvas.triangle({{{p.x, p.y}, {q.x, q.y}, {tip.x, tip.y}}}, colour);
  }

  /// The limit has two digits, its half at most three; no zeros behind them.
  [[nodiscard]] std::string bar_label(double value) const {
    const int exponent = static_cast<int>(std::floor(std::log10(limit_) + 1e-9));
    if (exponent < -4 || exponent > 6) return signed_number(value, fine, 3);
    if (options_.range > 0)
      return std::string(value > 0 ? "+" : value < 0 ? "−" : "") + fmt::format("{:.6g}", std::fabs(value));
    const bool odd = std::lround(limit_ * std::pow(10.0, 1 - exponent)) % 2 != 0;
    const int decimals = std::max(0, 1 - exponent + (odd ? 1 : 0));
    return (value > 0 ? "+" : "") + (value == 0 ? std::string("0") : fixed_number(value, decimals, fine));
  }

  void draw_bar_labels(Pen& canvas) const {
    const Pen::Font font{18 * s_, false, ink}, above{18 * s_, true, palette_(1)}, below{18 * s_, true, palette_(-1)};
    const DifferenceStatistics& d = c_.measures.difference;
    for (int k = -2; k <= 2; ++k) {
      const double value = limit_ * k / 2;
      const bool clipped = (k == 2 && d.max_above > limit_) || (k == -2 && d.max_below > limit_);
      const std::string label = (!clipped ? ""
                                 : k > 0  ? "≥\u00a0"
                                          : "≤\u00a0") +
                                bar_label(value) + (k == 0 ? "\u00a0" + measured_unit(c_, 1) : "");
      const auto p = bar_.at(along(value), bar_.thickness), q = bar_.at(along(value), bar_.thickness + 7 * s_);
      canvas.line(p.x, p.y, q.x, q.y, 1.5 * s_, rule);
      if (bar_.upright)
        canvas.text(q.x + 6 * s_, q.y + 6.5 * s_, label, font);
      else
        canvas.text(q.x, q.y + 20 * s_, label, font, TextAlign::centre);
    }
    const MapWords& words = options_.words;
    const std::string gained = words.above.empty() ? "B above A (gained)" : words.above;
    const std::string lost = words.below.empty() ? "B below A (lost)" : words.below;
    if (bar_.upright) {
      const double x = bar_.x - 100 * s_;
      canvas.text(x, bar_.y - bar_.length - 36 * s_, gained, above);
      canvas.text(x, bar_.y + 51 * s_, lost, below);
    } else {
      const double y = bar_.y + bar_.thickness / 2 + 6.5 * s_;
      canvas.text(bar_.x - 36 * s_, y, lost, below, TextAlign::right);
      canvas.text(bar_.x + bar_.length + 36 * s_, y, gained, above);
    }
  }

  /// N over an arrow, on the foot at x; the width that it takes.
  double draw_north(Pen& canvas, double x) const {
    if (!is_map(c_)) return 0;
    const double middle = x + 9 * s_, top = foot_y_ - 22 * s_, low = foot_y_ + 3 * s_, waist = foot_y_ - 4 * s_;
    canvas.triangle({{{middle, top}, {middle, waist}, {middle - 9 * s_, low}}}, ink);
    const std::array<Point2, 4> light{Point2{middle, top}, Point2{middle + 9 * s_, low}, Point2{middle, waist},
                                      Point2{middle, top}};
    canvas.path(light, 1.2 * s_, ink);
    canvas.text(middle, top - 5 * s_, "N", {16 * s_, true, ink}, TextAlign::centre);
    return 44 * s_;
  }

  /// The scale bar, on the foot at x; where it ends.
  double draw_scale_bar(Pen& canvas, double x) const {
    const Pen::Font font{18 * s_, false, ink};
    const double length = nice_below(std::max(260 * s_, 1.0) / scale_), pixels = length * scale_, thick = 8 * s_;
    for (int k = 0; k < 4; ++k)
      canvas.box(x + pixels * k / 4, foot_y_ - thick, pixels / 4, thick, k % 2 == 0 ? ink : paper);
    canvas.frame(x, foot_y_ - thick, pixels, thick, 1.2 * s_, ink);
    const std::string bar = number(length, fine, 1) + "\u00a0" + unit_text(c_.unit);
    canvas.text(x + pixels + 12 * s_, foot_y_ + 2 * s_, bar, font);
    return x + pixels + 12 * s_ + canvas.text_width(bar, font);
  }

  void draw_keys(Pen& canvas, double next) const {
    const Pen::Font soft{16 * s_, false, faint};
    const auto key = [&](const Rgb& colour, bool hatched, const std::string& words) {
      canvas.box(next, key_y_ - 13 * s_, 26 * s_, 15 * s_, colour);
      for (int k = 0; k < 2 && hatched; ++k)
        canvas.line(next + (1 + 11 * k) * s_, key_y_ + s_, next + (14 + 11 * k) * s_, key_y_ - 12 * s_, 1.8 * s_,
                    hatch);
      canvas.frame(next, key_y_ - 13 * s_, 26 * s_, 15 * s_, s_, rule);
      canvas.text(next + 36 * s_, key_y_, canvas.fitted(words, soft, options_.width - 44 * s_ - next - 36 * s_), soft);
      next += 36 * s_ + canvas.text_width(words, soft) + 40 * s_;
    };
    const MapWords& words = options_.words;
    if (c_.uncertainty.lod)
      key(noise_colour, false, "within the level of detection, ±" + with_unit(number(*c_.uncertainty.lod, fine), 1));
    else
      key(palette_(0), false, words.zero.empty() ? "no difference" : words.zero);
    if (has_footprint_) key(footprint, true, !words.left_out.empty() ? words.left_out : left_out_words());
  }

  [[nodiscard]] std::string reach_words() const {
    const DifferenceStatistics& d = c_.measures.difference;
    if (options_.range > 0) {
      std::string beyond;
      if (d.max_below > limit_) beyond = "to −" + with_unit(number(d.max_below, fine, 2), 1);
      if (d.max_above > limit_)
        beyond += (beyond.empty() ? "to +" : " and +") + with_unit(number(d.max_above, fine, 2), 1);
      return "colours end at ±" + with_unit(number(limit_, fine, 3), 1) + ", as asked" +
             (beyond.empty() ? "" : ", differences reach " + beyond) + "; ";
    }
    return shows_no_difference(c_)      ? ""
           : is_paired_                 ? "colours as on the map beside it; "
           : limit_ > natural_limit(c_) ? "colours reach to twice the level of detection; "
           : limit_ < largest(d)        ? "colours reach to the 99th percentile of |d|; "
                                        : "colours reach to the largest |d|; ";
  }

  /// Of what was compared.
  [[nodiscard]] std::string frame_words() const {
    if (!options_.extent) return "";
    const Box2 domain = node_box(c_.cells, true);
    const bool whole = domain.empty() || (box_.min.x <= domain.min.x && box_.min.y <= domain.min.y &&
                                          box_.max.x >= domain.max.x && box_.max.y >= domain.max.y);
    return whole ? "" : "the frame leaves out part of what was compared; ";
  }

  [[nodiscard]] std::vector<std::string> note_in_lines(Pen& pen) const {
    const MapWords& words = options_.words;
    const std::string note = (words.note.empty() ? std::string(sign_rule) : words.note) + "; " + reach_words() +
                             frame_words() + "histogram: area, square-root scale; " + "shading: surface" +
                             (words.note.empty() ? " A" : "") + ", heights ×\u00a0" + number(exaggeration_, fine, 2);
    return pen.wrapped(note, {16 * s_, false, faint}, options_.width - 88 * s_);
  }

  void draw_foot(Pen& canvas) const {
    const Pen::Font soft{16 * s_, false, faint};
    const double x = 44 * s_, bar_end = draw_scale_bar(canvas, x + draw_north(canvas, x));
    draw_keys(canvas, bare_ ? x : bar_end + 44 * s_);
    const std::vector<std::string> note = note_in_lines(canvas);
    for (std::size_t k = 0; k < std::min(note.size(), note_lines_); ++k)
      canvas.text(x, key_y_ + (38 + 24 * static_cast<double>(k)) * s_, note[k], soft);
    if (!bare_ && !signature_.empty())
      canvas.text(x, signature_y_, canvas.fitted(signature_, soft, options_.width - 2 * x), soft);
  }

  const Comparison& c_;
  const MapOptions& options_;
  bool is_paired_, bare_;
  double s_, limit_;
  Palette palette_;
  Box2 box_;
  std::string signature_;
  bool upright_ = true, has_footprint_ = false;
  double scale_ = 1, exaggeration_ = 1, foot_y_ = 0, key_y_ = 0, signature_y_ = 0;
  std::size_t note_lines_ = 1;
  int columns_ = 1, rows_ = 1, panel_x_ = 0, panel_y_ = 0, height_ = 1;
  BarPlace bar_{};
};

MapDrawing::MapDrawing(const Comparison& c, const MapOptions& options, const MapScale& scale)
    : map_(std::make_unique<Map>(c, options, scale)) {}
MapDrawing::~MapDrawing() = default;
int MapDrawing::height() const { return map_->height(); }
void MapDrawing::draw(Pen& pen) { map_->draw(pen); }

bool shows_no_difference(const Comparison& c) {
  const DifferenceStatistics& d = c.measures.difference;
  double size = 0;
  for (const Box3* b : {&c.a.bounds, &c.b.bounds})
    if (!b->empty()) size = std::max({size, b->max.x - b->min.x, b->max.y - b->min.y, b->max.z - b->min.z});
  return !(std::max(d.max_above, d.max_below) > 1e-13 * size);
}

double colour_limit(const Comparison& c) {
  if (shows_no_difference(c)) return 1;
  const double limit = natural_limit(c), lod = c.uncertainty.lod.value_or(0);
  return limit < least_over_noise * lod ? round_up_2_digits(2 * lod) : limit;
}

double colour_limit(const Comparison& c, const MapOptions& look) {
  return look.range > 0 ? look.range : colour_limit(c);
}

std::array<MapScale, 2> paired_scales(const std::optional<Comparison>& before, const std::optional<Comparison>& after) {
  std::array<MapScale, 2> scales;
  if (!before || !after) return scales;
  const double limit = std::max(shows_no_difference(*before) ? 0 : colour_limit(*before),
                                shows_no_difference(*after) ? 0 : colour_limit(*after));
  scales[0].colour_limit = scales[1].colour_limit = limit;
  const Frame &f = before->frame, &g = after->frame;
  if (f.rotation != g.rotation) return scales;
  const Point3 d = f.to_field(g.origin);  // of the second origin in the first frame
  Box2 box = shown_box(after->cells);
  box.min = {box.min.x + d.x, box.min.y + d.y}, box.max = {box.max.x + d.x, box.max.y + d.y};
  box.add(shown_box(before->cells));
  scales[0].box = box;
  scales[1].box = Box2{{box.min.x - d.x, box.min.y - d.y}, {box.max.x - d.x, box.max.y - d.y}};
  return scales;
}

std::string where_compared(const Comparison& c) {
  return number(c.domain_area, fine) + "\u00a0" + measured_unit(c, 2) + " compared, " +
         fixed_number(100 * c.coverage, 1, fine) + " % of the area of both scans" +
         (c.unit == "unknown" ? "   ·   units unknown (as in the files)" : "");
}

namespace {

void check_width(int width) {
  if (width < 300 || width > 20000)
    throw UsageError("map width " + std::to_string(width) + ": must be between 300 and 20000 pixels");
}

std::string map_svg(const Comparison& c, const MapOptions& options) {
  MapOptions look = options;
  look.width = std::min(options.width, widest_svg);
  MapDrawing drawing(c, look, {});
  SvgPen pen(look.width, drawing.height(), paper,
             look.title.empty() ? input_name(c.a) + " → " + input_name(c.b) : look.title);
  drawing.draw(pen);
  return pen.svg();
}

}  // namespace

Image render_map(const Comparison& c, const MapOptions& options, const Context& context, const MapScale& scale) {
  check_width(options.width);
  context.check();
  MapDrawing drawing(c, options, scale);
  Canvas canvas(options.width, drawing.height(), paper);
  drawing.draw(canvas);
  return canvas.image();
}

void write_map(const std::string& path, const Comparison& c, const MapOptions& options, const Context& context) {
  if (!path.ends_with(".svg")) return write_png(path, render_map(c, options, context));
  check_width(options.width);
  context.check();
  write_text_atomically(path, map_svg(c, options));
}

}  // namespace isopach
