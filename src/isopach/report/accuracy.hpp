// What `isopach accuracy` writes and prints, and its verdict.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "isopach/apps/accuracy.hpp"
#include "isopach/report/report.hpp"

namespace isopach {

/// A statistic of an Accuracy that a tolerance can be given for.
struct AccuracyStatistic {
  const char* name;
  const char* meaning;
  double (*of)(const Accuracy& a);  ///< NaN where it was not measured
};
[[nodiscard]] const std::vector<AccuracyStatistic>& accuracy_statistics();

/// A limit on one of them: at most, or with `least` at least.
struct AccuracyLimit {
  std::string statistic;
  double limit = 0;
  bool least = false;
};
struct AccuracyCheck {
  AccuracyLimit limit;
  double value = 0;
  bool passed = false;
};
[[nodiscard]] std::vector<AccuracyCheck> verdict(const Accuracy& a, const std::vector<AccuracyLimit>& limits);
/// One line for all that failed; empty if none did.
[[nodiscard]] std::string failed(const Accuracy& a, const std::vector<AccuracyCheck>& checks);

/// Schema isopach.accuracy/1: no NaN, shortest round-trip numbers, two-space indent.
[[nodiscard]] std::string accuracy_json(const Accuracy& a, const std::vector<AccuracyCheck>& checks,
                                        const std::vector<std::string>& outputs);
/// Aligned lines with units, warnings last. Ends with a newline; no colours.
[[nodiscard]] std::string accuracy_text(const Accuracy& a, const std::vector<AccuracyCheck>& checks);
/// accuracy.png: reconstruction − reference.
void write_accuracy_map(const std::string& path, const Accuracy& a, const MapOptions& look, const Context& context);
void write_accuracy_html(const std::string& path, const Accuracy& a, const std::string& map_png,
                         const std::string& json, const MapOptions& look, const Context& context);

}  // namespace isopach
