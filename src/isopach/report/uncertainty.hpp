// What a comparison says of its uncertainty, in plain sentences.
#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "isopach/report/words.hpp"

namespace isopach {

/// net ± deviations · sigma; nothing without a model.
[[nodiscard]] std::optional<std::pair<double, double>> net_interval(const Comparison& c);

/// Whether 0 lies outside that interval; false without a model.
[[nodiscard]] bool net_is_significant(const Comparison& c);

/// Of the net, of the gross under the level of detection, of the bias of the gross. Empty where nothing was asked for.
[[nodiscard]] std::vector<std::string> uncertainty_sentences(const Comparison& c, const Quantity& quantity);

/// What of the gross an unchanged surface would show, too. Only where c.noise_floor is there.
[[nodiscard]] std::string noise_floor_sentence(const Comparison& c, const Quantity& quantity);

[[nodiscard]] const char* to_text(UncertaintyModel model);
[[nodiscard]] const char* to_text(CorrelationShape shape);

}  // namespace isopach
