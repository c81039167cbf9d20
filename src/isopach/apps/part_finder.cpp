#include "isopach/apps/part_finder.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "isopach/apps/motions.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/distance/vectors.hpp"

namespace isopach {
namespace {

constexpr std::size_t query_block = 256;
constexpr double on_surface = 4;       // standard deviations within which a point lies on the frame
constexpr double least_support = 0.5;  // of a part's points; below it the frame does not show the part
constexpr std::size_t seed_neighbours = 16;
constexpr double seed_majority = 0.6;
constexpr std::size_t region_count = 12;
constexpr double region_share = 1.0 / 6;  // of the model's points: a face has room for some within either part
constexpr std::size_t least_region = 60;
constexpr double better = 1.02;  // so many times more points must lie on the frame for a region's motion to be taken
constexpr int refits = 3;
constexpr double sure = 0.15;  // blends below it and above one less it belong to a part for certain

Point3 middle_of(const OrientedCloud& cloud) {
  Point3 sum{0, 0, 0};
  for (const Point3& p : cloud.points) sum = sum + p;
  return (1 / static_cast<double>(cloud.points.size())) * sum;
}

/// Points of the model that the motion takes to within `width` of the frame's surface.
Array<unsigned char> on_frame(const OrientedCloud& model, const OrientedCloud& frame, const Motion& motion,
                              double width, double reach) {
  Array<unsigned char> on(model.points.size());
  for_blocks(on.size(), query_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      on[i] = surface_distance(frame, motion.apply(model.points[i]), reach) <= width;
  });
  return on;
}

std::size_t count_of(const Array<unsigned char>& flag) {
  return static_cast<std::size_t>(std::count(flag.begin(), flag.end(), 1));
}

}  // namespace

PartFinder::PartFinder(const OrientedCloud& model, double least_share)
    : model_(model),
      least_(
          std::max<std::size_t>(30, static_cast<std::size_t>(least_share * static_cast<double>(model.points.size())))),
      evidence_(model) {
  forget_second();
}

void PartFinder::forget_second() {
  first_ = part_of(model_, Array<unsigned char>(model_.points.size(), 1));
  second_ = OrientedCloud{};
  relative_.reset();
  relative_before_.reset();
  evidence_.clear();
  next_drawing_ = 1;
}

bool PartFinder::add(const OrientedCloud& frame, std::string& reason, const Context& context) {
  std::vector<Motion> others;
  const std::optional<PartFit> still =
      relative_ ? fit_part(first_, frame, std::array{still_}, context) : fit_larger(frame, others, context);
  if (!still || still->support < least_support) {
    reason = not_on_frame(false);
    return false;
  }
  still_ = still->motion;
  const FrameScale scale = frame_scale(first_, frame, *still);
  if (!relative_) {
    look_for_seed(frame, *still, scale, others, context);
  } else {
    std::vector<Motion> starts{composed(still_, *relative_)};
    if (relative_before_)
      starts.push_back(composed(still_, composed(*relative_, composed(inverted(*relative_before_), *relative_))));
    const std::optional<PartFit> moving = fit_part(second_, frame, starts, context);
    if (!moving || moving->support < least_support / 2) {
      reason = not_on_frame(true);
      return false;
    }
    relative_before_ = relative_;
    relative_ = composed(inverted(still_), moving->motion);
  }
  if (!relative_) return true;
  const Motion moving = composed(still_, *relative_);
  evidence_.add(frame, still_, moving, scale.sigma, scale.reach);
  ++frames_;
  const Point3 a = middle_of(first_), b = middle_of(second_);
  travelled_[0] += squared_length(still_.apply(a) - a);
  travelled_[1] += squared_length(moving.apply(b) - b);
  if (evidence_.frames() >= next_drawing_) draw_parts();
  return true;
}

/// Regions about points that lie as far apart as can be (T. Gonzalez 1985).
void PartFinder::make_regions() {
  const std::size_t n = model_.points.size();
  const std::size_t size = std::max(least_region, static_cast<std::size_t>(region_share * static_cast<double>(n)));
  if (n < 2 * size) return;
  Array<double> far(n);
  std::fill(far.begin(), far.end(), std::numeric_limits<double>::infinity());
  std::size_t next = model_.tree->nearest_two(middle_of(model_)).first;
  std::vector<Index> found;
  for (std::size_t k = 0; k < region_count; ++k) {
    const Point3 centre = model_.points[next];
    model_.tree->nearest(centre, size, found);
    Array<unsigned char> flag(n);
    std::fill(flag.begin(), flag.end(), static_cast<unsigned char>(0));
    for (const Index i : found) flag[i] = 1;
    regions_.push_back(part_of(model_, flag));
    for (std::size_t i = 0; i < n; ++i) far[i] = std::min(far[i], squared_length(model_.points[i] - centre));
    next = static_cast<std::size_t>(std::max_element(far.begin(), far.end()) - far.begin());
  }
}

std::optional<PartFit> PartFinder::fit_larger(const OrientedCloud& frame, std::vector<Motion>& others,
                                              const Context& context) {
  std::optional<PartFit> whole = fit_part(first_, frame, std::array{still_}, context);
  if (regions_.empty()) make_regions();
  Array<double> scales;
  for (const OrientedCloud& region : regions_)
    if (const std::optional<PartFit> fit = fit_part(region, frame, std::array{whole ? whole->motion : still_}, context);
        fit && fit->support >= least_support)
      others.push_back(fit->motion), scales.push_back(fit->scale);
  if (scales.empty()) return whole;
  std::sort(scales.begin(), scales.end());
  const double width = on_surface * scales[scales.size() / 4];  // some regions lie across the parts
  const double reach = 3 * std::sqrt(misfit(model_, frame, whole ? whole->motion : others.front()));
  Array<unsigned char> most;
  if (whole) most = on_frame(model_, frame, whole->motion, width, reach);
  const std::size_t of_whole = count_of(most);
  std::size_t best = of_whole;
  for (const Motion& motion : others) {
    Array<unsigned char> on = on_frame(model_, frame, motion, width, reach);
    if (count_of(on) > best) best = count_of(on), most = std::move(on);
  }
  if (whole && static_cast<double>(best) <= better * static_cast<double>(of_whole)) return whole;
  std::optional<PartFit> larger;
  for (int k = 0; k < refits; ++k) {
    const OrientedCloud part = part_of(model_, most);
    larger = fit_part(part, frame, larger ? std::span<const Motion>(&larger->motion, 1) : others, context);
    if (!larger) return whole;
    most = on_frame(model_, frame, larger->motion, width, reach);
    if (count_of(most) < least_) return whole;
  }
  larger->support = static_cast<double>(count_of(most)) / static_cast<double>(model_.points.size());
  return larger;
}

void PartFinder::look_for_seed(const OrientedCloud& frame, const PartFit& still, const FrameScale& scale,
                               const std::vector<Motion>& others, const Context& context) {
  const std::size_t n = model_.points.size();
  Array<unsigned char> off(n), patch(n);
  for_blocks(n, query_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      off[i] = surface_distance(frame, still.motion.apply(model_.points[i]), scale.reach) > on_surface * scale.sigma;
  });
  for_blocks(n, query_block, [&](std::size_t begin, std::size_t end) {
    std::vector<Index> found;
    for (std::size_t i = begin; i < end; ++i) {
      model_.tree->nearest(model_.points[i], seed_neighbours, found);
      const auto many = std::count_if(found.begin(), found.end(), [&](Index k) { return off[k] != 0; });
      patch[i] = static_cast<double>(many) >= seed_majority * static_cast<double>(found.size());
    }
  });
  patch = largest_patch(patch);
  if (static_cast<std::size_t>(std::count(patch.begin(), patch.end(), 1)) < least_) return;
  const OrientedCloud seed = part_of(model_, patch);
  std::vector<Motion> starts{still.motion};
  starts.insert(starts.end(), others.begin(), others.end());
  const std::optional<PartFit> moving = fit_part(seed, frame, starts, context);
  if (!moving || moving->support < least_support ||
      !(misfit(seed, frame, moving->motion) < misfit(seed, frame, still.motion)))
    return;
  Array<unsigned char> rest(n);
  for (std::size_t i = 0; i < n; ++i) rest[i] = off[i] == 0 && patch[i] == 0;
  if (static_cast<std::size_t>(std::count(rest.begin(), rest.end(), 1)) < least_) return;
  set_parts(patch, rest);
  relative_ = composed(inverted(still_), moving->motion);
}

Array<unsigned char> PartFinder::largest_patch(const Array<unsigned char>& flag) const {
  const std::size_t n = flag.size();
  std::vector<Index> parent(n);
  std::iota(parent.begin(), parent.end(), Index{0});
  const auto root = [&](Index i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (std::size_t i = 0; i < n; ++i)
    for (const Index j : evidence_.near(i))
      if (j != no_index && flag[i] != 0 && flag[j] != 0) {
        const Index a = root(static_cast<Index>(i)), b = root(j);
        parent[std::max(a, b)] = std::min(a, b);
      }
  std::vector<std::size_t> size(n, 0);
  for (std::size_t i = 0; i < n; ++i)
    if (flag[i] != 0) ++size[root(static_cast<Index>(i))];
  const auto largest = static_cast<Index>(std::max_element(size.begin(), size.end()) - size.begin());
  Array<unsigned char> result(n);
  for (std::size_t i = 0; i < n; ++i) result[i] = flag[i] != 0 && root(static_cast<Index>(i)) == largest;
  return result;
}

void PartFinder::set_parts(const Array<unsigned char>& second, const Array<unsigned char>& first) {
  first_ = part_of(model_, first);
  second_ = part_of(model_, second);
}

void PartFinder::draw_parts() {
  next_drawing_ = 2 * evidence_.frames();
  const Array<double> field = evidence_.blend();
  Array<unsigned char> first(field.size()), second(field.size());
  for (std::size_t i = 0; i < field.size(); ++i) first[i] = field[i]<sure, second[i] = field[i]> 1 - sure;
  second = largest_patch(second);
  const auto count = [](const Array<unsigned char>& flag) {
    return static_cast<std::size_t>(std::count(flag.begin(), flag.end(), 1));
  };
  if (count(second) < least_ || count(first) < least_) return forget_second();
  set_parts(second, first);
}

Array<double> PartFinder::blend() const { return evidence_.blend(); }

double PartFinder::travel(bool second) const {
  return frames_ == 0 ? 0 : std::sqrt(travelled_[second ? 1 : 0] / static_cast<double>(frames_));
}

}  // namespace isopach
