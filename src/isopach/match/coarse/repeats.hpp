// Repeats: motions that bring a scan onto itself elsewhere, as they do the teeth of a cog or the waves of a roof. A
// pose on such a scan has rivals that look as good.
#pragma once
#include <vector>

#include "isopach/match/motion.hpp"
#include "isopach/match/verdict/judged_scan.hpp"

namespace isopach {

inline constexpr std::size_t most_repeats = 4;  ///< of each of the two searches

/// Motions about the origin of the scan, other than none (other_turn, other_shift of match/verdict/verdict.hpp), after
/// which most of what comes to lie on the scan fits within its noise: at most 2 · most_repeats, no two alike, the best
/// first. Two searches: motions on which landmarks agree that look alike and lie apart, for turns and far shifts; and
/// peaks of the autocorrelation of the heights over the plane through the scan, for short shifts. Each is refined by
/// steps of ICP of the scan on itself. Missed are shifts by less than 6 % of the extent and turns of fewer than some
/// hundred points. None for a scan that is not usable(). Cost: 35 ms on one core, whatever the size of the scan.
/// Deterministic. Test: tests/match/repeats_test.cpp, on surfaces with known repeats and on such without.
[[nodiscard]] std::vector<Motion> repeats(const JudgedScan& scan, const Context& context);

}  // namespace isopach
