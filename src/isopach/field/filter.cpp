#include "isopach/field/filter.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "isopach/base/error.hpp"

namespace isopach {

Filter::Filter(const CloudView& cloud, const Pose& pose, const ProjectOptions& options)
    : cloud_(cloud), pose_(pose), options_(options) {
  if (options.classes.empty()) return;
  const AttributeView* attribute = cloud.find_attribute("classification");
  if (attribute == nullptr)
    throw InputError(
        fmt::format("{}: points have no classification; leave the class option out for this file", cloud_name(cloud)));
  classes_ = attribute->values;
}

Filter::Fate Filter::fate_by_options(std::size_t i, const Point3& p) const {
  if (classes_) {
    const double value = (*classes_)[i];
    const auto& wanted = options_.classes;
    if (std::none_of(wanted.begin(), wanted.end(), [&](int c) { return c == value; })) return Fate::wrong_class;
  }
  if (options_.crop) {
    const Box2& box = *options_.crop;
    if (!(box.min.x <= p.x && p.x <= box.max.x && box.min.y <= p.y && p.y <= box.max.y)) return Fate::cropped;
  }
  return Fate::kept;
}

Cleaning count_dropped(const Filter& filter) {
  return reduce_blocks<Cleaning>(
      filter.size(), default_block,
      [&](std::size_t begin, std::size_t end) {
        Cleaning part;
        part.points = end - begin;
        for (std::size_t i = begin; i < end; ++i) {
          const Filter::Fate fate = filter.fate(i, filter.posed(i));
          part.dropped_nonfinite += fate == Filter::Fate::nonfinite;
          part.dropped_class += fate == Filter::Fate::wrong_class;
          part.dropped_crop += fate == Filter::Fate::cropped;
        }
        return part;
      },
      [](Cleaning& total, const Cleaning& part) {
        total.points += part.points;
        total.dropped_nonfinite += part.dropped_nonfinite;
        total.dropped_class += part.dropped_class;
        total.dropped_crop += part.dropped_crop;
      });
}

std::size_t count_kept(const Cleaning& c) { return c.points - c.dropped_nonfinite - c.dropped_class - c.dropped_crop; }

void require_points(const CloudView& cloud, const Cleaning& c) {
  if (count_kept(c) > 0) return;
  throw InputError(fmt::format(
      "{}: no point is left of {} (dropped: {} not finite, {} by class, {} by crop); check the file, class and crop",
      cloud_name(cloud), c.points, c.dropped_nonfinite, c.dropped_class, c.dropped_crop));
}

std::size_t counts_to_places(std::vector<std::size_t>& counts) {
  std::size_t total = 0;
  for (std::size_t& count : counts) total += std::exchange(count, total);
  return total;
}

Kept keep_points(const Filter& filter, const Frame& frame, const Cleaning& cleaning) {
  const std::size_t n = filter.size(), kept = count_kept(cleaning);
  check_size(filter.cloud(), n, static_cast<std::size_t>(no_index) - 1, "points");
  const auto is_kept = [&](std::size_t i) {
    return kept == n || filter.fate(i, filter.posed(i)) == Filter::Fate::kept;
  };
  std::vector<std::size_t> place(block_count(n));
  for_blocks(n, default_block, [&](std::size_t begin, std::size_t end) {
    std::size_t count = kept == n ? end - begin : 0;
    if (kept < n)
      for (std::size_t i = begin; i < end; ++i) count += is_kept(i);
    place[begin / default_block] = count;
  });
  counts_to_places(place);
  Kept result;
  result.xy.resize(kept);
  if (kept < n) result.ids.resize(kept);
  for_blocks(n, default_block, [&](std::size_t begin, std::size_t end) {
    std::size_t k = place[begin / default_block];
    for (std::size_t i = begin; i < end; ++i) {
      if (!is_kept(i)) continue;
      const Point3 q = frame.to_field(filter.posed(i));
      result.xy[k] = {q.x, q.y};
      if (kept < n) result.ids[k] = static_cast<Index>(i);
      ++k;
    }
  });
  return result;
}

void check_size(const CloudView& cloud, std::size_t count, std::size_t most, const char* what) {
  if (count > most)
    throw InputError(
        fmt::format("{}: {} {}, this build holds {}; crop or tile the comparison, or build with 64-bit indices",
                    cloud_name(cloud), count, what, most));
}

}  // namespace isopach
