// Diverging palettes: white at 0, two hues of equal lightness either side, so that neither sign shouts louder.
// Control points are ours, in OKLab [Ottosson2020].
#pragma once
#include <string>
#include <vector>

#include "isopach/base/array.hpp"

namespace isopach {

struct Rgb {
  double r, g, b;  ///< sRGB, 0 … 1
};

/// Lightness in OKLab, 0 … 1.
[[nodiscard]] double lightness(const Rgb& colour);

class Palette {
 public:
  /// `flip` swaps the two ends. Errors: UsageError for an unknown name (lists the known ones).
  Palette(const std::string& name, bool flip);
  /// Colour of t in [−1, 1] (clamped); white at 0. Positive t has the hue named first.
  [[nodiscard]] const Rgb& operator()(double t) const;

 private:
  Array<Rgb> table_;
};

/// Whether the default is to paint d > 0 with the second hue ("red = excess", as metrology does in millimetres) and not
/// with the first ("blue = gained, red = lost", as geomorphology does in metres and feet).
[[nodiscard]] bool paints_excess_red(const std::string& unit);

}  // namespace isopach
