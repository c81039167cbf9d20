// The short report as PDF, on two sheets.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "isopach/io/output_file.hpp"
#include "isopach/report/draw/map.hpp"
#include "isopach/report/draw/pdf.hpp"
#include "isopach/report/page/words.hpp"
#include "isopach/report/short_report.hpp"

namespace isopach {
namespace {

constexpr Rgb ink{0.13, 0.14, 0.16}, faint{0.36, 0.38, 0.42}, rule{0.80, 0.81, 0.83}, tint{1.0, 0.957, 0.84};
constexpr double margin = 48, room = PdfSheets::width - 2 * margin, lowest = PdfSheets::height - 58;
constexpr int map_pixels = 2000;
constexpr double map_words = 1.3;  // of the map's own words, which are meant for a screen
constexpr Pen::Font title{17, true, ink}, heading{11, true, ink}, strong{11, false, ink}, body{8.8, false, ink},
    bold{8.8, true, ink}, soft{8, false, faint};

class Sheets {
 public:
  Sheets(const ShortReport& r, const Comparison& c, const MapOptions& look)
      : r_(r), c_(c), look_(look), pen_({r.title, clean_utf8(look.author), look.date}) {}

  std::string write(bool with_map) {
    head();
    if (with_map) map();
    foot(1);
    pen_.next_page();
    y_ = margin + 8;
    numbers();
    warnings();
    meaning();
    for (const ShortTable& t : r_.tables) table(t);
    foot(2);
    return pen_.finish();
  }

 private:
  void paragraph(const std::string& text, const Pen::Font& font, double width = room) {
    for (const std::string& line : pen_.wrapped(text, font, width)) {
      if (y_ > lowest) return;
      pen_.text(margin, y_, line, font);
      y_ += 1.38 * font.size;
    }
  }
  void headed(const std::string& text) {
    y_ += 10;
    paragraph(text, heading);
    y_ += 2;
  }
  void line_across() { pen_.line(margin, y_ - 8.4, margin + room, y_ - 8.4, 0.5, rule); }

  void head() {
    y_ = margin + 10;
    double width = room;
    if (look_.logo.image != nullptr) {
      const Image& logo = *look_.logo.image;
      const double scale = std::min(120.0 / logo.width, 44.0 / logo.height);
      pen_.picture(margin + room - logo.width * scale, margin - 12, logo, scale);
      width -= logo.width * scale + 16;
    }
    const std::vector<std::string> lines = pen_.wrapped(r_.title, title, width);
    for (std::size_t k = 0; k < std::min<std::size_t>(2, lines.size()); ++k, y_ += 21)
      pen_.text(margin, y_, lines[k], title);
    paragraph(r_.scans, soft, width);
    if (!r_.signature.empty()) paragraph(r_.signature, soft);
    y_ += 10;
    for (std::size_t k = 0; k < r_.lead.size(); ++k) {
      paragraph(r_.lead[k], k == 0 ? strong : body);
      y_ += 3;
    }
  }

  void map() {
    MapOptions look = look_;
    look.width = map_pixels;
    MapDrawing drawing(c_, look, {0, {}, map_words, true});
    const double scale = std::min(room / map_pixels, (lowest - y_) / drawing.height());
    pen_.begin_part(margin + (room - scale * map_pixels) / 2, y_, scale);
    drawing.draw(pen_);
    pen_.end_part();
  }

  void numbers() {
    paragraph("The numbers", heading);
    y_ += 4;
    for (const ShortRow& r : r_.numbers) {
      if (y_ > lowest) return;
      pen_.text(margin, y_, r.name, bold);
      pen_.text(margin + 190, y_, r.number, body, TextAlign::right);
      pen_.text(margin + 256, y_, r.plus_minus, body, TextAlign::right);
      pen_.text(margin + 262, y_, r.unit, soft);
      pen_.text(margin + 300, y_, pen_.fitted(r.why, soft, room - 300), soft);
      y_ += 13.4;
      pen_.line(margin, y_ - 9.6, margin + room, y_ - 9.6, 0.4, rule);
    }
  }

  void warnings() {
    if (r_.cautions.empty()) return;
    y_ += 8;
    std::vector<std::string> lines{};
    for (const std::string& w : r_.cautions) {
      std::vector<std::string> of = pen_.wrapped("• " + w, soft, room - 16);
      if (of.size() > 4) of.resize(4), of.back() += " …";
      lines.insert(lines.end(), of.begin(), of.end());
    }
    if (r_.more_cautions > 0) lines.push_back(fmt::format("and {} more in result.json", r_.more_cautions));
    const double height = 24 + 11 * static_cast<double>(lines.size());
    pen_.box(margin, y_ - 4, room, height, tint);
    pen_.text(margin + 8, y_ + 9, "Before you rely on the numbers", bold);
    for (std::size_t k = 0; k < lines.size(); ++k)
      pen_.text(margin + 8, y_ + 22 + 11 * static_cast<double>(k), lines[k], {8, false, ink});
    y_ += height + 6;
  }

  void meaning() {
    headed("How sure they are");
    for (const std::string& sentence : r_.meaning) {
      paragraph(sentence, body);
      y_ += 2;
    }
  }

  /// The first column on the left, the others to the right of equal columns.
  void table(const ShortTable& t) {
    if (y_ + 60 > lowest) return;
    headed(t.title);
    const double first = t.columns.front() == "no." ? 26 : 120;
    const double step = (room - first) / static_cast<double>(t.columns.size() - 1);
    const auto row = [&](const std::vector<std::string>& cells, const Pen::Font& of_first, const Pen::Font& font) {
      pen_.text(margin, y_, pen_.fitted(cells[0], of_first, first), of_first);
      for (std::size_t k = 1; k < cells.size(); ++k)
        pen_.text(margin + first + step * static_cast<double>(k), y_, cells[k], font, TextAlign::right);
      y_ += 12.6;
      line_across();
    };
    row(t.columns, soft, soft);
    std::size_t shown = 0;
    for (; shown < t.rows.size() && y_ + 14 < lowest; ++shown) row(t.rows[shown], bold, body);
    const std::size_t left_out = t.left_out + t.rows.size() - shown;
    if (left_out > 0) paragraph(fmt::format("And {} more in {}.", count(left_out, Typography::fine), t.file), soft);
  }

  void foot(int page) {
    const double y = PdfSheets::height - 34;
    pen_.line(margin, y - 12, margin + room, y - 12, 0.5, rule);
    pen_.text(margin, y, pen_.fitted(r_.foot, soft, room - 60), soft);
    pen_.text(margin + room, y, fmt::format("{} of 2", page), soft, TextAlign::right);
  }

  const ShortReport& r_;
  const Comparison& c_;
  const MapOptions& look_;
  PdfSheets pen_;
  double y_ = 0;
};

}  // namespace

void write_pdf(const std::string& path, const Comparison& c, const MapOptions& look, const Matching* matched,
               bool with_map, const Context& context) {
  context.check();
  ShortReport r = short_report(c, look, matched);
  if (with_map) say_how_drawn(r, look);
  write_text_atomically(path, Sheets(r, c, look).write(with_map));
}

}  // namespace isopach
