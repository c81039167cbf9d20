#include "isopach/report/page/words.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "isopach/base/option_key.hpp"

namespace isopach {
namespace {

constexpr std::string_view narrow_space = "\u202f";
constexpr std::string_view minus_sign = "−";

std::string grouped(const std::string& digits, Typography typography) {
  const std::string_view space = typography == Typography::fine ? narrow_space : std::string_view(" ");
  const std::size_t whole = std::min(digits.find('.'), digits.size());
  std::string out;
  for (std::size_t i = 0; i < whole; ++i) {
    // A group of four is left whole: 1234, but 12 345.
    if (whole > 4 && i > 0 && (whole - i) % 3 == 0) out += space;
    out += digits[i];
  }
  return out + digits.substr(whole);
}

std::string superscript(const std::string& digits) {
  static constexpr std::array<const char*, 10> raised{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string out;
  for (const char c : digits) out += c == '-' ? "⁻" : raised[static_cast<std::size_t>(c - '0')];
  return out;
}

std::string scientific(double magnitude, Typography typography, int significant) {
  const std::string plain = fmt::format("{:.{}e}", magnitude, significant - 1);
  if (typography == Typography::plain) return plain;
  const std::size_t e = plain.find('e');
  return plain.substr(0, e) + "×10" + superscript(std::to_string(std::stoi(plain.substr(e + 1))));
}

/// Of the number rounded to its significant digits: 99.9999 counts as 100.
int exponent_of(double magnitude, int significant) {
  const std::string rounded = fmt::format("{:.{}e}", magnitude, significant - 1);
  return std::stoi(rounded.substr(rounded.find('e') + 1));
}

std::string sign_text(bool negative, Typography typography) {
  if (!negative) return "";
  return std::string(typography == Typography::fine ? minus_sign : std::string_view("-"));
}

/// Length of the valid UTF-8 sequence at `i`, 0 if there is none (overlong forms and surrogates are none).
std::size_t utf8_length(std::string_view s, std::size_t i) {
  const auto byte = [&](std::size_t k) { return k < s.size() ? static_cast<unsigned char>(s[k]) : 0u; };
  const auto tail = [&](std::size_t k) { return (byte(k) & 0xC0u) == 0x80u; };
  const unsigned b = byte(i), next = byte(i + 1);
  if (b < 0x80) return 1;
  if (b >= 0xC2 && b < 0xE0) return tail(i + 1) ? 2 : 0;
  if (b >= 0xE0 && b < 0xF0) {
    const bool legal = (b != 0xE0 || next >= 0xA0) && (b != 0xED || next < 0xA0);
    return legal && tail(i + 1) && tail(i + 2) ? 3 : 0;
  }
  if (b >= 0xF0 && b < 0xF5) {
    const bool legal = (b != 0xF0 || next >= 0x90) && (b != 0xF4 || next < 0x90);
    return legal && tail(i + 1) && tail(i + 2) && tail(i + 3) ? 4 : 0;
  }
  return 0;
}

}  // namespace

std::string number(double value, Typography typography, int significant) {
  if (!std::isfinite(value)) return "n/a";
  if (value == 0) return "0";
  const double magnitude = std::fabs(value);
  std::string digits;
  if (magnitude < 1e-4 || magnitude >= 1e15) {
    digits = scientific(magnitude, typography, significant);
  } else {
    const int exponent = exponent_of(magnitude, significant);
    digits = grouped(fmt::format("{:.{}f}", magnitude, std::max(0, significant - 1 - exponent)), typography);
  }
  return sign_text(value < 0, typography) + digits;
}

std::string signed_number(double value, Typography typography, int significant) {
  return (value > 0 ? "+" : "") + number(value, typography, significant);
}

std::string fixed_number(double value, int decimals, Typography typography) {
  if (!std::isfinite(value)) return "n/a";
  std::string digits = fmt::format("{:.{}f}", std::fabs(value), decimals);
  const bool zero = digits.find_first_not_of("0.") == std::string::npos;
  return sign_text(value < 0 && !zero, typography) + grouped(digits, typography);
}

std::string count(std::uint64_t value, Typography typography) { return grouped(std::to_string(value), typography); }

int decimals_for(double span) {
  if (!(span > 0) || !std::isfinite(span)) return 3;
  return std::clamp(3 - static_cast<int>(std::floor(std::log10(span))), 0, 9);
}

std::string unit_text(const std::string& unit, int power) {
  const std::string base = unit == "unknown" || unit.empty() ? "units" : unit == "us-ft" ? "US ft" : unit;
  return base + (power == 3 ? "³" : power == 2 ? "²" : "");
}

std::string height_unit(const Comparison& c) {
  if (c.unit == "unknown" || !c.options.unit.empty()) return c.unit;
  const std::string& named = c.a.vertical_unit != "unknown" ? c.a.vertical_unit : c.b.vertical_unit;
  if (named == "unknown") return c.unit == "deg" ? named : c.unit;
  const bool along_z = c.frame.rotation[6] == 0 && c.frame.rotation[7] == 0;
  return named == c.unit || along_z ? named : "unknown";
}

std::string measured_unit(const Comparison& c, int power) {
  const std::string height = height_unit(c);
  if (power == 2 || height == c.unit) return unit_text(c.unit, power);
  return power == 1 ? unit_text(height) : unit_text(height) + "·" + unit_text(c.unit, 2);
}

std::string unit_sentence(const std::string& unit) {
  return unit == "unknown" || unit.empty() ? "units unknown (as in the files)" : unit_text(unit);
}

std::string border_sentence(const Comparison& c) {
  const std::string rule = to_text(c.options.border);
  if (c.trimmed_area == 0) return rule + ": nothing left out";
  return fmt::format(
      "{}: {:.2g} % of the area left out, triangles that bridge places without points{}", rule, 100 * c.trimmed_area,
      c.trimmed_volume > 0
          ? fmt::format("; with them, {:.2g} % of the gross volume would be theirs", 100 * c.trimmed_volume)
          : std::string());
}

std::string fold_sentence(const Comparison& c) {
  if (!c.options.check_layers) return "not looked for";
  const FoldSummary& f = c.folds;
  if (f.area == 0) return "none found";
  const std::string what = fmt::format("{:.2g} % of the area has several layers along the direction", 100 * f.share);
  const std::string volumes = fmt::format("gained {} and lost {} {}", number(f.volume.above, Typography::plain),
                                          number(f.volume.below, Typography::plain), measured_unit(c, 3));
  return c.options.folds == FoldRule::leave_out ? what + " and is left out; as triangulated it would add " + volumes
                                                : what + " and is measured as triangulated: " + volumes;
}

std::string clean_utf8(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = utf8_length(text, i);
    const bool control = length == 1 && (static_cast<unsigned char>(text[i]) < 0x20 || text[i] == 0x7F);
    if (length == 0 || control) {
      out += "\uFFFD";
      i += 1;
    } else {
      out.append(text.substr(i, length));
      i += length;
    }
  }
  return out;
}

std::string message_text(const std::string& message) { return clean_utf8(for_shell(message)); }

std::string input_name(const InputSummary& input) {
  const std::string name = input.path.substr(input.path.find_last_of("/\\") + 1);
  return clean_utf8(name.empty() ? input.role : name);
}

std::vector<Percentile> all_percentiles(const DifferenceStatistics& d) {
  std::vector<Percentile> all;
  for (std::size_t i = 0; i < percentile_levels.size(); ++i)
    all.push_back({static_cast<double>(percentile_levels[i]), d.abs_percentiles[i]});
  all.insert(all.end(), d.more_percentiles.begin(), d.more_percentiles.end());
  std::stable_sort(all.begin(), all.end(), [](const Percentile& p, const Percentile& q) { return p.level < q.level; });
  all.erase(
      std::unique(all.begin(), all.end(), [](const Percentile& p, const Percentile& q) { return p.level == q.level; }),
      all.end());
  return all;
}

namespace {

// In terms of ρ_dV.
std::string detail_headline(const DetailMeasure& d, const Quantity& quantity) {
  return std::string("Without the detail that ") + (d.coarser_is_b ? "A" : "B") +
         " alone can hold, the scans differ by " + quantity("measure.rho_dv", d.rho, 1) + " on average" +
         (d.mean == 0 ? std::string(" and B lies neither above nor below A")
                      : "; B lies " + quantity("measure.detail.mean", std::fabs(d.mean), 1) +
                            (d.mean > 0 ? " above A" : " below A")) +
         ", on " + quantity("measure.detail.area", d.area, 2) + ".";
}

std::string currents_headline(const CurrentsComparison& k, const Quantity& quantity) {
  return "As currents, with detail below " + quantity("measure.currents.sigma", k.sums.sigma, 1) +
         " blurred, the scans are " + quantity("measure.currents.distance", k.distance(), 2) +
         " apart, where A alone is " +
         quantity("measure.currents.norm_a", std::sqrt(std::max(0.0, k.sums.norm_a2)), 2) + " and B " +
         quantity("measure.currents.norm_b", std::sqrt(std::max(0.0, k.sums.norm_b2)), 2) + ".";
}

}  // namespace

std::string headline(const Comparison& c, const Quantity& quantity) {
  const Measures& m = c.measures;
  if (c.options.measure == MeasureKind::currents && c.currents) return currents_headline(*c.currents, quantity);
  if (c.options.measure == MeasureKind::dV && c.detail) return detail_headline(*c.detail, quantity);
  if (m.difference.max_above == 0 && m.difference.max_below == 0)
    return "B and A do not differ: d is 0 everywhere on the " + quantity("domain.area", c.domain_area, 2) +
           " compared.";
  const double mean = m.difference.mean;
  const std::string level = mean == 0 ? std::string("B lies on average neither above nor below A")
                                      : "B lies on average " + quantity("difference.mean", std::fabs(mean), 1) +
                                            (mean > 0 ? " above A" : " below A");
  return level + ": " + quantity("volume.above", m.volume.above, 3) + " gained and " +
         quantity("volume.below", m.volume.below, 3) + " lost on " + quantity("domain.area", c.domain_area, 2) + ".";
}

const char* to_text(DuplicatePolicy policy) {
  switch (policy) {
    case DuplicatePolicy::mean:
      return "mean";
    case DuplicatePolicy::min:
      return "min";
    case DuplicatePolicy::max:
      return "max";
    case DuplicatePolicy::median:
      return "median";
    case DuplicatePolicy::first:
      return "first";
    case DuplicatePolicy::error:
      return "error";
  }
  return "";
}
const char* to_text(Surface surface) {
  switch (surface) {
    case Surface::common:
      return "common";
    case Surface::overlay:
      return "overlay";
    case Surface::both:
      return "both";
  }
  return "";
}
const char* to_text(MeasureKind measure) {
  return measure == MeasureKind::dV ? "dV" : measure == MeasureKind::currents ? "currents" : "V";
}
const char* to_text(DomainKind domain) { return domain == DomainKind::overlap ? "overlap" : "hull"; }
const char* to_text(FoldRule folds) { return folds == FoldRule::leave_out ? "leave-out" : "keep"; }
const char* to_text(BorderRule border) { return border == BorderRule::trim ? "trim" : "hull"; }
const char* to_text(LocateMethod method) {
  switch (method) {
    case LocateMethod::tree:
      return "tree";
    case LocateMethod::interface:
      return "interface";
    case LocateMethod::order:
      return "order";
  }
  return "";
}
const char* to_text(Direction::Kind kind) {
  switch (kind) {
    case Direction::Kind::axis_x:
      return "x";
    case Direction::Kind::axis_y:
      return "y";
    case Direction::Kind::axis_z:
      return "z";
    case Direction::Kind::vector:
      return "vector";
    case Direction::Kind::fit:
      return "fit";
  }
  return "";
}

void line(std::string& out, std::string_view label, std::string_view text) {
  out += fmt::format("  {:<16}{}\n", label, text);
}

}  // namespace isopach
