// What a Canvas draws on. Internal to draw/: the header needs cairo.
#pragma once
#include <cairo.h>

#include "isopach/report/draw/canvas.hpp"

namespace isopach {

/// Throws what a status of cairo means; nothing for success.
void check_cairo(cairo_status_t status, const char* what);

struct Canvas::Cairo {
  std::string bytes;  ///< of a file that the surface writes into; before it, which writes until it is no more
  cairo_surface_t* surface;
  cairo_t* context;

  /// Takes the surface.
  explicit Cairo(cairo_surface_t* on) : surface(on), context(cairo_create(on)) {}
  /// Pages of a PDF, lengths in points; pdf.cpp.
  Cairo(double width, double height);
  ~Cairo() {
    cairo_destroy(context);
    cairo_surface_destroy(surface);
  }
  Cairo(const Cairo&) = delete;
  Cairo& operator=(const Cairo&) = delete;

  void colour(const Rgb& c) const { cairo_set_source_rgb(context, c.r, c.g, c.b); }
  void font(const Font& f) const {
    cairo_select_font_face(context, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                           f.bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(context, f.size);
    colour(f.colour);
  }
};

}  // namespace isopach
