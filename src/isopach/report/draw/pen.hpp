// Pen: the little drawing that maps and sheets need (text, lines, boxes, a picture), whatever it is drawn on: pixels
// (canvas.hpp), SVG (svg.hpp), PDF (pdf.hpp).
#pragma once
#include <array>
#include <span>
#include <string>
#include <vector>

#include "isopach/base/array.hpp"
#include "isopach/geom/vec.hpp"
#include "isopach/report/draw/palette.hpp"

namespace isopach {

/// 8-bit sRGB, row by row from the top.
struct Image {
  int width = 0, height = 0;
  Array<unsigned char> rgb;  ///< 3 × width × height
};

enum class TextAlign { left, centre, right };

class Pen {
 public:
  virtual ~Pen() = default;

  struct Font {
    double size;  ///< in the unit of the drawing: pixels, points
    bool bold = false;
    Rgb colour{0.13, 0.14, 0.16};
  };
  /// `y` is the baseline. Invalid UTF-8 is replaced.
  virtual void text(double x, double y, const std::string& text, const Font& font,
                    TextAlign align = TextAlign::left) = 0;
  virtual void text_upwards(double x, double y, const std::string& text, const Font& font,
                            TextAlign align = TextAlign::left) = 0;
  [[nodiscard]] virtual double text_width(const std::string& text, const Font& font) = 0;
  /// The text, cut in the middle with "…" where it is wider than `width`.
  [[nodiscard]] std::string fitted(const std::string& text, const Font& font, double width);
  /// In lines of whole words, no wider than `width` where words allow it.
  [[nodiscard]] std::vector<std::string> wrapped(const std::string& text, const Font& font, double width);

  virtual void line(double x0, double y0, double x1, double y1, double width, const Rgb& colour) = 0;
  virtual void path(std::span<const Point2> corners, double width, const Rgb& colour) = 0;
  virtual void box(double x, double y, double width, double height, const Rgb& fill) = 0;
  virtual void frame(double x, double y, double width, double height, double line_width, const Rgb& colour) = 0;
  virtual void triangle(const std::array<Point2, 3>& corners, const Rgb& fill) = 0;
  /// `scale`: units of the drawing that a pixel of the image takes.
  virtual void picture(double x, double y, const Image& image, double scale = 1) = 0;
  /// Until unclip() nothing is drawn outside of this box.
  virtual void clip(double x, double y, double width, double height) = 0;
  virtual void unclip() = 0;
};

}  // namespace isopach
