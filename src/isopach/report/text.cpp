#include "isopach/report/text.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "isopach/report/uncertainty.hpp"
#include "isopach/report/words.hpp"

namespace isopach {
namespace {

constexpr Typography plain = Typography::plain;

class Summary {
 public:
  explicit Summary(const Comparison& c) : c_(c) {
    const std::string widest = measured_unit(c, 3);
    const auto letters = std::count_if(widest.begin(), widest.end(), [](char l) { return (l & 0xC0) != 0x80; });
    unit_width_ = std::max(6, static_cast<int>(letters));
  }

  void line(const std::string& label, const std::string& text) { isopach::line(out_, label, text); }
  /// A number right-aligned before its unit and a remark.
  void value(const std::string& label, const std::string& digits, int power, const std::string& remark) {
    line(label, fmt::format("{:>12} {:<{}} {}", digits, measured_unit(c_, power), unit_width_, remark));
  }
  void free_line(const std::string& text) { out_ += text + "\n"; }
  [[nodiscard]] const std::string& str() const { return out_; }

 private:
  const Comparison& c_;
  int unit_width_ = 0;
  std::string out_;
};

void add_input(Summary& s, const InputSummary& in) {
  const Cleaning& k = in.cleaning;
  std::string text = input_name(in) + ": " + count(in.points, plain) + " points, " + count(in.nodes, plain) + " nodes";
  const auto also = [&](std::size_t n, const char* what) {
    if (n > 0) text += ", " + count(n, plain) + " " + what;
  };
  also(k.duplicates, "duplicates merged");
  also(k.dropped_nonfinite, "not finite");
  also(k.dropped_class, "of other classes");
  also(k.dropped_crop, "outside the crop");
  also(in.nodata, "no data");
  s.line(in.role, text);
}

void add_truth(Summary& s, const Truth& truth, const Measures& m) {
  const auto row = [&](const char* label, double known, double measured) {
    const std::string relative =
        known == 0 ? "" : ", " + signed_number(100 * (measured - known) / std::fabs(known), plain, 2) + " %";
    s.value(label, number(known, plain), 3, "off by " + signed_number(measured - known, plain, 2) + relative);
  };
  row("true gained", truth.above, m.volume.above);
  row("true lost", truth.below, m.volume.below);
  row("true net", truth.net, m.volume.net);
  s.line("", noise_note);
}

void add_budget(Summary& s, const Comparison& c) {
  constexpr std::size_t most_rows = 20;
  if (c.budget.empty()) return;
  s.line("by polygon", fmt::format("{:>14}{:>14}{:>14}{:>14}{:>12}", "gained", "lost", "net", "area", "mean d"));
  const auto n = [](double v) { return number(v, plain); };
  for (std::size_t i = 0; i < std::min(most_rows, c.budget.size()); ++i) {
    const BudgetRow& r = c.budget[i];
    s.line("  " + clean_utf8(r.name),
           fmt::format("{:>14}{:>14}{:>14}{:>14}{:>12}", n(r.volume.above), n(r.volume.below),
                       signed_number(r.volume.net, plain), n(r.area), r.area > 0 ? signed_number(r.mean, plain) : "-"));
  }
  s.line("", fmt::format("in {}, {}, {}", measured_unit(c, 3), measured_unit(c, 2), measured_unit(c, 1)));
  if (c.budget.size() > most_rows)
    s.line("", fmt::format("and {} more in result.json and budget.csv (-o DIR)",
                           count(c.budget.size() - most_rows, plain)));
}

}  // namespace

std::string comparison_text(const Comparison& c, const std::optional<Truth>& truth) {
  const Measures& m = c.measures;
  const DifferenceStatistics& d = m.difference;
  Summary s(c);
  const auto n = [](double v) { return number(v, plain); };
  s.free_line(
      headline(c, [&](const std::string&, double v, int power) { return n(v) + " " + measured_unit(c, power); }));
  add_input(s, c.a);
  add_input(s, c.b);
  s.value("gained", n(m.volume.above), 3, "volume where B lies above A");
  s.value("lost", n(m.volume.below), 3, "volume where B lies below A");
  s.value("net", signed_number(m.volume.net, plain), 3, "gained - lost");
  s.value("mean |d| (rho)", n(m.rho), 1, "(gained + lost) / area");
  if (c.detail)
    s.value("rho_dV", n(c.detail->rho), 1,
            std::string("the same without detail that ") + (c.detail->coarser_is_b ? "A" : "B") + " alone can hold");
  if (c.currents) {
    const CurrentsComparison& k = *c.currents;
    s.value(
        "as currents", n(k.distance()), 2,
        "apart, " + n(100 * k.relative()) + " % of the norms; sigma " + n(k.sums.sigma) + " " + measured_unit(c, 1));
  }
  if (c.weighted) {
    const WeightedMeasures& w = *c.weighted;
    s.line("weight", clean_utf8(to_text(c.options.weight)));
    s.value("weighted rho", n(w.rho), 1, "(weighted gained + lost) / area, within " + n(w.error_estimate));
    s.value("weighted net", signed_number(w.net, plain), 3, "gained " + n(w.above) + ", lost " + n(w.below));
  }
  s.value("mean d", signed_number(d.mean, plain), 1, "d = B - A, positive where B lies above A");
  s.value("rms of d", n(d.rms), 1, "std " + n(d.std) + ", nmad " + n(d.nmad));
  std::string others;
  for (const Percentile& p : all_percentiles(d))
    if (p.level != 95) others += (others.empty() ? "" : ", ") + fmt::format("{}", p.level) + " %: " + n(p.value);
  s.value("|d| at 95 %", n(d.abs_percentiles[2]), 1, "of the area; " + others);
  s.value("largest", signed_number(d.max_above, plain), 1, "above, " + signed_number(-d.max_below, plain) + " below");
  s.value("area compared", n(c.domain_area), 2,
          fixed_number(100 * c.coverage, 1, plain) + " % of the area of both scans");
  if (c.options.surface == Surface::overlay) s.line("surface", "exact overlay of the two triangulations");
  if (c.overlay) {
    const Volume &v = c.overlay->volume, &w = m.volume;
    s.value("exact overlay", signed_number(v.net, plain), 3, "net; gained " + n(v.above) + ", lost " + n(v.below));
    s.value("", signed_number(v.net - w.net, plain), 3,
            "more than above; gained " + signed_number(v.above - w.above, plain) + ", lost " +
                signed_number(v.below - w.below, plain));
  }
  s.line("border", border_sentence(c));
  if (c.folds.area > 0) s.line("folds", fold_sentence(c));
  add_budget(s, c);
  const auto sentences = uncertainty_sentences(
      c, [&](const std::string&, double v, int power) { return n(v) + " " + measured_unit(c, power); });
  for (std::size_t i = 0; i < sentences.size(); ++i) s.line(i == 0 ? "uncertainty" : "", sentences[i]);
  if (truth) add_truth(s, *truth, m);
  if (c.unit == "unknown" || c.unit.empty()) s.line("units", unit_sentence(c.unit));
  s.line("time", fmt::format("{:.2f} s, {} triangles", c.timing.total, count(c.common, plain)));
  for (const std::string& w : c.warnings) s.free_line("warning: " + clean_utf8(w));
  return s.str();
}

}  // namespace isopach
