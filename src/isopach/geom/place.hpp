// Place: where a formula of the user, e.g. a weight, is asked for its value.
#pragma once

namespace isopach {

/// What a formula may name. Coordinates and heights as in the input; slopes are rise over run, of either surface.
struct Place {
  double x = 0, y = 0, z1 = 0, z2 = 0, slope1 = 0, slope2 = 0;
};

}  // namespace isopach
