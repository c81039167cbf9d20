// Canvas: the little drawing a map needs (text, lines, boxes, a picture), on cairo, without a display; written as PNG.
#pragma once
#include <array>
#include <memory>
#include <string>

#include "isopach/base/array.hpp"
#include "isopach/geom/vec.hpp"
#include "isopach/report/draw/palette.hpp"

namespace isopach {

/// 8-bit sRGB, row by row from the top.
struct Image {
  int width = 0, height = 0;
  Array<unsigned char> rgb;  ///< 3 × width × height
};

/// Writes a PNG (libpng), whole or not at all. Errors: InputError naming the path.
void write_png(const std::string& path, const Image& image);

enum class TextAlign { left, centre, right };

class Canvas {
 public:
  Canvas(int width, int height, const Rgb& background);

  struct Font {
    double size;  ///< pixels
    bool bold = false;
    Rgb colour{0.13, 0.14, 0.16};
  };
  /// `y` is the baseline. Invalid UTF-8 is replaced.
  void text(double x, double y, const std::string& text, const Font& font, TextAlign align = TextAlign::left);
  void text_upwards(double x, double y, const std::string& text, const Font& font, TextAlign align = TextAlign::left);
  [[nodiscard]] double text_width(const std::string& text, const Font& font);
  /// The text, cut in the middle with "…" where it is wider than `width`.
  [[nodiscard]] std::string fitted(const std::string& text, const Font& font, double width);

  void line(double x0, double y0, double x1, double y1, double width, const Rgb& colour);
  void box(double x, double y, double width, double height, const Rgb& fill);
  void frame(double x, double y, double width, double height, double line_width, const Rgb& colour);
  void triangle(const std::array<Point2, 3>& corners, const Rgb& fill);
  void picture(int x, int y, const Image& image);

  [[nodiscard]] Image image() const;

 private:
  struct Cairo;
  std::shared_ptr<Cairo> cairo_;
};

}  // namespace isopach
