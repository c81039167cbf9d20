// localise_in_order: the localisation without a tree, each node from where the one before it on the curve was found.
#pragma once
#include <span>

#include "isopach/base/context.hpp"
#include "isopach/delaunay/triangulation.hpp"
#include "isopach/overlay/location.hpp"

namespace isopach {

/// The answers of `localise` for points in curve order. Expected O(n) for uniform nodes, quadratic on constructed
/// inputs, as along the tree. Degenerate: as localise. Oracle: localise, tests/overlay/localise_by_interface_test.cpp.
[[nodiscard]] Locations localise_in_order(std::span<const Point2> points, const Triangulation& t,
                                          std::span<const Point2> xy, const Context& context);

}  // namespace isopach
