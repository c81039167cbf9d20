#include "isopach/report/draw/svg.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "isopach/report/page/base64.hpp"
#include "isopach/report/page/page.hpp"

namespace isopach {
namespace {

std::string hex(const Rgb& colour) {
  const auto byte = [](double v) { return static_cast<int>(std::lround(255 * std::clamp(v, 0.0, 1.0))); };
  return fmt::format("#{:02x}{:02x}{:02x}", byte(colour.r), byte(colour.g), byte(colour.b));
}

/// To a hundredth, without zeros behind it.
std::string length(double v) {
  std::string text = fmt::format("{:.2f}", v);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

std::string words(const std::string& text, const Pen::Font& font, TextAlign align, const std::string& place) {
  const char* const anchor = align == TextAlign::left     ? ""
                             : align == TextAlign::centre ? " text-anchor=\"middle\""
                                                          : " text-anchor=\"end\"";
  return fmt::format("<text {} font-size=\"{}\"{}{} fill=\"{}\">{}</text>\n", place, length(font.size),
                     font.bold ? " font-weight=\"bold\"" : "", anchor, hex(font.colour), escaped(text));
}

}  // namespace

SvgPen::SvgPen(int width, int height, const Rgb& background, const std::string& title) : ruler_(8, 8, background) {
  out_ = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
      "font-family=\"'DejaVu Sans',Verdana,sans-serif\" style=\"white-space:pre\" role=\"img\">\n<title>{2}</title>\n",
      width, height, escaped(title));
  box(0, 0, width, height, background);
}

double SvgPen::text_width(const std::string& text, const Font& font) { return ruler_.text_width(text, font); }

void SvgPen::text(double x, double y, const std::string& text, const Font& font, TextAlign align) {
  out_ += words(text, font, align, fmt::format("x=\"{}\" y=\"{}\"", length(x), length(y)));
}

void SvgPen::text_upwards(double x, double y, const std::string& text, const Font& font, TextAlign align) {
  out_ += words(text, font, align, fmt::format("transform=\"translate({} {}) rotate(-90)\"", length(x), length(y)));
}

void SvgPen::line(double x0, double y0, double x1, double y1, double width, const Rgb& colour) {
  const std::array<Point2, 2> ends{Point2{x0, y0}, Point2{x1, y1}};
  path(ends, width, colour);
}

void SvgPen::path(std::span<const Point2> corners, double width, const Rgb& colour) {
  if (corners.size() < 2) return;
  std::string d;
  Point2 last{};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Point2& p = corners[i];
    if (i > 0 && i + 1 < corners.size() && std::hypot(p.x - last.x, p.y - last.y) < 0.05) continue;
    d += (i == 0 ? "M" : "L") + length(p.x) + " " + length(p.y);
    last = p;
  }
  out_ += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"/>\n", d,
                      hex(colour), length(width));
}

void SvgPen::box(double x, double y, double width, double height, const Rgb& fill) {
  out_ += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{}\"/>\n", length(x), length(y),
                      length(width), length(height), hex(fill));
}

void SvgPen::frame(double x, double y, double width, double height, double line_width, const Rgb& colour) {
  out_ += fmt::format(
      "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"/>\n",
      length(x), length(y), length(width), length(height), hex(colour), length(line_width));
}

void SvgPen::triangle(const std::array<Point2, 3>& corners, const Rgb& fill) {
  out_ +=
      fmt::format("<path d=\"M{} {}L{} {}L{} {}Z\" fill=\"{}\"/>\n", length(corners[0].x), length(corners[0].y),
                  length(corners[1].x), length(corners[1].y), length(corners[2].x), length(corners[2].y), hex(fill));
}

void SvgPen::picture(double x, double y, const Image& image, double scale) {
  out_ += fmt::format(
      "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\" "
      "href=\"data:image/png;base64,{}\"/>\n",
      length(x), length(y), length(image.width * scale), length(image.height * scale), base64(png_of(image)));
}

void SvgPen::clip(double x, double y, double width, double height) {
  out_ += fmt::format(
      "<clipPath id=\"clip{0}\"><rect x=\"{1}\" y=\"{2}\" width=\"{3}\" height=\"{4}\"/></clipPath>\n"
      "<g clip-path=\"url(#clip{0})\">\n",
      ++clips_, length(x), length(y), length(width), length(height));
}

void SvgPen::unclip() { out_ += "</g>\n"; }

}  // namespace isopach
