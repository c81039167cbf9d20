// OBJ (Wavefront): "v x y z [w] [red green blue]" and "f" lines, whose indices may be negative (counted back) and whose
// polygons are fanned; lines may go on after a "\". All else (textures, normals, groups, materials, curves) is ignored.
// w, the weight of a rational curve, is ignored too. Vertex colours become the attributes red, green, blue; NaN where a
// vertex has none. InputError: no vertices, a "v" line that is not numbers, a face that names no vertex (with the
// line). Cost: one pass. Oracle test: ObjTest.RoundTrip*.
#pragma once
#include <span>
#include <string>

#include "isopach/io/read.hpp"

namespace isopach {

[[nodiscard]] Cloud parse_obj(std::span<const char> bytes, const std::string& name, const ReadOptions& options,
                              const Context& context);

/// True if the first line that is neither blank nor a comment is one of an OBJ file.
[[nodiscard]] bool is_obj(std::span<const char> head);

}  // namespace isopach
