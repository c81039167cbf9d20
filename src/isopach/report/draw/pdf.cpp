#include "isopach/report/draw/pdf.hpp"

#include <new>

#include <cairo-pdf.h>

#include "isopach/report/draw/cairo_canvas.hpp"
#include "isopach/report/page/words.hpp"

namespace isopach {
namespace {

cairo_status_t append(void* closure, const unsigned char* data, unsigned length) {
  try {
    static_cast<std::string*>(closure)->append(reinterpret_cast<const char*>(data), length);
  } catch (const std::bad_alloc&) {
    return CAIRO_STATUS_NO_MEMORY;
  }
  return CAIRO_STATUS_SUCCESS;
}

}  // namespace

Canvas::Cairo::Cairo(double width, double height)
    : surface(cairo_pdf_surface_create_for_stream(append, &bytes, width, height)), context(cairo_create(surface)) {}

PdfSheets::PdfSheets(const About& about) : Canvas(std::make_shared<Cairo>(width, height)) {
  check_cairo(cairo_status(cairo_->context), "report.pdf");
  cairo_pdf_surface_restrict_to_version(cairo_->surface, CAIRO_PDF_VERSION_1_4);
  const auto say = [&](cairo_pdf_metadata_t what, const std::string& text) {
    if (!text.empty()) cairo_pdf_surface_set_metadata(cairo_->surface, what, clean_utf8(text).c_str());
  };
  say(CAIRO_PDF_METADATA_TITLE, about.title);
  say(CAIRO_PDF_METADATA_AUTHOR, about.author);
  say(CAIRO_PDF_METADATA_CREATOR, std::string(tool_name));
  say(CAIRO_PDF_METADATA_CREATE_DATE, (about.date.empty() ? "1970-01-01" : about.date) + "T00:00:00Z");
}

void PdfSheets::next_page() { cairo_show_page(cairo_->context); }

void PdfSheets::begin_part(double x, double y, double scale) {
  cairo_save(cairo_->context);
  cairo_translate(cairo_->context, x, y);
  cairo_scale(cairo_->context, scale, scale);
}

void PdfSheets::end_part() { cairo_restore(cairo_->context); }

std::string PdfSheets::finish() {
  cairo_show_page(cairo_->context);
  check_cairo(cairo_status(cairo_->context), "report.pdf");
  cairo_surface_finish(cairo_->surface);
  check_cairo(cairo_surface_status(cairo_->surface), "report.pdf");
  return cairo_->bytes;
}

}  // namespace isopach
