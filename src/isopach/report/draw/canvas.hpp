// Canvas: a Pen that draws pixels, on cairo, without a display; pictures as PNG.
#pragma once
#include <memory>
#include <string>
#include <utility>

#include "isopach/report/draw/pen.hpp"

namespace isopach {

/// Writes a PNG (libpng), whole or not at all. Errors: InputError naming the path.
void write_png(const std::string& path, const Image& image);

/// The same bytes, well compressed: for pictures within other files.
[[nodiscard]] std::string png_of(const Image& image);

class Canvas : public Pen {
 public:
  Canvas(int width, int height, const Rgb& background);

  void text(double x, double y, const std::string& text, const Font& font, TextAlign align = TextAlign::left) override;
  void text_upwards(double x, double y, const std::string& text, const Font& font,
                    TextAlign align = TextAlign::left) override;
  [[nodiscard]] double text_width(const std::string& text, const Font& font) override;
  void line(double x0, double y0, double x1, double y1, double width, const Rgb& colour) override;
  void path(std::span<const Point2> corners, double width, const Rgb& colour) override;
  void box(double x, double y, double width, double height, const Rgb& fill) override;
  void frame(double x, double y, double width, double height, double line_width, const Rgb& colour) override;
  void triangle(const std::array<Point2, 3>& corners, const Rgb& fill) override;
  void picture(double x, double y, const Image& image, double scale = 1) override;
  void clip(double x, double y, double width, double height) override;
  void unclip() override;

  [[nodiscard]] Image image() const;

 protected:
  struct Cairo;
  explicit Canvas(std::shared_ptr<Cairo> cairo) : cairo_(std::move(cairo)) {}
  std::shared_ptr<Cairo> cairo_;
};

}  // namespace isopach
