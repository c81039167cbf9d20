// PdfSheets: a Pen that writes the pages of a PDF, by cairo: text is text, in the font that is embedded. Lengths in
// points, from the upper left corner of an A4 page.
#pragma once
#include <string>

#include "isopach/report/draw/canvas.hpp"

namespace isopach {

class PdfSheets : public Canvas {
 public:
  static constexpr double width = 595.28, height = 841.89;  ///< A4

  /// What the file says of itself. `date`: YYYY-MM-DD, of its making; empty: 1970-01-01, so that the same sheets are
  /// the same bytes.
  struct About {
    std::string title, author, date;
  };
  explicit PdfSheets(const About& about);

  void next_page();
  /// A drawing in a unit of its own, `scale` points: text and lines of a map, say. Until end_part().
  void begin_part(double x, double y, double scale);
  void end_part();

  /// Ends the last page: the file. Once.
  [[nodiscard]] std::string finish();
};

}  // namespace isopach
