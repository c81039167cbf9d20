#include "isopach/apps/symmetry_start.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "isopach/base/error.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/match/match.hpp"

namespace isopach {

CompareOptions upright_options(const CompareOptions& given) {
  CompareOptions o = given;
  o.project = {};
  o.project.duplicates = given.project.duplicates;
  o.pose = {};
  return o;
}

MatchOptions mirror_match_options(const AsymmetryOptions& o, bool plane_only) {
  MatchOptions m;
  m.check_pose = false;  // of a face on its mirror image: other places of the face are no answer
  m.judge = false;
  m.compare = upright_options(o.compare);
  m.compare.check_layers = false;
  m.overlap = o.overlap;
  m.max_iterations = o.max_iterations;
  if (plane_only) m.freedom = {true, false, false, false, true, true, false};
  return m;
}

Context without_progress(const Context& context) {
  Context silent = context;
  silent.progress = nullptr;
  return silent;
}

namespace {

constexpr double far_more_symmetric = 0.5;  // of the spread: less
constexpr double least_coverage = 0.3;      // of both areas: a start with less says nothing of symmetry

/// A start that was tried: the plane it led to, and how the thinned face differs from its mirror image there.
struct Trial {
  Upright place;
  struct Cell {
    double area, most;  // largest |d|
  };
  std::vector<Cell> cells;
  double spread = 0, coverage = 0;

  [[nodiscard]] double symmetric_area(double within) const {
    double area = 0;
    for (const Cell& c : cells) area += c.most <= within ? c.area : 0;
    return area;
  }
};

Trial tried(const Array<Point3>& thin, const Upright& start, const Point3& towards, const AsymmetryOptions& o,
            const Context& context) {
  MatchOptions options = mirror_match_options(o, true);
  options.max_iterations = std::min(o.max_iterations, 30);
  options.compare.border = BorderRule::hull;
  options.compare.max_edge = 0;
  const Cloud before = placed(thin, start);
  Trial trial;
  trial.place = start.after(reflection_of(match(mirrored(before), before, options, context).pose), towards);
  const Cloud after = placed(thin, trial.place);
  const Comparison c = compare(mirrored(after), after, options.compare, context);
  const CellView cells = c.cells.view();
  for_cells(cells, 0, items_of(cells), [&](const Cell& cell) {
    trial.cells.push_back({cell.area, std::max({std::fabs(cell.d[0]), std::fabs(cell.d[1]), std::fabs(cell.d[2])})});
  });
  trial.spread = c.measures.difference.nmad;
  trial.coverage = c.coverage;
  return trial;
}

/// Turns and shifts of the plane through the middle of the scan.
std::vector<Upright> starts_about(const Upright& middle, const Array<Point3>& thin) {
  Box3 box;
  for (const Point3& p : thin) box.add(middle.apply(p));
  const double width = box.max.x - box.min.x;
  std::vector<Upright> starts;
  for (const double roll : {0.0, 12.0, -12.0})
    for (const double turn : {0.0, 20.0, -20.0})
      for (const double shift : {0.0, 0.15, -0.15})
        starts.push_back(middle.turned_and_shifted(roll, turn, shift * width));
  return starts;
}

/// Those of the planes found in space whose normals lie near the direction across.
std::vector<Upright> starts_at(const std::vector<MirrorPlane>& planes, const Upright& middle, const Point3& across,
                               const Frame& frame) {
  std::vector<Upright> starts;
  for (const MirrorPlane& plane : planes) {
    Reflection reflection;
    reflection.normal = in_view(plane.normal, frame);
    reflection.offset = plane.offset - dot(plane.normal, frame.origin);
    if (std::fabs(dot(reflection.normal, middle.axis(0))) >= least_across)
      starts.push_back(Upright{}.after(reflection, across));
  }
  return starts;
}

/// Where the largest area is symmetric within the noise of the best; null without trials.
const Trial* best_of(const std::vector<Trial>& trials) {
  double noise = std::numeric_limits<double>::infinity();
  for (const Trial& t : trials)
    if (t.coverage >= least_coverage) noise = std::min(noise, t.spread);
  const Trial* best = nullptr;
  for (const Trial& t : trials)
    if (best == nullptr || (std::isfinite(noise) && t.symmetric_area(3 * noise) > best->symmetric_area(3 * noise)))
      best = &t;
  return best;
}

}  // namespace

Upright symmetry_start(const Array<Point3>& thin, const Frame& frame, const Point3& across,
                       const std::vector<MirrorPlane>& planes, const AsymmetryOptions& o, const Context& context) {
  const Context silent = without_progress(context);
  const Upright middle = upright_through_middle(thin, across);
  const std::vector<Upright> near = starts_about(middle, thin), in_space = starts_at(planes, middle, across, frame);
  std::size_t done = 0;
  std::string failure;
  const auto trials_from = [&](const std::vector<Upright>& starts) {
    std::vector<Trial> trials;
    for (const Upright& start : starts) {
      context.step("start", static_cast<double>(done++) / static_cast<double>(near.size() + in_space.size()));
      try {
        trials.push_back(tried(thin, start, across, o, silent));
      } catch (const OverlapError& error) {
        failure = error.what();
      }
    }
    return trials;
  };
  const std::vector<Trial> of_near = trials_from(near), of_space = trials_from(in_space);
  const Trial *best = best_of(of_near), *other = best_of(of_space);
  if (best == nullptr && other == nullptr)
    throw OverlapError("no part of the face lies over its mirror image: " + failure);
  const bool astray = best == nullptr || (other != nullptr && other->coverage >= least_coverage &&
                                          other->spread < far_more_symmetric * best->spread);
  return astray ? other->place : best->place;
}

}  // namespace isopach
