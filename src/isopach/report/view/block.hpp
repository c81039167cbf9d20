// The surface of a page's view as text: what viewer/src/block.ts reads.
#pragma once
#include <array>
#include <span>
#include <string>

#include "isopach/report/view/thin.hpp"

namespace isopach {

/// The numbers of a surface: x, y, z, d and, if there are any, lod, each as differences along the nodes, then corners
/// of triangles as differences of nodes; signs in the lowest bit; byte planes, the lowest first; zlib; base64.
[[nodiscard]] std::string view_block(const ThinSurface& surface);

/// The same of any columns and triangles.
[[nodiscard]] std::string numbers_block(std::span<const Quantised* const> columns,
                                        std::span<const std::array<Index, 3>> triangles);

}  // namespace isopach
