// SvgPen: a Pen that writes SVG. Text stays text, in DejaVu Sans where it is there, so that it can be read, found and
// changed; its widths are those of that font. No script, no reference to anything outside of the file.
#pragma once
#include <string>

#include "isopach/report/draw/canvas.hpp"

namespace isopach {

class SvgPen : public Pen {
 public:
  SvgPen(int width, int height, const Rgb& background, const std::string& title);

  void text(double x, double y, const std::string& text, const Font& font, TextAlign align = TextAlign::left) override;
  void text_upwards(double x, double y, const std::string& text, const Font& font,
                    TextAlign align = TextAlign::left) override;
  [[nodiscard]] double text_width(const std::string& text, const Font& font) override;
  void line(double x0, double y0, double x1, double y1, double width, const Rgb& colour) override;
  /// Corners that lie within a twentieth of a pixel of the one before are left out.
  void path(std::span<const Point2> corners, double width, const Rgb& colour) override;
  void box(double x, double y, double width, double height, const Rgb& fill) override;
  void frame(double x, double y, double width, double height, double line_width, const Rgb& colour) override;
  void triangle(const std::array<Point2, 3>& corners, const Rgb& fill) override;
  /// As PNG within the file.
  void picture(double x, double y, const Image& image, double scale = 1) override;
  void clip(double x, double y, double width, double height) override;
  void unclip() override;

  /// The file.
  [[nodiscard]] std::string svg() const { return out_ + "</svg>\n"; }

 private:
  Canvas ruler_;
  std::string out_;
  int clips_ = 0;
};

}  // namespace isopach
