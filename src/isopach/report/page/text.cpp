#include "isopach/report/page/text.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "isopach/report/changes.hpp"
#include "isopach/report/page/detail_told.hpp"
#include "isopach/report/page/moved.hpp"
#include "isopach/report/page/uncertainty.hpp"
#include "isopach/report/page/words.hpp"

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

/// "off by +10 577, +4.3 %"
std::string off_by(double measured, double known) {
  const std::string relative =
      known == 0 ? "" : ", " + signed_number(100 * (measured - known) / std::fabs(known), plain, 2) + " %";
  return "off by " + signed_number(measured - known, plain, 2) + relative;
}

void add_truth(Summary& s, const Truth& truth, const Comparison& c) {
  const Volume& measured = c.measures.volume;
  const auto row = [&](const char* label, double known, double raw, const double* debiased) {
    std::string text = off_by(raw, known);
    if (debiased != nullptr)
      text += "; without the noise floor " + number(*debiased, plain) + ", " + off_by(*debiased, known);
    s.value(label, number(known, plain), 3, text);
  };
  const Volume* debiased = c.noise_floor ? &c.noise_floor->debiased : nullptr;
  row("true gained", truth.above, measured.above, debiased != nullptr ? &debiased->above : nullptr);
  row("true lost", truth.below, measured.below, debiased != nullptr ? &debiased->below : nullptr);
  row("true net", truth.net, measured.net, nullptr);
  s.line("", noise_note);
}

std::string interval_remark(const Comparison& c) {
  const auto interval = net_interval(c);
  if (!interval) return "";
  return fmt::format("; {:.6g} %: {} to {}", 100 * c.options.uncertainty.confidence,
                     told(c, "uncertainty.interval_net.0", interval->first, plain, true),
                     told(c, "uncertainty.interval_net.1", interval->second, plain, true));
}

void add_budget(Summary& s, const Comparison& c) {
  constexpr std::size_t most_rows = 20;
  if (c.budget.empty()) return;
  s.line("by polygon",
         fmt::format("{:>14}{:>14}{:>14}{:>14}{:>12}{:>10}", "gained", "lost", "net", "area", "mean d", "measured"));
  const auto n = [](double v) { return number(v, plain); };
  for (std::size_t i = 0; i < std::min(most_rows, c.budget.size()); ++i) {
    const BudgetRow& r = c.budget[i];
    s.line("  " + clean_utf8(r.name),
           fmt::format("{:>14}{:>14}{:>14}{:>14}{:>12}{:>8} %", n(r.volume.above), n(r.volume.below),
                       signed_number(r.volume.net, plain), n(r.area), r.area > 0 ? signed_number(r.mean, plain) : "-",
                       fixed_number(100 * r.coverage, 1, plain)));
  }
  s.line("", fmt::format("in {}, {}, {}; measured: the part of the polygon that was compared", measured_unit(c, 3),
                         measured_unit(c, 2), measured_unit(c, 1)));
  if (c.budget.size() > most_rows)
    s.line("", fmt::format("and {} more in result.json and budget.csv (-o DIR)",
                           count(c.budget.size() - most_rows, plain)));
}

}  // namespace

std::string comparison_text(const Comparison& c, const std::optional<Truth>& truth, const Matching* matched) {
  const Measures& m = c.measures;
  const DifferenceStatistics& d = m.difference;
  Summary s(c);
  const auto n = [](double v) { return number(v, plain); };
  const auto quantity = [&](const std::string& key, double v, int power) {
    return told(c, key, v, plain) + " " + measured_unit(c, power);
  };
  s.free_line(headline(c, quantity) +
              (matched != nullptr ? " " + moved_briefly(*matched, "B", plain) + " first." : ""));
  if (matched != nullptr) {
    s.line("moved", moved_sentence(*matched, "B", plain));
    if (matched->verdict) s.line("verdict", message_text(sentence(*matched->verdict, unit_text(matched->unit))));
  }
  add_input(s, c.a);
  add_input(s, c.b);
  s.value("gained", told(c, "volume.above", m.volume.above, plain), 3, "volume where B lies above A");
  s.value("lost", told(c, "volume.below", m.volume.below, plain), 3, "volume where B lies below A");
  s.value("net", told(c, "volume.net", m.volume.net, plain, true), 3, "gained - lost" + interval_remark(c));
  s.value("mean |d| (rho)", told(c, "measure.rho", m.rho, plain), 1, "(gained + lost) / area");
  if (tells_detail(c))
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
    s.value("weighted rho", n(w.rho), 1,
            "(weighted gained + lost) / area" +
                (is_seen(w.error_estimate, w.rho) ? ", within " + n(w.error_estimate) : ""));
    s.value("weighted net", signed_number(w.net, plain), 3, "gained " + n(w.above) + ", lost " + n(w.below));
  }
  s.value("mean d", told(c, "difference.mean", d.mean, plain, true), 1, "d = B - A, positive where B lies above A");
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
  if (c.changes) s.line("changes", change_sentence(c));
  const auto sentences = uncertainty_sentences(c, quantity);
  for (std::size_t i = 0; i < sentences.size(); ++i) s.line(i == 0 ? "uncertainty" : "", sentences[i]);
  if (truth) add_truth(s, *truth, c);
  if (c.unit == "unknown" || c.unit.empty()) s.line("units", unit_sentence(c.unit));
  s.line("time", fmt::format("{:.2f} s, {} triangles", c.timing.total, count(c.common, plain)));
  for (const std::string& w : c.warnings) s.free_line("warning: " + message_text(w));
  return s.str();
}

}  // namespace isopach
