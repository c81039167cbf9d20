// report.html of `isopach info`.
#pragma once
#include <span>
#include <string>

#include "isopach/base/context.hpp"
#include "isopach/geom/vec.hpp"

namespace isopach {

/// report.html: for each file of `record` (schema isopach.info/1) what was read, with units, and of the first one the
/// heights of its points as a picture and as a view that people turn. `points`: those of the first, input coordinates.
[[nodiscard]] std::string info_html(const std::string& record, std::span<const Point3> points, const Context& context);

}  // namespace isopach
