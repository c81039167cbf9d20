// Filter: which points of a cloud take part, decided alike by choose_frame, project and layered_share. Internal to
// field/.
#pragma once
#include <cstddef>
#include <string>

#include "isopach/base/parallel.hpp"
#include "isopach/cloud/cloud.hpp"
#include "isopach/field/height_field.hpp"
#include "isopach/geom/rigid.hpp"

namespace isopach {

class Filter {
 public:
  enum class Fate { kept, nonfinite, wrong_class, cropped };

  /// The arguments are kept by reference. Throws InputError if classes are asked for and the cloud has none.
  Filter(const Cloud& cloud, const Pose& pose, const ProjectOptions& options);

  [[nodiscard]] std::size_t size() const { return cloud_.points.size(); }
  [[nodiscard]] const Cloud& cloud() const { return cloud_; }
  [[nodiscard]] Point3 posed(std::size_t i) const { return pose_.apply(cloud_.points[i]); }
  /// What becomes of point i, whose posed(i) is p.
  [[nodiscard]] Fate fate(std::size_t i, const Point3& p) const;

 private:
  const Cloud& cloud_;
  const Pose& pose_;
  const ProjectOptions& options_;
  const Array<double>* classes_ = nullptr;
};

/// "scan.las", or a word for a cloud made in memory: how messages begin.
[[nodiscard]] std::string cloud_name(const Cloud& cloud);

/// Counts points and dropped_*.
[[nodiscard]] Cleaning count_dropped(const Filter& filter);
[[nodiscard]] std::size_t count_kept(const Cleaning& cleaning);
/// Throws InputError, with the reasons, if nothing is kept.
void require_points(const Cloud& cloud, const Cleaning& cleaning);

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
