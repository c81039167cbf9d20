// changes: the significant part of a difference as objects (docs/use/changes.md). A level L(x, y) ≥ 0, linear on each
// cell of T, parts the domain as in detection.hpp; an object is a connected part of {d > L}, gained, or of {−d > L},
// lost. Every cell is cut along its level line, so the objects' volumes add up to what detect() finds.
//
// Connected. Within a cell the part beyond the level is convex. Two cells are joined over the side they share where d
// exceeds the level at an end of it: then their parts share a stretch of the side; where it only reaches the level they
// touch in a line or a point, and are not joined. d and L are compared as they are at the nodes, so every decision is
// exact. Pieces of a triangle that the domain cuts count as one, joined to their neighbours by the nodes of the
// triangle: a cut that is narrower than the triangles does not part an object.
#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "isopach/measure/changes/outlines.hpp"
#include "isopach/measure/source.hpp"
#include "isopach/measure/uncertainty/detection.hpp"

namespace isopach {

/// What is asked of the objects.
struct ChangeOptions {
  bool asked = false;
  double height = 0;               ///< > 0: the level, unit of heights; 0: the level of detection
  double min_volume = 0;           ///< objects below it are not told one by one
  std::optional<double> min_area;  ///< likewise; default: what ten points of the sparser scan cover
};

/// A level at the nodes of T.
class ChangeLevel {
 public:
  explicit ChangeLevel(double everywhere) : everywhere_(everywhere) {}
  explicit ChangeLevel(std::span<const double> of_node) : of_node_(of_node) {}

  [[nodiscard]] double at(Index node) const { return of_node_.empty() ? everywhere_ : of_node_[node]; }
  [[nodiscard]] std::array<double, 3> at_corners(const CommonCell& cell) const {
    if (!of_node_.empty()) return cell.at_corners(of_node_);
    return {everywhere_, everywhere_, everywhere_};
  }

 private:
  double everywhere_ = 0;
  std::span<const double> of_node_;
};

/// One object. Frame coordinates.
struct Change {
  bool gained = true;
  double volume = 0;  ///< ∫ |d|
  double area = 0, mean = 0;
  double largest = 0;  ///< |d|
  Point2 largest_at{0, 0}, centroid{0, 0};
  std::optional<double> sigma;            ///< standard deviation of the volume, the outline taken as it is
  std::array<std::size_t, 2> points{};    ///< of each scan inside
  std::vector<PolygonWithHoles> outline;  ///< several where the domain parts what the triangles join

  [[nodiscard]] double net() const { return gained ? volume : -volume; }
  [[nodiscard]] double mean_d() const { return gained ? mean : -mean; }
  [[nodiscard]] double largest_d() const { return gained ? largest : -largest; }
};

/// All objects of a difference.
struct Changes {
  std::vector<Change> list;  ///< those told one by one, the largest volume first
  Detected all;              ///< sums over all objects: what detect() gives
  struct Small {
    std::size_t gained = 0, lost = 0;  ///< how many there are
    Detected sum;
  } small;              ///< those below the smallest size
  double level = 0;     ///< the height that was asked for; 0: the level of detection
  double min_area = 0;  ///< in force
};

/// The same with what each object consists of, so that more can be found of it.
struct FoundChanges {
  Changes changes;
  /// By item of the cells and sign (0: gained): the number of its object in changes.list, or no_index.
  std::array<std::vector<Index>, 2> object_of;
};

/// Objects with all but sigma and points. Exact sums (base/fixed_sum.hpp): the same bits for any order of the input.
/// `min_area`: of those told one by one, beside options.min_volume. Cost O(cells), and O(n log n) in the corners of
/// outlines. Oracle: tests/measure/changes_test.cpp (union-find over all pairs of pieces).
[[nodiscard]] FoundChanges find_changes(const CellView& cells, const ChangeLevel& level, const ChangeOptions& options,
                                        double min_area, const Context& context);

/// The same of cells that are a part of a whole, all beside which d exceeds the level among them: `reach` is the
/// largest coordinate of its nodes, without the sign.
[[nodiscard]] FoundChanges find_changes(const CellView& cells, const ChangeLevel& level, const ChangeOptions& options,
                                        double min_area, double reach, const Context& context);

/// The largest coordinate of some nodes, without the sign.
[[nodiscard]] double reach_of(std::span<const Point2> xy);

}  // namespace isopach
