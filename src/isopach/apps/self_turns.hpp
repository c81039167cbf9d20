// Turns that may take an object onto itself: where a search for other places of it begins.
#pragma once
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/match/motion.hpp"
#include "isopach/match/pairs/oriented.hpp"

namespace isopach {

/// Turns about the middle of the object's surface, the identity not among them, one of which is within about 15 degrees
/// (25 where all are alike) of any turn under which its shape repeats. What repeats has its second moments (by area)
/// repeat: three of different size allow half turns about their axes alone; two alike any turn about the third axis,
/// then a half turn about one across; three alike any turn at all (400 of them, spread by context.seed). Cost
/// O(points). Test: tests/apps/self_turns_test.cpp.
[[nodiscard]] std::vector<Motion> self_turns(const OrientedCloud& object, const Context& context);

}  // namespace isopach
