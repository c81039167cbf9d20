#include "isopach/report/uncertainty.hpp"

#include <fmt/format.h>

#include <cmath>

namespace isopach {

namespace {

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

std::string net_sentence(const Comparison& c, const Quantity& quantity) {
  const std::string confidence = percent_text(c.options.uncertainty.confidence);
  const std::string verdict = net_is_significant(c)
                                  ? (c.measures.volume.net > 0 ? "the net change is a gain at " + confidence
                                                               : "the net change is a loss at " + confidence)
                                  : "the net change is not distinguishable from zero at " + confidence;
  return verdict + ": its standard deviation is " + quantity("uncertainty.sigma_net", c.uncertainty.sigma->net, 3) +
         " (" + model_words(c.options.uncertainty) + ")";
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
