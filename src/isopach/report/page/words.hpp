// Words and numbers for people: what map, HTML page and terminal summary share, so that they say the same.
// Nothing here changes a value; the exact one stands in result.json.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "isopach/compare/comparison.hpp"

namespace isopach {

/// plain: ASCII signs, for terminals ("-1 234.5", "1.2e-07"). fine: for print ("−1 234.5" with a narrow no-break space,
/// "1.2×10⁻⁷").
enum class Typography { plain, fine };

/// `significant` digits, never fewer than the integer part has; thousands grouped; "n/a" for NaN and infinities.
[[nodiscard]] std::string number(double value, Typography typography, int significant = 4);

/// With a sign, "+" included (0 has none).
[[nodiscard]] std::string signed_number(double value, Typography typography, int significant = 4);

/// Fixed number of decimals, thousands grouped: coordinates.
[[nodiscard]] std::string fixed_number(double value, int decimals, Typography typography);

[[nodiscard]] std::string count(std::uint64_t value, Typography typography);

/// Decimals that tell apart 1/1000 of `span`, between 0 and 9.
[[nodiscard]] int decimals_for(double span);

/// "m", "m²", "m³"; "US ft²"; "units" where the unit is unknown.
[[nodiscard]] std::string unit_text(const std::string& unit, int power = 1);

/// Unit of heights and of d. That of x and y, unless the files name another for their heights; "unknown" where x and y
/// are degrees and the heights' unit is not named, or where the two differ and the direction is not z.
[[nodiscard]] std::string height_unit(const Comparison& c);

/// Of a measured height (power 1), area (2) or volume (3); "US ft·m²" where heights have a unit of their own.
[[nodiscard]] std::string measured_unit(const Comparison& c, int power);

/// "m", or "units unknown (as in the files)".
[[nodiscard]] std::string unit_sentence(const std::string& unit);

/// What the border rule left out, in one line.
[[nodiscard]] std::string border_sentence(const Comparison& c);
/// How much of the area has several layers, and what became of it, in one line.
[[nodiscard]] std::string fold_sentence(const Comparison& c);

/// Last part of the path; the role where there is no path. Always valid UTF-8 without control characters.
[[nodiscard]] std::string input_name(const InputSummary& input);

/// `text` with every byte that is not part of valid UTF-8, and every control character, replaced by U+FFFD.
[[nodiscard]] std::string clean_utf8(std::string_view text);

/// A message of the library (a warning, a reason, a verdict) as texts, pages and pictures show it: with options spelled
/// as at a command line (base/option_key.hpp), and clean_utf8. In JSON: values::message and values::messages.
[[nodiscard]] std::string message_text(const std::string& message);

/// All percentiles of |d| in ascending order of their levels, each level once.
[[nodiscard]] std::vector<Percentile> all_percentiles(const DifferenceStatistics& d);

/// The result in one sentence. `quantity` writes one number with its unit, given its key in result.json (e.g.
/// "volume.net"), the value to print and the power of the unit.
using Quantity = std::function<std::string(const std::string& key, double value, int power)>;
[[nodiscard]] std::string headline(const Comparison& c, const Quantity& quantity);

[[nodiscard]] const char* to_text(DuplicatePolicy policy);
[[nodiscard]] const char* to_text(Surface surface);
[[nodiscard]] const char* to_text(MeasureKind measure);
[[nodiscard]] const char* to_text(DomainKind domain);
[[nodiscard]] const char* to_text(BorderRule border);
[[nodiscard]] const char* to_text(FoldRule folds);
[[nodiscard]] const char* to_text(LocateMethod method);
[[nodiscard]] const char* to_text(Direction::Kind kind);

inline constexpr std::string_view tool_name = "isopach";
inline constexpr std::string_view sign_rule = "d = B − A, positive where B lies above A";

/// What a reader must know when gained and lost are set beside a truth.
inline constexpr const char* noise_note =
    "noise and interpolation count as gain here and as loss there; in the net they cancel";

/// A line of a summary: the label in its column, then the text.
void line(std::string& out, std::string_view label, std::string_view text);

}  // namespace isopach
