#include "isopach/report/page/moved.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

#include "isopach/distance/vectors.hpp"

namespace isopach {
namespace {

/// Standard deviations of the three turns (rad), or of the three shifts.
std::array<double, 3> deviations(const Matching& m, std::size_t first) {
  std::array<double, 3> d{};
  for (std::size_t i = 0; i < 3; ++i) d[i] = std::sqrt(m.covariance[7 * (first + i)]);
  return d;
}

std::string three(const std::array<double, 3>& v, double factor, Typography t) {
  std::string text;
  for (const double value : v) text += (text.empty() ? "" : ", ") + number(factor * value, t, 2);
  return text;
}

}  // namespace

Moved moved_by(const Matching& m) {
  Moved result;
  const auto& r = m.pose.m;
  result.shift = m.pose.apply(m.centre) - m.centre;
  const Point3 twice{r[9] - r[6], r[2] - r[8], r[4] - r[1]};  // 2 s sin(angle) along the axis
  const double sine = length(twice) / (2 * m.scale), cosine = ((r[0] + r[5] + r[10]) / m.scale - 1) / 2;
  const double angle = std::atan2(sine, cosine);
  result.degrees = angle * 180 / std::numbers::pi;
  if (sine > 1e-6) {
    result.axis = (1 / length(twice)) * twice;
  } else if (cosine < 0) {  // half a turn: R + 1 is twice the projection on the axis; its longest column
    for (std::size_t k = 0; k < 3; ++k) {
      Point3 column{r[k] / m.scale, r[4 + k] / m.scale, r[8 + k] / m.scale};
      (k == 0 ? column.x : k == 1 ? column.y : column.z) += 1;
      if (length(column) > 1) result.axis = (1 / length(column)) * column;
    }
  }
  return result;
}

bool precision_is_told(const Matching& m) { return !m.verdict || m.verdict->trusted() || m.verdict->accepted; }

std::string moved_briefly(const Matching& m, const std::string& subject, Typography t) {
  const Moved by = moved_by(m);
  return fmt::format("{} was moved by {} {} and turned by {}°", subject, number(length(by.shift), t), unit_text(m.unit),
                     number(by.degrees, t, 3));
}

std::string moved_sentence(const Matching& m, const std::string& subject, Typography t) {
  const std::string unit = unit_text(m.unit);
  const Moved by = moved_by(m);
  std::string text =
      fmt::format("{} was moved by {} {} ({}, {}, {})", subject, number(length(by.shift), t), unit,
                  signed_number(by.shift.x, t), signed_number(by.shift.y, t), signed_number(by.shift.z, t));
  text += by.degrees > 0
              ? fmt::format(" and turned by {} degrees about ({}, {}, {})", number(by.degrees, t),
                            fixed_number(by.axis.x, 2, t), fixed_number(by.axis.y, 2, t), fixed_number(by.axis.z, 2, t))
              : ", not turned";
  text += fmt::format(", fitted on {} % of the common area", fixed_number(100 * m.overlap, 0, t));
  if (precision_is_told(m))
    text += fmt::format("; one standard deviation {} {} along and {} degrees about x, y, z",
                        three(deviations(m, 3), 1, t), unit, three(deviations(m, 0), 180 / std::numbers::pi, t));
  return text;
}

}  // namespace isopach
