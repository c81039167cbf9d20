// render_map: the picture of difference.png, before it is a file.
#pragma once
#include <array>
#include <memory>
#include <optional>
#include <string>

#include "isopach/report/draw/canvas.hpp"
#include "isopach/report/report.hpp"

namespace isopach {

/// Limits ±L of the colours, rounded up to 2 significant digits: the 99th percentile of |d| by area, or the largest |d|
/// where that is at most 1.6 times as much or the percentile is 0 (a small part differs); 1 where nothing differs
/// beyond rounding. At least 1.5 times the level of detection, below which the map is grey: else twice that level.
[[nodiscard]] double colour_limit(const Comparison& c);

/// The same, or what the options say.
[[nodiscard]] double colour_limit(const Comparison& c, const MapOptions& look);

/// Of |d| up to the level of detection.
inline constexpr Rgb noise_colour{0.77, 0.77, 0.77};

/// Whether d is 0 everywhere, up to the rounding of the coordinates.
[[nodiscard]] bool shows_no_difference(const Comparison& c);

/// What a map shows and how far its colours reach, where that is not chosen by its own differences.
struct MapScale {
  double colour_limit = 0;  ///< 0: colour_limit(c)
  std::optional<Box2> box;  ///< frame coordinates; default: the domain and its surroundings
  double words = 1;         ///< size of words and of what stands around the map
  bool bare = false;        ///< without title, numbers and logo: these stand beside it
};

/// Of two maps that show the same place in the same colours, those of the wider range: of a comparison before and one
/// after a motion. Where one is missing, or their frames are turned against each other, each has its own place.
[[nodiscard]] std::array<MapScale, 2> paired_scales(const std::optional<Comparison>& before,
                                                    const std::optional<Comparison>& after);

/// The line of a map that says what was compared.
[[nodiscard]] std::string where_compared(const Comparison& c);

/// A map that is drawn by any pen, in units of options.width.
class MapDrawing {
 public:
  MapDrawing(const Comparison& c, const MapOptions& options, const MapScale& scale);
  ~MapDrawing();
  MapDrawing(const MapDrawing&) = delete;
  MapDrawing& operator=(const MapDrawing&) = delete;
  [[nodiscard]] int height() const;
  void draw(Pen& pen);

 private:
  class Map;
  std::unique_ptr<Map> map_;
};

/// Widest SVG, whose surface is a picture: wider ones are drawn so wide.
inline constexpr int widest_svg = 2400;

/// Errors: UsageError for an unknown palette, for a width outside 300 … 20000, for an extent that shows nothing of the
/// scans or in another direction than z.
[[nodiscard]] Image render_map(const Comparison& c, const MapOptions& options, const Context& context,
                               const MapScale& scale = {});

}  // namespace isopach
