// What a comparison says of its uncertainty, in plain sentences.
#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "isopach/report/page/words.hpp"

namespace isopach {

/// net ± deviations · sigma; nothing without a model.
[[nodiscard]] std::optional<std::pair<double, double>> net_interval(const Comparison& c);

/// Whether 0 lies outside that interval; false without a model.
[[nodiscard]] bool net_is_significant(const Comparison& c);

/// No more digits than the standard deviation carries: `value` rounded to the place of its second digit, so that net
/// and σ read "1234.6" and "3.2". number() where the deviation is not above 0.
[[nodiscard]] std::string number_within(double value, double deviation, Typography typography);

/// The value of `key` in result.json as people read it: volumes and mean of d with no more digits than their standard
/// deviation carries, where one is known, and that one with two; everything else by number(). `sign`: with "+".
[[nodiscard]] std::string told(const Comparison& c, const std::string& key, double value, Typography typography,
                               bool sign = false);

/// Whether an error of integration shows in the digits that people are given of `value`: that of a closed form is 0, or
/// rounding.
[[nodiscard]] bool is_seen(double error, double value);

/// Of the net, of the gross under the level of detection, of the bias of the gross. Empty where nothing was asked for.
[[nodiscard]] std::vector<std::string> uncertainty_sentences(const Comparison& c, const Quantity& quantity);

/// What of the gross an unchanged surface would show, too. Only where c.noise_floor is there.
[[nodiscard]] std::string noise_floor_sentence(const Comparison& c, const Quantity& quantity);

[[nodiscard]] const char* to_text(UncertaintyModel model);
[[nodiscard]] const char* to_text(CorrelationShape shape);

}  // namespace isopach
