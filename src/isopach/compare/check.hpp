// check: what is wrong with the options of a comparison is said before any work.
#pragma once
#include "isopach/compare/options.hpp"

namespace isopach {

/// UsageError, naming the option, where options contradict one another or mean nothing (InputError for a covariance
/// that is none). compare() does it first; callers with other work before it, such as a matching, do it before that.
void check(const CompareOptions& options);

}  // namespace isopach
