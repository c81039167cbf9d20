// The changes as objects that options.changes asks for: what each is, how sure its volume is, how many points it has.
#pragma once
#include <array>

#include "isopach/compare/comparison.hpp"
#include "isopach/compare/noise.hpp"
#include "isopach/overlay/common.hpp"
#include "isopach/overlay/pair.hpp"

namespace isopach::stages {

/// Refuses options that contradict one another or mean nothing, naming them.
void check_changes(const CompareOptions& options);
/// Refuses a direction other than z: outlines are in x and y.
void check_changes(const CompareOptions& options, const Frame& frame);

/// By scan and node how many points it was made of; empty where no changes are asked for.
using PointCounts = std::array<Array<Index>, 2>;
[[nodiscard]] PointCounts points_of_nodes(const Pair& pair, const CompareOptions& options);
/// Of one scan.
[[nodiscard]] Array<Index> points_of_nodes(const HeightField& field);

/// What counts as changed, of a comparison whose cells have their level of detection if it varies.
[[nodiscard]] ChangeLevel change_level(const Comparison& c);
/// The area below which objects are not told one by one.
[[nodiscard]] double least_change_area(const Comparison& c);

/// Into c.changes. After noise.describe. `nodes`: the ids of the nodes of T.
void describe_changes(const UnitedNodes& nodes, const PointCounts& points, const Noise& noise, Comparison& c,
                      const Context& context);

}  // namespace isopach::stages
