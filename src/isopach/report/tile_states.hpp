// Tiles of a job as a layer for maps: where they lie, and what is done.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "isopach/field/height_field.hpp"

namespace isopach {

struct TileState {
  Box2 square;  ///< in the frame of the pair
  std::size_t index = 0;
  std::string state;  ///< done, failed, missing
  std::uint64_t points_a = 0, points_b = 0;
  std::optional<double> seconds;            ///< of its run; nothing where it is not known
  std::optional<std::uint64_t> peak_bytes;  ///< largest memory of its run
  std::string why;                          ///< of a failure
};

/// A polygon a tile in input coordinates, with what is known of it; null for what is not. For frames along z. Style:
/// tile_states_style of vector_styles.hpp. Test: tests/cli/tile_status_test.py.
[[nodiscard]] std::string tile_states_geojson(std::span<const TileState> tiles, const Frame& frame,
                                              const std::string& crs);

}  // namespace isopach
