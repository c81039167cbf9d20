// The short report: what a client reads, on two pages: map, numbers with what they are worth, largest changes. As HTML
// (report.html) and as PDF, of the same words.
#pragma once
#include <string>
#include <vector>

#include "isopach/report/report.hpp"

namespace isopach {

/// A number of the result as people read it.
struct ShortRow {
  std::string key;  ///< in result.json
  std::string name, number, plus_minus, unit, why;
};

struct ShortTable {
  std::string title;
  std::vector<std::string> columns;            ///< the first one names the row
  std::vector<std::vector<std::string>> rows;  ///< at most short_rows
  std::size_t left_out = 0;                    ///< rows that are not shown
  std::string file;                            ///< which has them all
};
inline constexpr std::size_t short_rows = 10, short_cautions = 4;

struct ShortReport {
  std::string title, scans, signature;
  std::vector<std::string> lead;
  std::vector<ShortRow> numbers;
  std::vector<std::string> meaning;   ///< of ±, of the level of detection
  std::vector<ShortTable> tables;     ///< largest changes, polygons
  std::vector<std::string> cautions;  ///< warnings of the comparison, short_cautions at most
  std::size_t more_cautions = 0;
  std::string foot;
};

[[nodiscard]] ShortReport short_report(const Comparison& c, const MapOptions& look, const Matching* matched);
/// Adds of what the map is drawn, where that is not the cells; for a report with a map.
void say_how_drawn(ShortReport& r, const MapOptions& look);

/// report.html of that: no script; printed on A4 it has two pages. The map is drawn for it, without
/// title and numbers, if options.map_png names one; `options.truth` is not shown.
void write_short_html(const std::string& path, const Comparison& c, const std::string& json, const PageOptions& options,
                      const Context& context);

/// Two pages of A4, text as text; lines and words of the map as such, its surface a picture of 2000 pixels.
/// The same bytes for the same comparison and options. `with_map`: with the map.
void write_pdf(const std::string& path, const Comparison& c, const MapOptions& look, const Matching* matched,
               bool with_map, const Context& context);

}  // namespace isopach
