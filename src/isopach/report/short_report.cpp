#include "isopach/report/short_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "isopach/io/output_file.hpp"
#include "isopach/report/draw/map.hpp"
#include "isopach/report/page/change_values.hpp"
#include "isopach/report/page/furniture.hpp"
#include "isopach/report/page/matched.hpp"
#include "isopach/report/page/moved.hpp"
#include "isopach/report/page/page.hpp"
#include "isopach/report/page/uncertainty.hpp"
#include "isopach/report/page/verdict_values.hpp"
#include "isopach/report/page/words.hpp"
#include "isopach/version.hpp"

namespace isopach {
namespace {

constexpr Typography fine = Typography::fine;

std::string as_sentence(std::string clause) {
  clause[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(clause[0])));
  return clause.back() == '.' ? clause : clause + ".";
}

/// Makes the parts of a ShortReport.
class Writer {
 public:
  Writer(const Comparison& c, const MapOptions& look, const Matching* matched)
      : c_(c), look_(look), matched_(matched) {}

  ShortReport write() {
    ShortReport r;
    r.title = look_.title.empty() ? input_name(c_.a) + " → " + input_name(c_.b) : clean_utf8(look_.title);
    r.scans = "A, before: " + scan_words(c_.a) + "   ·   B, after: " + scan_words(c_.b);
    r.signature = signature(c_, look_, "   ·   ");
    r.lead.push_back(headline(c_, quantity()));
    if (matched_ != nullptr) r.lead.push_back(as_sentence(moved_sentence(*matched_, "B", fine)));
    if (c_.uncertainty.sigma) r.lead.push_back(as_sentence(uncertainty_sentences(c_, quantity()).front()));
    numbers(r.numbers);
    meaning(r.meaning);
    changes(r.tables);
    polygons(r.tables);
    for (const std::string& w : c_.warnings) r.cautions.push_back(message_text(w));
    r.more_cautions = r.cautions.size() - std::min(r.cautions.size(), short_cautions);
    r.cautions.resize(r.cautions.size() - r.more_cautions);
    r.foot = std::string(sign_rule) + "   ·   " + std::string(tool_name) + " " + std::string(version);
    return r;
  }

 private:
  [[nodiscard]] std::string unit(int power) const { return measured_unit(c_, power); }
  [[nodiscard]] Quantity quantity() const {
    return [this](const std::string& key, double value, int power) {
      return told(c_, key, value, fine) + "\u00a0" + unit(power);
    };
  }
  [[nodiscard]] static std::string scan_words(const InputSummary& in) {
    return input_name(in) + " (" + count(in.points, fine) + " points)";
  }

  /// Half of the interval of a standard deviation.
  [[nodiscard]] std::string half(double sigma) const {
    const double v = c_.uncertainty.deviations * sigma;
    return v > 0 && std::isfinite(v) ? "± " + number_within(v, v, fine) : "";
  }

  void numbers(std::vector<ShortRow>& rows) const {
    const Volume& v = c_.measures.volume;
    const DifferenceStatistics& d = c_.measures.difference;
    const VolumeTriple s = c_.uncertainty.sigma.value_or(VolumeTriple{});
    const auto row = [&](const char* key, const char* name, double value, double sigma, int power, const char* why) {
      const std::string text = std::string_view(key) == "volume.net" || std::string_view(key) == "difference.mean"
                                   ? told(c_, key, value, fine, true)
                                   : told(c_, key, value, fine);
      rows.push_back({key, name, text, half(sigma), unit(power), why});
    };
    row("volume.net", "net", v.net, s.net, 3, "gained less lost");
    row("volume.above", "gained", v.above, s.above, 3, "where B lies above A");
    row("volume.below", "lost", v.below, s.below, 3, "where B lies below A");
    row("difference.mean", "mean difference", d.mean, c_.domain_area > 0 ? s.net / c_.domain_area : 0, 1,
        "net over the area compared");
    row("measure.rho", "mean |d|", c_.measures.rho, 0, 1, "how far apart the surfaces are");
    row("difference.max_above", "largest rise", d.max_above, 0, 1, "of B over A, at one place");
    row("difference.max_below", "largest fall", d.max_below, 0, 1, "of B under A, at one place");
    row("domain.area", "area compared", c_.domain_area, 0, 2, "where both scans are");
    rows.push_back({"", "", fixed_number(100 * c_.coverage, 1, fine), "", "%", "of the area of both scans"});
    if (c_.uncertainty.lod)
      row("uncertainty.lod", "level of detection", *c_.uncertainty.lod, 0, 1, "smaller differences may be noise");
    if (!c_.uncertainty.detected) return;
    row("uncertainty.thresholded.above", "gained beyond it", c_.uncertainty.detected->above, 0, 3,
        "of gained, what noise does not explain");
    row("uncertainty.thresholded.below", "lost beyond it", c_.uncertainty.detected->below, 0, 3,
        "of lost, what noise does not explain");
  }

  void meaning(std::vector<std::string>& says) const {
    const Uncertainty& u = c_.uncertainty;
    const std::string confidence = fmt::format("{:.6g}\u00a0%", 100 * c_.options.uncertainty.confidence);
    if (u.sigma)
      says.push_back("± is half of the interval that holds the true value with a probability of " + confidence +
                     ", if the errors stated for the scans are right.");
    else
      says.push_back("No error of the scans was stated, so no ± is claimed for the volumes.");
    if (!u.lod) {
      says.push_back("There is no level of detection: the map shows every difference in colour, real or not.");
      return;
    }
    says.push_back("At a single place a difference up to the level of detection, ±" + number(*u.lod, fine) + "\u00a0" +
                   unit(1) + ", may come from errors of the scans alone" +
                   (u.lod_is_given ? " (as stated)" : " (at " + confidence + ")") +
                   "; the map shows such places in grey. Volumes are known better than single places, because errors "
                   "of many places cancel in them.");
    const std::vector<std::string> sentences = uncertainty_sentences(c_, quantity());
    for (std::size_t i = u.sigma ? 1 : 0; i < sentences.size(); ++i) says.push_back(as_sentence(sentences[i]));
  }

  void changes(std::vector<ShortTable>& tables) const {
    if (!c_.changes || c_.changes->list.empty()) return;
    const auto& list = c_.changes->list;
    const bool has_sigma = list.front().sigma.has_value();
    ShortTable t{"The largest changes", {"no.", "net, " + unit(3)}, {}, 0, "changes.csv"};
    if (has_sigma) t.columns.push_back("±");
    for (const std::string& name : {"area, " + unit(2), "mean d, " + unit(1), "largest d, " + unit(1),
                                    std::string("x of it"), std::string("y of it")})
      t.columns.push_back(name);
    for (std::size_t i = 0; i < std::min(short_rows, list.size()); ++i) {
      const Change& x = list[i];
      const Point3 at = c_.frame.to_input({x.largest_at.x, x.largest_at.y, 0});
      const std::string net = number_within(x.net(), x.sigma.value_or(0), fine);
      std::vector<std::string> row{std::to_string(i + 1), x.net() > 0 ? "+" + net : net};
      if (has_sigma) row.push_back(half(x.sigma.value_or(0)));
      row.insert(row.end(),
                 {number(x.area, fine), signed_number(x.mean_d(), fine, 3), signed_number(x.largest_d(), fine, 3),
                  fixed_number(at.x, 1, fine), fixed_number(at.y, 1, fine)});
      t.rows.push_back(std::move(row));
    }
    t.left_out = list.size() - t.rows.size();
    tables.push_back(std::move(t));
  }

  void polygons(std::vector<ShortTable>& tables) const {
    if (c_.budget.empty()) return;
    ShortTable t{"By polygon",
                 {"polygon", "gained, " + unit(3), "lost, " + unit(3), "net, " + unit(3), "area, " + unit(2)},
                 {},
                 0,
                 "budget.csv"};
    for (std::size_t i = 0; i < std::min(short_rows, c_.budget.size()); ++i) {
      const BudgetRow& b = c_.budget[i];
      t.rows.push_back({clean_utf8(b.name), number(b.volume.above, fine), number(b.volume.below, fine),
                        signed_number(b.volume.net, fine), number(b.area, fine)});
    }
    t.left_out = c_.budget.size() - t.rows.size();
    tables.push_back(std::move(t));
  }

  const Comparison& c_;
  const MapOptions& look_;
  const Matching* matched_;
};

/// So that it prints on two pages of A4.
constexpr const char* sheet_style =
    "<style>main{max-width:860px}.sheet figure{margin:14px 0}.short td,.short th{padding:5px 12px 5px 0}"
    ".short .n{text-align:right;white-space:nowrap}.short .u,.short .why{color:var(--soft)}"
    "@media print{@page{size:A4;margin:14mm 15mm}body{font-size:9pt}h1{font-size:17pt}h2{font-size:11.5pt;"
    "margin:11pt 0 4pt}p{margin:0 0 5pt}.lead{font-size:11.5pt}.sheet{break-after:page}"
    ".sheet figure img{width:auto;max-width:100%;max-height:178mm;margin:0 auto;border:0}"
    ".short td,.short th{padding:2.2pt 9pt 2.2pt 0;font-size:8.6pt}.soft,footer{font-size:8.4pt}"
    ".warnings{padding:5pt 10pt;margin:6pt 0}footer{margin-top:12pt;padding-top:6pt}}</style>\n";

class ShortPage : public HtmlPage {
 public:
  ShortPage(const ShortReport& r, const std::string& json) : HtmlPage(json), r_(r) {}

  /// `map`: bytes of a PNG; empty: none.
  std::string write(const std::string& map, const std::string& logo_png) {
    open_page(r_.title);
    out_.insert(out_.find("</head>"), sheet_style);
    out_ += "<section class=\"sheet\">\n<header>\n";
    sign("", logo_png);
    out_ += "<h1>" + escaped(r_.title) + "</h1>\n<p class=\"soft\">" + escaped(r_.scans) + "</p>\n";
    sign(r_.signature, "");
    for (std::size_t k = 0; k < r_.lead.size(); ++k)
      out_ += std::string(k == 0 ? "<p class=\"lead\">" : "<p>") + escaped(r_.lead[k]) + "</p>\n";
    out_ += "</header>\n";
    if (!map.empty()) picture_of(map, "Map of the difference B − A in colours centred on zero");
    out_ += "</section>\n<section>\n";
    numbers();
    warnings_and_meaning();
    for (const ShortTable& t : r_.tables) table(t);
    out_ +=
        "<footer>" + escaped(r_.foot) + " · numbers are rounded; result.json has them in full</footer>\n</section>\n";
    close_page();
    return out_;
  }

 private:
  void numbers() {
    out_ += "<h2>The numbers</h2>\n<div class=\"scroll\"><table class=\"short\">\n<tbody>\n";
    for (const ShortRow& r : r_.numbers)
      out_ += "<tr><th scope=\"row\">" + escaped(r.name) + "</th><td class=\"n\">" +
              (r.key.empty() ? escaped(r.number) : datum(r.key, escaped(r.number))) + "</td><td class=\"n\">" +
              escaped(r.plus_minus) + "</td><td class=\"u\">" + escaped(r.unit) + "</td><td class=\"why\">" +
              escaped(r.why) + "</td></tr>\n";
    close_table();
  }

  void warnings_and_meaning() {
    if (!r_.cautions.empty()) {
      out_ += "<section class=\"warnings\" role=\"note\"><strong>Before you rely on the numbers</strong><ul>\n";
      for (const std::string& w : r_.cautions) out_ += "<li>" + escaped(w) + "</li>\n";
      if (r_.more_cautions > 0) out_ += fmt::format("<li>and {} more in result.json</li>\n", r_.more_cautions);
      out_ += "</ul></section>\n";
    }
    out_ += "<h2>How sure they are</h2>\n";
    for (const std::string& sentence : r_.meaning) out_ += "<p>" + escaped(sentence) + "</p>\n";
  }

  void table(const ShortTable& t) {
    out_ += "<h2>" + escaped(t.title) + "</h2>\n<div class=\"scroll\"><table class=\"short\">\n<thead><tr>";
    for (std::size_t k = 0; k < t.columns.size(); ++k)
      out_ += (k == 0 ? "<th>" : "<th class=\"n\">") + escaped(t.columns[k]) + "</th>";
    out_ += "</tr></thead>\n<tbody>\n";
    for (const auto& row : t.rows) {
      out_ += "<tr><th scope=\"row\">" + escaped(row.front()) + "</th>";
      for (std::size_t k = 1; k < row.size(); ++k) out_ += "<td class=\"n\">" + escaped(row[k]) + "</td>";
      out_ += "</tr>\n";
    }
    close_table();
    if (t.left_out > 0)
      out_ += fmt::format("<p class=\"soft\">And {} more in {}.</p>\n", count(t.left_out, fine), t.file);
  }

  const ShortReport& r_;
};

}  // namespace

ShortReport short_report(const Comparison& c, const MapOptions& look, const Matching* matched) {
  return Writer(c, look, matched).write();
}

void say_how_drawn(ShortReport& r, const MapOptions& look) {
  if (!look.words.drawn.empty())
    r.meaning.push_back("The map is " + look.words.drawn + "; all numbers are of the cells themselves.");
}

void write_short_html(const std::string& path, const Comparison& c, const std::string& json, const PageOptions& options,
                      const Context& context) {
  context.check();
  ShortReport r = short_report(c, options.look, options.matched);
  if (!options.map_png.empty()) say_how_drawn(r, options.look);
  constexpr double map_words = 1.15;  // larger than on a map by itself: it is printed smaller
  const std::string map =
      options.map_png.empty() ? "" : png_of(render_map(c, options.look, context, {0, {}, map_words, true}));
  write_text_atomically(path, ShortPage(r, json).write(map, options.look.logo.png));
}

}  // namespace isopach
