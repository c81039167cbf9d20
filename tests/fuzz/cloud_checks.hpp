// What holds of every cloud that a reader hands out.
#pragma once
#include "isopach/cloud/cloud.hpp"
#include "tests/fuzz/input.hpp"

namespace isopach::fuzz {

inline void require_consistent(const Cloud& cloud) {
  require(!cloud.points.empty(), "a cloud has points");
  for (const Attribute& a : cloud.attributes)
    require(a.values.size() == cloud.points.size(), "an attribute has a value for every point");
  for (const auto& face : cloud.faces)
    for (const Index corner : face) require(corner < cloud.points.size(), "a corner of a face is a point");
}

}  // namespace isopach::fuzz
