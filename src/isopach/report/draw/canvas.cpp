#include "isopach/report/draw/canvas.hpp"

#include <cstring>
#include <new>

#include <png.h>

#include "isopach/base/error.hpp"
#include "isopach/io/output_file.hpp"
#include "isopach/io/write.hpp"
#include "isopach/report/draw/cairo_canvas.hpp"
#include "isopach/report/page/words.hpp"

namespace isopach {

void check_cairo(cairo_status_t status, const char* what) {
  if (status == CAIRO_STATUS_NO_MEMORY) throw std::bad_alloc();
  if (status != CAIRO_STATUS_SUCCESS)
    throw Error(ExitCode::internal, std::string(what) + ": cairo: " + cairo_status_to_string(status) +
                                        ": a library or font is broken, or memory is short");
}

Canvas::Canvas(int width, int height, const Rgb& background)
    : cairo_(std::make_shared<Cairo>(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height))) {
  check_cairo(cairo_status(cairo_->context), "map");
  cairo_->colour(background);
  cairo_paint(cairo_->context);
}

double Canvas::text_width(const std::string& text, const Font& font) {
  cairo_->font(font);
  cairo_text_extents_t extents;
  cairo_text_extents(cairo_->context, clean_utf8(text).c_str(), &extents);
  return extents.x_advance;
}

void Canvas::text(double x, double y, const std::string& text, const Font& font, TextAlign align) {
  const double width = align == TextAlign::left ? 0 : text_width(text, font);
  cairo_->font(font);
  cairo_move_to(cairo_->context,
                x - (align == TextAlign::right    ? width
                     : align == TextAlign::centre ? width / 2
                                                  : 0),
                y);
  cairo_show_text(cairo_->context, clean_utf8(text).c_str());
}

void Canvas::text_upwards(double x, double y, const std::string& words, const Font& font, TextAlign align) {
  cairo_save(cairo_->context);
  cairo_translate(cairo_->context, x, y);
  cairo_rotate(cairo_->context, -1.5707963267948966);
  text(0, 0, words, font, align);
  cairo_restore(cairo_->context);
}

void Canvas::line(double x0, double y0, double x1, double y1, double width, const Rgb& colour) {
  cairo_->colour(colour);
  cairo_set_line_width(cairo_->context, width);
  cairo_move_to(cairo_->context, x0, y0);
  cairo_line_to(cairo_->context, x1, y1);
  cairo_stroke(cairo_->context);
}

void Canvas::path(std::span<const Point2> corners, double width, const Rgb& colour) {
  if (corners.size() < 2) return;
  cairo_->colour(colour);
  cairo_set_line_width(cairo_->context, width);
  cairo_set_line_join(cairo_->context, CAIRO_LINE_JOIN_ROUND);
  cairo_move_to(cairo_->context, corners[0].x, corners[0].y);
  for (const Point2& p : corners.subspan(1)) cairo_line_to(cairo_->context, p.x, p.y);
  cairo_stroke(cairo_->context);
  cairo_set_line_join(cairo_->context, CAIRO_LINE_JOIN_MITER);
}

void Canvas::clip(double x, double y, double width, double height) {
  cairo_save(cairo_->context);
  cairo_rectangle(cairo_->context, x, y, width, height);
  cairo_clip(cairo_->context);
}

void Canvas::unclip() { cairo_restore(cairo_->context); }

void Canvas::box(double x, double y, double width, double height, const Rgb& fill) {
  cairo_->colour(fill);
  cairo_rectangle(cairo_->context, x, y, width, height);
  cairo_fill(cairo_->context);
}

void Canvas::frame(double x, double y, double width, double height, double line_width, const Rgb& colour) {
  cairo_->colour(colour);
  cairo_set_line_width(cairo_->context, line_width);
  cairo_rectangle(cairo_->context, x, y, width, height);
  cairo_stroke(cairo_->context);
}

void Canvas::triangle(const std::array<Point2, 3>& corners, const Rgb& fill) {
  cairo_->colour(fill);
  for (std::size_t k = 0; k < 3; ++k)
    (k == 0 ? cairo_move_to : cairo_line_to)(cairo_->context, corners[k].x, corners[k].y);
  cairo_close_path(cairo_->context);
  cairo_fill(cairo_->context);
}

void Canvas::picture(double x, double y, const Image& image, double scale) {
  cairo_surface_t* source = cairo_image_surface_create(CAIRO_FORMAT_RGB24, image.width, image.height);
  check_cairo(cairo_surface_status(source), "map");
  cairo_surface_flush(source);
  unsigned char* data = cairo_image_surface_get_data(source);
  const int stride = cairo_image_surface_get_stride(source);
  for (int row = 0; row < image.height; ++row)
    for (int column = 0; column < image.width; ++column) {
      const std::size_t at = 3 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width) +
                                  static_cast<std::size_t>(column));
      const std::uint32_t pixel = static_cast<std::uint32_t>(image.rgb[at]) << 16 |
                                  static_cast<std::uint32_t>(image.rgb[at + 1]) << 8 | image.rgb[at + 2];
      std::memcpy(data + static_cast<std::ptrdiff_t>(row) * stride + 4 * column, &pixel, 4);
    }
  cairo_surface_mark_dirty(source);
  cairo_save(cairo_->context);
  cairo_translate(cairo_->context, x, y);
  if (scale != 1) cairo_scale(cairo_->context, scale, scale);
  cairo_set_source_surface(cairo_->context, source, 0, 0);
  cairo_paint(cairo_->context);
  cairo_restore(cairo_->context);
  cairo_surface_destroy(source);
}

Image Canvas::image() const {
  check_cairo(cairo_status(cairo_->context),
              "map");  // after its first failure a context draws nothing more, and says so only here
  cairo_surface_flush(cairo_->surface);
  Image out;
  out.width = cairo_image_surface_get_width(cairo_->surface);
  out.height = cairo_image_surface_get_height(cairo_->surface);
  out.rgb.resize(3 * static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height));
  const unsigned char* data = cairo_image_surface_get_data(cairo_->surface);
  const int stride = cairo_image_surface_get_stride(cairo_->surface);
  std::size_t at = 0;
  for (int row = 0; row < out.height; ++row)
    for (int column = 0; column < out.width; ++column) {
      std::uint32_t pixel;
      std::memcpy(&pixel, data + static_cast<std::ptrdiff_t>(row) * stride + 4 * column, 4);
      out.rgb[at++] = static_cast<unsigned char>(pixel >> 16 & 0xFF);
      out.rgb[at++] = static_cast<unsigned char>(pixel >> 8 & 0xFF);
      out.rgb[at++] = static_cast<unsigned char>(pixel & 0xFF);
    }
  return out;
}

void write_png(const std::string& path, const Image& image) {
  write_atomically(path, [&](const std::string& temporary) {
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = static_cast<png_uint_32>(image.width);
    png.height = static_cast<png_uint_32>(image.height);
    png.format = PNG_FORMAT_RGB;
    png.flags = PNG_IMAGE_FLAG_FAST;
    if (png_image_write_to_file(&png, temporary.c_str(), 0, image.rgb.data(), 0, nullptr) == 0)
      fail_to_write(path, png.message);
  });
}

std::string png_of(const Image& image) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&png, bytes.data(), &size, 0, image.rgb.data(), 0, nullptr) == 0)
    throw Error(ExitCode::internal, std::string("picture: libpng: ") + png.message);
  bytes.resize(size);
  return bytes;
}

}  // namespace isopach
