// --registration-error: a standard deviation, or the covariance in a result of isopach match.
#pragma once
#include <optional>
#include <string>

#include "isopach/measure/uncertainty/uncertainty.hpp"

namespace isopach::cli {

struct RegistrationError {
  double shift = 0;
  std::optional<PoseCovariance> covariance;
  std::string source;  ///< name of the file
};

/// A number above 0, or the path of result.json of isopach match. UsageError for a text that is neither, InputError
/// naming the file for one that holds no covariance.
[[nodiscard]] RegistrationError parse_registration(const std::string& text);

}  // namespace isopach::cli
