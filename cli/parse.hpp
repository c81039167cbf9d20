// Values of options as text: directions, boxes, classes, poses, tolerances. Each error is one line naming the option.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "isopach/compare/comparison.hpp"

namespace isopach::cli {

/// One finite number, or nothing where the text is none.
[[nodiscard]] std::optional<double> as_number(const std::string& text);
/// One finite number; `what` names it in the error.
[[nodiscard]] double parse_number(const std::string& text, const std::string& what);
/// A line of two places or more: "x,y;x,y…", or a file of GeoJSON (its first line) or of two numbers a line. UsageError
/// naming `option` for words, InputError naming the file.
[[nodiscard]] std::vector<Point2> read_line(const std::string& text, const std::string& option);
/// x | y | z | fit | X,Y,Z
[[nodiscard]] Direction parse_direction(const std::string& text);
/// 2 or 2,8
[[nodiscard]] std::vector<int> parse_classes(const std::string& text);
/// xmin,ymin,xmax,ymax
[[nodiscard]] std::optional<Box2> parse_crop(const std::string& text);
/// xmin,ymin,xmax,ymax
[[nodiscard]] std::optional<Box2> parse_extent(const std::string& text);
/// A name of a unit of length.
[[nodiscard]] std::string parse_unit(const std::string& text);
/// S | @attribute | FILE (a raster); `option` names it in the error.
[[nodiscard]] SigmaSource parse_sigma(const std::string& text, const std::string& option);
/// @attribute | @a:attribute | @b:attribute | FILE (a raster) | a formula.
[[nodiscard]] WeightSource parse_weight(const std::string& text);
/// A file of four lines of four numbers (or sixteen in any lines), row-major, last row 0 0 0 1. InputError names the
/// file; `option` is the one that asked for it.
[[nodiscard]] Pose read_pose(const std::string& path, const std::string& option = "--pose");

/// --fail-above: a statistic and the most it may be.
struct Tolerance {
  std::string statistic;
  double limit = 0;
};
/// p95=0.05[,max=0.2]
[[nodiscard]] std::vector<Tolerance> parse_tolerances(const std::string& text);
/// Levels of percentiles among them that a comparison computes on demand alone.
[[nodiscard]] std::vector<double> percentiles_of(const std::vector<Tolerance>& tolerances);
/// Names that --fail-above knows, "a, b, c".
[[nodiscard]] std::string statistic_names();
/// Throws UsageError for a statistic that a comparison with these options will not have.
void check_tolerances(const std::vector<Tolerance>& tolerances, const CompareOptions& options);
/// One line for all tolerances that are exceeded; empty if none is.
[[nodiscard]] std::string exceeded(const Comparison& comparison, const std::vector<Tolerance>& tolerances);

}  // namespace isopach::cli
