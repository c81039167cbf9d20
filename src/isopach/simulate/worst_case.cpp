// The worst case of localisation along the spanning tree: the tree of the first scan crosses the strip |y| < 0.1 once
// per edge, and there the second triangulation has one long edge per node. Points_a times points_b crossings.
//
// Source: [Dyshkant2013], section 4: quadratic on constructed inputs; the construction is ours.
#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/simulate/model.hpp"

namespace isopach {
namespace {

constexpr double pitch = 0.8, amplitude = 0.5;  // of the zigzag
constexpr double strip = 0.1;                   // half-height of the columns
constexpr double lift = 1;

double zigzag_x(std::size_t i, std::size_t count) {
  return pitch * (static_cast<double>(i) - 0.5 * static_cast<double>(count - 1));
}

/// Nodes of a zigzag that runs from below to above and so on; consecutive ones are nearest neighbours.
Array<Point2> zigzag(std::size_t count) {
  Array<Point2> nodes(count);
  for_each_index(count, [&](std::size_t i) { nodes[i] = {zigzag_x(i, count), i % 2 == 0 ? -amplitude : amplitude}; });
  return nodes;
}

/// Two columns at x = ±far, set off by half a step against each other so that no four nodes are cocircular, and four
/// corners outside every circle through two nodes of one column and one of the other.
Array<Point2> columns(double far, std::size_t count) {
  Array<Point2> nodes(count);
  const double step = 2 * strip / static_cast<double>(count - 4 + 1);
  for_each_index(count, [&](std::size_t i) {
    if (i < 4) {
      nodes[i] = {i % 2 == 0 ? -2 * far : 2 * far, i < 2 ? -2 * far : 2 * far};
      return;
    }
    nodes[i] = {i % 2 == 0 ? -far : far, -strip + step * static_cast<double>(i - 4 + 1)};
  });
  return nodes;
}

double height(int, int epoch, double, double) { return epoch == 1 ? 0 : lift; }

/// The overlap of the hulls: the hull of the zigzag, a trapezium or parallelogram.
Outline hull_of_zigzag(int, const SceneOptions& options) {
  const std::size_t n = options.points_a;
  const std::size_t below = n % 2 == 0 ? n - 2 : n - 1, above = n % 2 == 0 ? n - 1 : n - 2;  // the last ones
  return {{zigzag_x(0, n), -amplitude},
          {zigzag_x(below, n), -amplitude},
          {zigzag_x(above, n), amplitude},
          {zigzag_x(1, n), amplitude}};
}

Truth truth(int, const Outline& footprint) {
  Truth truth;
  truth.area = polygon_area(footprint);
  truth.above = truth.net = truth.area * lift;
  return truth;
}

Array<Point2> nodes(int epoch, const Outline& footprint, std::size_t count, std::uint64_t) {
  return epoch == 1 ? zigzag(count) : columns(10 - footprint[0].x, count);
}

}  // namespace

SceneModel worst_case_scene() {
  SceneModel model;
  model.name = "worst-case";
  model.description = "a zigzag against two far columns: the walk along the spanning tree is quadratic";
  model.unit = "m";
  model.defaults.points_a = model.defaults.points_b = 1000;
  model.height = height;
  model.footprint = hull_of_zigzag;
  model.truth = truth;
  model.nodes = nodes;
  return model;
}

}  // namespace isopach
