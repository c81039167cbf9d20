// CloudView: a cloud whose arrays belong to somebody else: to a Cloud, or to the caller's own library. All that reads a
// cloud takes one of these, so that nobody has to copy points to have them compared.
#pragma once
#include <array>
#include <compare>
#include <cstddef>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "isopach/base/array.hpp"
#include "isopach/base/types.hpp"
#include "isopach/cloud/cloud.hpp"
#include "isopach/geom/vec.hpp"

namespace isopach {

/// Goes over a view whose elements are made as they are asked for; valid as long as the array is, without the view.
template <class View>
class ViewIterator {
 public:
  using value_type = typename View::value_type;
  using reference = value_type;
  using pointer = void;
  using difference_type = std::ptrdiff_t;
  using iterator_concept = std::random_access_iterator_tag;
  using iterator_category = std::input_iterator_tag;  // before C++20 an iterator had to refer to an element

  ViewIterator() = default;
  ViewIterator(const View& view, difference_type at) : view_(view), at_(at) {}

  [[nodiscard]] value_type operator*() const { return view_[static_cast<std::size_t>(at_)]; }
  [[nodiscard]] value_type operator[](difference_type n) const { return view_[static_cast<std::size_t>(at_ + n)]; }
  ViewIterator& operator+=(difference_type n) {
    at_ += n;
    return *this;
  }
  ViewIterator& operator-=(difference_type n) { return *this += -n; }
  ViewIterator& operator++() { return *this += 1; }
  ViewIterator& operator--() { return *this += -1; }
  ViewIterator operator++(int) {
    ViewIterator before = *this;
    ++*this;
    return before;
  }
  ViewIterator operator--(int) {
    ViewIterator before = *this;
    --*this;
    return before;
  }
  friend ViewIterator operator+(ViewIterator i, difference_type n) { return i += n; }
  friend ViewIterator operator+(difference_type n, ViewIterator i) { return i += n; }
  friend ViewIterator operator-(ViewIterator i, difference_type n) { return i -= n; }
  friend difference_type operator-(const ViewIterator& i, const ViewIterator& j) { return i.at_ - j.at_; }
  /// Of iterators over the same view.
  friend bool operator==(const ViewIterator& i, const ViewIterator& j) { return i.at_ == j.at_; }
  friend std::strong_ordering operator<=>(const ViewIterator& i, const ViewIterator& j) { return i.at_ <=> j.at_; }

 private:
  View view_;
  difference_type at_ = 0;
};

/// Points in somebody's array of doubles: point i is (x[i·stride], y[i·stride], z[i·stride]). This covers rows x, y, z
/// of a table with any further columns, an array of structures that begin with three doubles, and three columns that
/// lie apart. Refers to the array, which must outlive the view and stay as it is; cheap to copy. Elements are values,
/// not references. Degenerate: no points; a negative stride goes backwards from the first point; with a stride of 0 all
/// points are the first.
class PointsView {
 public:
  using value_type = Point3;
  using Iterator = ViewIterator<PointsView>;

  PointsView() = default;
  /// Rows: x, y, z of a point are adjacent, the next point begins `stride` doubles on.
  PointsView(const double* xyz, std::size_t size, std::ptrdiff_t stride = 3)
      : PointsView(xyz, size == 0 ? xyz : xyz + 1, size == 0 ? xyz : xyz + 2, size, stride) {}
  /// Columns, each with its values `stride` doubles apart.
  PointsView(const double* x, const double* y, const double* z, std::size_t size, std::ptrdiff_t stride = 1)
      : x_(x), y_(y), z_(z), size_(size), stride_(stride) {}
  PointsView(std::span<const Point3> points)
      : PointsView(reinterpret_cast<const double*>(points.data()), points.size()) {}
  PointsView(const Array<Point3>& points) : PointsView(std::span<const Point3>(points)) {}
  PointsView(const Array<Point3>&&) = delete;  // it would be gone

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] Point3 operator[](std::size_t i) const {
    const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(i) * stride_;
    return {x_[at], y_[at], z_[at]};
  }
  [[nodiscard]] Iterator begin() const { return {*this, 0}; }
  [[nodiscard]] Iterator end() const { return {*this, static_cast<std::ptrdiff_t>(size_)}; }
  /// Where the first coordinate of point i lies, to fetch it ahead of its use.
  [[nodiscard]] const double* address(std::size_t i) const { return x_ + static_cast<std::ptrdiff_t>(i) * stride_; }
  [[nodiscard]] Array<Point3> copy() const;

 private:
  static_assert(sizeof(Point3) == 3 * sizeof(double) && std::is_standard_layout_v<Point3>);

  const double *x_ = nullptr, *y_ = nullptr, *z_ = nullptr;
  std::size_t size_ = 0;
  std::ptrdiff_t stride_ = 3;
};

/// Numbers in somebody's array, `stride` doubles apart. As PointsView.
class ValuesView {
 public:
  using value_type = double;
  using Iterator = ViewIterator<ValuesView>;

  ValuesView() = default;
  ValuesView(const double* first, std::size_t size, std::ptrdiff_t stride = 1)
      : first_(first), size_(size), stride_(stride) {}
  ValuesView(const Array<double>& values) : ValuesView(values.data(), values.size()) {}
  ValuesView(const Array<double>&&) = delete;  // it would be gone

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] double operator[](std::size_t i) const { return first_[static_cast<std::ptrdiff_t>(i) * stride_]; }
  [[nodiscard]] Iterator begin() const { return {*this, 0}; }
  [[nodiscard]] Iterator end() const { return {*this, static_cast<std::ptrdiff_t>(size_)}; }
  [[nodiscard]] Array<double> copy() const;

 private:
  const double* first_ = nullptr;
  std::size_t size_ = 0;
  std::ptrdiff_t stride_ = 1;
};

/// An Attribute in somebody's array.
struct AttributeView {
  std::string name;
  ValuesView values;  ///< as many as points
};

using FacesView = std::span<const std::array<Index, 3>>;

/// What a Cloud is, with points, values of attributes and faces in somebody's arrays. Words are the view's own.
///
/// Shapes: n points; n values of each attribute; each face three indices below n. The last two are checked where an
/// attribute or the faces are used (InputError). That the arrays are as long as the view says cannot be checked. What
/// is wrong with the numbers (no finite point, a unit that does not fit) is refused by the functions that take the
/// view, as of a Cloud and with the same words.
///
/// Lifetime: the arrays must live, and stay as they are, as long as the view and its copies are used; no function of
/// isopach keeps a view after it has returned, and no result refers to it. A view of a Cloud refers to it; a view of a
/// temporary Cloud takes it over and owns it, so that `CloudView v = read_cloud(...)` is safe. Where something else
/// owns the arrays and can be shared, `owner` keeps it alive.
///
/// Cost: that of its words, and of a list with one entry an attribute; nothing is done for each point. Oracles:
/// tests/cloud/cloud_view_test.cpp, tests/compare/cloud_view_test.cpp.
struct CloudView {
  PointsView points;                      ///< NaN and infinities allowed
  std::vector<AttributeView> attributes;  ///< each as long as points
  FacesView faces;                        ///< triangles; empty if none
  std::string path;                       ///< the scan's name in messages and results; may be empty
  std::string format;                     ///< as Cloud::format; empty if made in memory
  std::string unit = "unknown";           ///< of x and y, as Cloud::unit
  std::string vertical_unit = "unknown";  ///< of z
  std::string crs;                        ///< WKT or "EPSG:n"; empty if none
  std::optional<RasterGrid> grid;         ///< set if the points are those of a raster
  std::size_t nodata = 0;                 ///< as Cloud::nodata
  std::vector<std::string> notes;         ///< one-line remarks, shown as warnings
  std::shared_ptr<const void> owner;      ///< of the arrays; null: the caller sees to it that they live

  CloudView() = default;
  /// Points alone, of unknown unit; all else may be set afterwards.
  explicit CloudView(PointsView points_of) : points(points_of) {}
  /// Refers to `cloud`, which must outlive the view and its copies.
  CloudView(const Cloud& cloud);
  /// Owns the cloud; its arrays are taken over, not copied.
  CloudView(Cloud&& cloud);
  CloudView(const Cloud&&) = delete;  // could be neither referred to nor taken over
  /// Shares the cloud, which must not be null.
  explicit CloudView(std::shared_ptr<const Cloud> cloud);

  /// Null if there is none of that name. InputError if it has more or fewer values than there are points.
  [[nodiscard]] const AttributeView* find_attribute(std::string_view name) const;
};

/// "scan.las", or a word for a cloud made in memory: how messages begin.
[[nodiscard]] std::string cloud_name(const CloudView& cloud);

/// InputError if a face has a corner that is no point. Cost: O(faces).
void check_faces(const CloudView& view);

/// A cloud with arrays of its own. Cost: a copy of everything.
[[nodiscard]] Cloud copy_of(const CloudView& view);

}  // namespace isopach
