#include "isopach/match/pairs/anderson.hpp"

#include <cmath>

#include "isopach/base/linear.hpp"
#include "isopach/distance/vectors.hpp"

namespace isopach {
namespace {

constexpr std::size_t most_steps = 6;
constexpr double dependent = 1e-8;  // differences of steps that say no more than others are left out

Point3 rotation_vector(const std::array<double, 9>& r) {
  const Point3 twice_sine = {r[7] - r[5], r[2] - r[6], r[3] - r[1]};
  const double sine = length(twice_sine) / 2, angle = std::atan2(sine, (r[0] + r[4] + r[8] - 1) / 2);
  return (sine > 0 ? angle / (2 * sine) : 0.5) * twice_sine;
}

}  // namespace

Twist Anderson::twist_to(const Motion& motion) const {
  const auto &a = motion.rotation, &b = base_.rotation;
  std::array<double, 9> turned{};  // a bᵀ
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      turned[3 * i + j] = a[3 * i] * b[3 * j] + a[3 * i + 1] * b[3 * j + 1] + a[3 * i + 2] * b[3 * j + 2];
  const Point3 turn = radius_ * rotation_vector(turned), shift = motion.apply(base_.undo(centre_)) - centre_;
  return {turn.x, turn.y, turn.z, shift.x, shift.y, shift.z, radius_ * std::log(motion.scale / base_.scale)};
}

Motion Anderson::next(const Motion& from, const Motion& to) {
  Step step{twist_to(to), {}};
  const Twist begin = twist_to(from);
  for (std::size_t i = 0; i < 7; ++i) step.length[i] = step.to[i] - begin[i];
  steps_.push_back(step);
  if (steps_.size() > most_steps) steps_.erase(steps_.begin());
  const std::size_t n = steps_.size() - 1;
  if (n == 0) return to;
  Eigen::MatrixXd changes(7, static_cast<Eigen::Index>(n));
  Eigen::VectorXd last(7);
  for (std::size_t i = 0; i < 7; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    last(row) = step.length[i];
    for (std::size_t k = 0; k < n; ++k)
      changes(row, static_cast<Eigen::Index>(k)) = steps_[k + 1].length[i] - steps_[k].length[i];
  }
  const Eigen::VectorXd shares = least_norm(changes, last, dependent);
  Twist place = step.to;
  for (std::size_t i = 0; i < 7; ++i)
    for (std::size_t k = 0; k < n; ++k)
      place[i] -= shares(static_cast<Eigen::Index>(k)) * (steps_[k + 1].to[i] - steps_[k].to[i]);
  for (const std::size_t i : {0u, 1u, 2u, 6u}) place[i] /= radius_;
  return moved(base_, place, centre_);
}

}  // namespace isopach
