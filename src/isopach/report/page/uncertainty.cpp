#include "isopach/report/page/uncertainty.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace isopach {

namespace {

/// Of the number rounded to its significant digits: 99.9999 counts as 100.
int exponent_of(double magnitude, int significant) {
  const std::string rounded = fmt::format("{:.{}e}", magnitude, significant - 1);
  return std::stoi(rounded.substr(rounded.find('e') + 1));
}

std::string percent_text(double share) { return fmt::format("{:.6g} %", 100 * share); }

std::string model_words(const UncertaintyOptions& o) {
  switch (o.model) {
    case UncertaintyModel::none:
      return "";
    case UncertaintyModel::independent:
      return "independent noise";
    case UncertaintyModel::correlated:
      return "correlated noise";
    case UncertaintyModel::registration:
      return o.sigma1.kind == SigmaSource::Kind::none ? "registration error alone" : "noise and registration error";
  }
  return "";
}

std::string interval_words(const Comparison& c, const Quantity& quantity) {
  const auto [from, to] = *net_interval(c);
  return quantity("uncertainty.interval_net.0", from, 3) + " and " + quantity("uncertainty.interval_net.1", to, 3);
}

/// Of a value of result.json, 0 where none is known. Of the gross: as if gained and lost erred alone.
double deviation_of(const Comparison& c, const std::string& key) {
  if (!c.uncertainty.sigma) return 0;
  const VolumeTriple& s = *c.uncertainty.sigma;
  const double area = c.domain_area, gross = std::hypot(s.above, s.below);
  if (key == "volume.net" || key.rfind("uncertainty.interval_net", 0) == 0) return s.net;
  if (key == "volume.above") return s.above;
  if (key == "volume.below") return s.below;
  if (key == "volume.absolute") return gross;
  if (key == "difference.mean") return area > 0 ? s.net / area : 0;
  if (key == "measure.rho") return area > 0 ? gross / area : 0;
  return 0;
}

std::string net_sentence(const Comparison& c, const Quantity& quantity) {
  const std::string confidence = percent_text(c.options.uncertainty.confidence);
  const std::string verdict = net_is_significant(c)
                                  ? (c.measures.volume.net > 0 ? "the net change is a gain at " + confidence
                                                               : "the net change is a loss at " + confidence)
                                  : "the net change is not distinguishable from zero at " + confidence;
  return verdict + ": its standard deviation is " + quantity("uncertainty.sigma_net", c.uncertainty.sigma->net, 3) +
         " (" + model_words(c.options.uncertainty) + "), it lies between " + interval_words(c, quantity);
}

std::string level_sentence(const Comparison& c, const Quantity& quantity) {
  const Uncertainty& u = c.uncertainty;
  const Detected& d = *u.detected;
  return percent_text(std::round(1000 * d.area / c.domain_area) / 1000) +
         " of the area differs by more than the level of detection of " + quantity("uncertainty.lod", *u.lod, 1) +
         (u.lod_is_given ? ""
                         : " (at " + percent_text(c.options.uncertainty.confidence) + "; without any change up to " +
                               percent_text(1 - c.options.uncertainty.confidence) + " would)") +
         ": there " + quantity("uncertainty.thresholded.above", d.above, 3) + " gained and " +
         quantity("uncertainty.thresholded.below", d.below, 3) + " lost; the net is never cut at that level";
}

}  // namespace

std::string number_within(double value, double deviation, Typography typography) {
  if (!std::isfinite(value) || !std::isfinite(deviation) || !(deviation > 0)) return number(value, typography);
  const int place = exponent_of(deviation, 2) - 1;
  const double step = std::pow(10.0, std::abs(place));
  const double rounded = place < 0 ? std::round(value * step) / step : std::round(value / step) * step;
  if (!std::isfinite(rounded) || rounded == 0) return rounded == 0 ? "0" : number(value, typography);
  const int digits = exponent_of(std::fabs(rounded), 15) - place + 1;
  return number(rounded, typography, std::clamp(digits, 1, 15));
}

std::string told(const Comparison& c, const std::string& key, double value, Typography typography, bool sign) {
  std::string text;
  if (key.rfind("uncertainty.sigma_", 0) == 0)
    text = number_within(value, value, typography);
  else
    text = number_within(value, deviation_of(c, key), typography);
  return sign && value > 0 && text != "0" ? "+" + text : text;
}

bool is_seen(double error, double value) { return error > 1e-6 * std::fabs(value); }

std::optional<std::pair<double, double>> net_interval(const Comparison& c) {
  if (!c.uncertainty.sigma) return std::nullopt;
  const double net = c.measures.volume.net, half = c.uncertainty.deviations * c.uncertainty.sigma->net;
  return std::pair{net - half, net + half};
}

bool net_is_significant(const Comparison& c) {
  const auto interval = net_interval(c);
  return interval && (interval->first > 0 || interval->second < 0);
}

std::vector<std::string> uncertainty_sentences(const Comparison& c, const Quantity& quantity) {
  std::vector<std::string> lines;
  if (c.uncertainty.sigma) lines.push_back(net_sentence(c, quantity));
  if (c.uncertainty.detected) lines.push_back(level_sentence(c, quantity));
  if (c.uncertainty.rectification_bias && *c.uncertainty.rectification_bias > 0)
    lines.push_back("noise makes gained and lost each too large, by " +
                    quantity("uncertainty.rectification_bias_max", *c.uncertainty.rectification_bias, 3) +
                    " at most (where the surfaces are the same)");
  if (c.noise_floor) lines.push_back(noise_floor_sentence(c, quantity));
  return lines;
}

std::string noise_floor_sentence(const Comparison& c, const Quantity& quantity) {
  const NoiseFloor& f = *c.noise_floor;
  return "of the gross " + quantity("volume.absolute", c.measures.volume.absolute, 3) + ", about " +
         quantity("uncertainty.noise_floor.absolute", f.above + f.below, 3) +
         " would also appear between two scans of an unchanged surface; without what that adds, the gross is about " +
         quantity("uncertainty.debiased.absolute", f.debiased.absolute, 3) + ": " +
         quantity("uncertainty.debiased.above", f.debiased.above, 3) + " gained and " +
         quantity("uncertainty.debiased.below", f.debiased.below, 3) + " lost; the net stays as it is";
}

const char* to_text(UncertaintyModel model) {
  switch (model) {
    case UncertaintyModel::none:
      return "none";
    case UncertaintyModel::independent:
      return "independent";
    case UncertaintyModel::correlated:
      return "correlated";
    case UncertaintyModel::registration:
      return "registration";
  }
  return "";
}

const char* to_text(CorrelationShape shape) {
  switch (shape) {
    case CorrelationShape::spherical:
      return "spherical";
    case CorrelationShape::exponential:
      return "exponential";
    case CorrelationShape::gaussian:
      return "gaussian";
  }
  return "";
}

}  // namespace isopach
