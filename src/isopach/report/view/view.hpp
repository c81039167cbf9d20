// The view of a page: a surface that people turn, read and cut, carried in the page with the script that shows it.
// Where scripts or WebGL are missing the page stays as it is without.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/compare/comparison.hpp"
#include "isopach/report/report.hpp"

namespace isopach {

/// A surface to be looked at: both heights of a comparison and their difference.
struct ViewScene {
  std::string label;  ///< "" where there is one scene alone
  const Comparison* comparison;
};

struct ViewWords {
  std::string a = "A", b = "B";  ///< names of the two surfaces, in buttons
  std::string above = "B above A", below = "B below A";
  bool places = true;   ///< whether coordinates of the frame lead back to those of the input
  std::string command;  ///< of exact volumes in a polygon; empty: there is none
};

/// How large it may become.
struct ViewLimits {
  std::optional<std::size_t> vertices;  ///< of all scenes together, 0: no view; default: what page_budget has room for
  std::size_t page_bytes = 0;           ///< of the page without it, the same in every run
};
inline constexpr std::size_t page_budget = 5'000'000;          ///< bytes
inline constexpr std::size_t default_view_vertices = 200'000;  ///< at most, where none are asked for

/// What stands where the view is to appear.
inline constexpr const char* view_place = "<div id=\"view\"></div>\n";

/// The data and the script, for the end of a page. All scenes show the same colours, those of the widest range. Empty
/// where no scene has a triangle, and where limits.vertices is 0.
[[nodiscard]] std::string view_of(const std::vector<ViewScene>& scenes, const ViewWords& words, const MapOptions& look,
                                  const ViewLimits& limits, const Context& context);

/// The page's data. No markup can be read out of it: a parser ends a script at its end tag alone, which begins with
/// "<".
[[nodiscard]] std::string view_element(const std::string& json);
[[nodiscard]] std::string view_script_element();

/// What Content-Security-Policy has to allow for it: the digest of the script, and no other script.
[[nodiscard]] std::string view_policy();

}  // namespace isopach
