#include "cli/registration.hpp"

#include <fmt/core.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "cli/parse.hpp"
#include "cli/session.hpp"
#include "isopach/base/error.hpp"

namespace isopach::cli {
namespace {

using Json = nlohmann::json;

/// The covariance has motions that the scans do not determine.
struct Undetermined {};

PoseCovariance covariance_in(const Json& json) {
  PoseCovariance c;
  const Json &rows = json.at("covariance"), &centre = json.at("centre");
  if (rows.size() != 6 || centre.size() != 3) throw std::length_error("not 6 x 6");
  for (std::size_t i = 0; i < 6; ++i) {
    if (rows.at(i).size() != 6) throw std::length_error("not 6 x 6");
    for (std::size_t j = 0; j < 6; ++j) {
      if (rows.at(i).at(j).is_null()) throw Undetermined();
      c.matrix[6 * i + j] = rows.at(i).at(j).get<double>();
    }
  }
  c.centre = {centre.at(0).get<double>(), centre.at(1).get<double>(), centre.at(2).get<double>()};
  return c;
}

}  // namespace

RegistrationError parse_registration(const std::string& text) {
  if (const auto shift = as_number(text)) {
    if (!(*shift > 0))
      throw UsageError(fmt::format("--registration-error: {} is no standard deviation, give one above 0", text));
    return {*shift, std::nullopt, ""};
  }
  const auto& matchings = session().matchings;
  const auto given = matchings.find(text);
  std::ifstream file(text);
  if (given == matchings.end() && !file)
    throw UsageError(fmt::format(
        "--registration-error: '{}' is neither a number nor a result of isopach match that can be opened", text));
  try {
    if (given != matchings.end()) return {0, covariance_in(Json::parse(given->second)), "match"};
    return {0, covariance_in(Json::parse(file)), text};
  } catch (const Undetermined&) {
    throw InputError(
        fmt::format("{}: the scans do not determine the pose along every motion ('undetermined'), so there is no "
                    "covariance of all: "
                    "give --registration-error a number: the standard deviation of a shift of B along the direction",
                    text));
  } catch (const std::exception&) {  // of the reader: no JSON, a key that is not there, a value of another type
    throw InputError(fmt::format(
        "{}: holds no 'covariance' of 6 x 6 numbers with its 'centre': --registration-error needs a number, or the "
        "result.json of isopach match",
        text));
  }
}

}  // namespace isopach::cli
