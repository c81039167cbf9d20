// How a pose moves a scan, in words: what a matched comparison says first.
#pragma once
#include <string>

#include "isopach/match/matching.hpp"
#include "isopach/report/page/words.hpp"

namespace isopach {

/// Shift of the middle of the moving scan, turn with its axis.
struct Moved {
  Point3 shift{0, 0, 0};
  double degrees = 0;
  Point3 axis{0, 0, 1};  ///< of the turn, length 1, right-handed; (0, 0, 1) where there is none
};
[[nodiscard]] Moved moved_by(const Matching& m);

/// Whether the precision of the pose says something: the pose is trusted, or the user takes it.
[[nodiscard]] bool precision_is_told(const Matching& m);

/// "B was moved by 1.2 mm and turned by 2.1°".
[[nodiscard]] std::string moved_briefly(const Matching& m, const std::string& subject, Typography typography);

/// "B was moved by 1.2 mm (+0.5, -1, +0.3) and turned by 2.1 degrees about (0, 0, 1), fitted on 92 % of the common
/// area; one standard deviation 0.01, 0.01, 0.004 mm and ... degrees". One line, without a full stop. `subject`: "B".
[[nodiscard]] std::string moved_sentence(const Matching& m, const std::string& subject, Typography typography);

}  // namespace isopach
