// STL, ascii (one or several solids) and binary. The corners of the triangles are made unique: those with exactly equal
// coordinates (0 and -0 are equal) become one point, in the order of first appearance.
// InputError: no triangles, a file cut short, a facet without three corners (with the line).
// Cost: one pass and a hash table of the points. Oracle test: StlTest.RoundTrip*.
#pragma once
#include <cstdint>
#include <span>
#include <string>

#include "isopach/io/read.hpp"

namespace isopach {

[[nodiscard]] Cloud parse_stl(std::span<const char> bytes, const std::string& name, const ReadOptions& options,
                              const Context& context);

/// True if the size is that of a binary STL file with the number of triangles it announces, or the text begins as an
/// ascii one. `head`: the first bytes of `size` in all.
[[nodiscard]] bool is_stl(std::span<const char> head, std::uint64_t size);

}  // namespace isopach
