// Filter: which points of a cloud take part, decided alike by choose_frame, project and layered_share. Internal to
// field/.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "isopach/base/parallel.hpp"
#include "isopach/cloud/cloud_view.hpp"
#include "isopach/field/height_field.hpp"
#include "isopach/geom/rigid.hpp"

namespace isopach {

class Filter {
 public:
  enum class Fate { kept, nonfinite, wrong_class, cropped };

  /// `pose` and `options` are kept by reference. Throws InputError if classes are asked for and the cloud has none.
  Filter(const CloudView& cloud, const Pose& pose, const ProjectOptions& options);

  [[nodiscard]] std::size_t size() const { return cloud_.points.size(); }
  [[nodiscard]] const CloudView& cloud() const { return cloud_; }
  [[nodiscard]] Point3 posed(std::size_t i) const { return pose_.apply(cloud_.points[i]); }
  /// What becomes of point i, whose posed(i) is p.
  [[nodiscard]] Fate fate(std::size_t i, const Point3& p) const {
    if (!is_finite(p)) return Fate::nonfinite;
    return !classes_ && !options_.crop ? Fate::kept : fate_by_options(i, p);
  }

 private:
  [[nodiscard]] Fate fate_by_options(std::size_t i, const Point3& p) const;

  CloudView cloud_;
  const Pose& pose_;
  const ProjectOptions& options_;
  std::optional<ValuesView> classes_;  ///< if some of them are asked for
};

/// Counts points and dropped_*.
[[nodiscard]] Cleaning count_dropped(const Filter& filter);
[[nodiscard]] std::size_t count_kept(const Cleaning& cleaning);
/// Throws InputError, with the reasons, if nothing is kept.
void require_points(const CloudView& cloud, const Cleaning& cleaning);

/// The kept points in the plane, and which points they are.
struct Kept {
  Array<Point2> xy;
  Array<Index> ids;  ///< empty if all points are kept
  [[nodiscard]] Index point(std::size_t i) const { return ids.empty() ? static_cast<Index>(i) : ids[i]; }
};

/// `cleaning` comes from count_dropped(filter). Throws InputError if there are more points than indices.
[[nodiscard]] Kept keep_points(const Filter& filter, const Frame& frame, const Cleaning& cleaning);

/// From the count of each block to the place where the block begins; returns the total.
std::size_t counts_to_places(std::vector<std::size_t>& counts);
[[nodiscard]] inline std::size_t block_count(std::size_t n) { return (n + default_block - 1) / default_block; }
/// Throws InputError if this build cannot hold so many ("points", ...).
void check_size(const CloudView& cloud, std::size_t count, std::size_t most, const char* what);

/// add(T&, posed point) over the kept points of each block, then combine(T&, const T&) in block order.
template <class T, class Add, class Combine>
[[nodiscard]] T reduce_kept(const Filter& filter, Add&& add, Combine&& combine) {
  return reduce_blocks<T>(
      filter.size(), default_block,
      [&](std::size_t begin, std::size_t end) {
        T part{};
        for (std::size_t i = begin; i < end; ++i) {
          const Point3 p = filter.posed(i);
          if (filter.fate(i, p) == Filter::Fate::kept) add(part, p);
        }
        return part;
      },
      combine);
}

}  // namespace isopach
