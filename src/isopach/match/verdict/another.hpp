// What counts as another pose, wherever poses are told apart.
#pragma once
#include "isopach/match/verdict/verdict.hpp"

namespace isopach {

/// Whether `to` lies farther from `from` than other_turn, or than other_shift of the extent at `middle`, the middle of
/// MOVING.
[[nodiscard]] inline bool is_another(const Pose& from, const Pose& to, const Point3& middle, double extent) {
  const Rival r = apart(from, to, middle);
  return r.degrees > other_turn || r.shift > other_shift * extent;
}

}  // namespace isopach
