#include "isopach/match/verdict/judged_scan.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "isopach/base/median.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/random.hpp"
#include "isopach/distance/vectors.hpp"
#include "isopach/field/filter.hpp"
#include "isopach/geom/curve.hpp"
#include "isopach/match/verdict/shape_detail.hpp"

namespace isopach {
namespace {

constexpr std::size_t listed = 32;        // neighbours of a point, itself first: about 16 in each half
constexpr std::size_t of_other_half = 8;  // that a plane is fitted to
constexpr std::size_t sixth = 6, sixteenth = 16;
constexpr std::size_t noise_queries = 3000;
constexpr std::size_t fewest_points = 60;
constexpr std::size_t block = 256;
constexpr double widest_area = 0.95;  // percentile: a lone point is not a large surface
constexpr double noise_widths = 3;
constexpr double least_noise = 0.01;           // of the spacing
constexpr std::size_t spacing_queries = 2500;  // points that tell the spacing in the viewing

struct Keyed {
  std::uint64_t key;
  Point3 p;
};

bool before(const Keyed& a, const Keyed& b) {
  if (a.key != b.key) return a.key < b.key;
  if (a.p.x != b.p.x) return a.p.x < b.p.x;
  return a.p.y != b.p.y ? a.p.y < b.p.y : a.p.z < b.p.z;
}

Array<Keyed> chosen_points(const CloudView& cloud, const ProjectOptions& project, std::uint64_t seed) {
  const Pose unmoved;
  const Filter filter(cloud, unmoved, project);
  Array<Keyed> kept;
  kept.reserve(filter.size());
  for (std::size_t i = 0; i < filter.size(); ++i)
    if (filter.fate(i, cloud.points[i]) == Filter::Fate::kept) kept.push_back({0, cloud.points[i]});
  for_each_index(kept.size(), [&](std::size_t i) { kept[i].key = point_key(kept[i].p, seed); });
  const auto same = [](const Keyed& a, const Keyed& b) { return a.p == b.p; };
  // Where points repeat, fewer than asked for are different: the choice is widened until there are enough.
  for (std::size_t most = judged_points;; most *= 2) {
    const bool all = most >= kept.size();
    const auto end = all ? kept.end() : kept.begin() + static_cast<std::ptrdiff_t>(most);
    if (!all) std::nth_element(kept.begin(), end, kept.end(), before);
    Array<Keyed> chosen(kept.begin(), end);
    std::sort(chosen.begin(), chosen.end(), before);
    chosen.erase(std::unique(chosen.begin(), chosen.end(), same), chosen.end());
    if (!all && chosen.size() < judged_points) continue;
    if (chosen.size() > judged_points) chosen.resize(judged_points);
    return chosen;
  }
}

/// Neighbours of every point and what follows from them.
class Builder {
 public:
  Builder(JudgedScan& scan, Array<std::uint64_t> keys) : s_(scan), keys_(std::move(keys)) {}

  void run(const Point3& scanner_origin) {
    s_.half.resize(n());
    for (std::size_t i = 0; i < n(); ++i) s_.half[i] = static_cast<unsigned char>(keys_[i] & 1u);
    find_neighbours();
    measure_size();
    s_.queries = drawn([](std::uint64_t) { return true; }, judged_queries, 2);
    choose_view(scanner_origin);
    face_the_eye(s_.normals);
    s_.mean_normals.resize(n());
    for_blocks(n(), block, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        s_.mean_normals[i] = mean_of(s_.normals, neighbours(i).first(std::min(normal_of, listed_)));
    });
    compare_halves();
  }

 private:
  [[nodiscard]] std::size_t n() const { return s_.points.size(); }
  [[nodiscard]] std::span<const Index> neighbours(std::size_t i) const {
    return {neighbours_.data() + i * listed_, listed_};
  }
  [[nodiscard]] bool in_first_half(std::size_t i) const { return s_.half[i] != 0; }

  void find_neighbours() {
    s_.tree = std::make_unique<PointTree>(s_.points);
    listed_ = std::min(listed, n());
    neighbours_.resize(n() * listed_);
    reach_.resize(n());
    s_.normals.resize(n());
    for_blocks(n(), block, [&](std::size_t begin, std::size_t end) {
      std::vector<Index> found;
      for (std::size_t i = begin; i < end; ++i) {
        s_.tree->nearest(s_.points[i], listed_, found);
        std::copy(found.begin(), found.end(), neighbours_.begin() + static_cast<std::ptrdiff_t>(i * listed_));
        reach_[i] = length(s_.points[found[std::min(sixteenth, listed_ - 1)]] - s_.points[i]);
        s_.normals[i] = plane_of(s_.points, neighbours(i).first(std::min(normal_of, listed_))).normal;
      }
    });
  }

  void measure_size() {
    Array<double> sixths(n());
    for (std::size_t i = 0; i < n(); ++i)
      sixths[i] = length(s_.points[neighbours(i)[std::min(sixth, listed_ - 1)]] - s_.points[i]);
    s_.spacing = median(sixths);
    double squared = 0;
    for (double Point3::*axis : {&Point3::x, &Point3::y, &Point3::z}) {
      Array<double> values(n());
      for (std::size_t i = 0; i < n(); ++i) values[i] = s_.points[i].*axis;
      const auto at = [&](double share) {
        const auto k = static_cast<std::ptrdiff_t>(share * static_cast<double>(n() - 1));
        std::nth_element(values.begin(), values.begin() + k, values.end());
        return values[static_cast<std::size_t>(k)];
      };
      const double low = at(0.01), side = at(0.99) - low;
      squared += side * side;
    }
    s_.extent = std::sqrt(squared);
  }

  /// Random points of those that `belongs` takes, drawn without replacement by area (P. Efraimidis, P. Spirakis 2006).
  template <class Belongs>
  [[nodiscard]] Array<Index> drawn(const Belongs& belongs, std::size_t most, std::uint64_t stream) const {
    Array<double> sorted = reach_;
    const auto at = static_cast<std::size_t>(widest_area * static_cast<double>(n() - 1));
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(at), sorted.end());
    struct Ticket {
      double value;
      Index point;
    };
    Array<Ticket> tickets;
    for (std::size_t i = 0; i < n(); ++i) {
      if (!belongs(i)) continue;
      const double side = std::min(reach_[i], sorted[at]);
      const double u = RandomStream(keys_[i], stream).uniform(0);
      tickets.push_back({side > 0 ? std::log(1 - u) / (side * side) : -std::numeric_limits<double>::infinity(),
                         static_cast<Index>(i)});
    }
    const std::size_t count = std::min(most, tickets.size() / 2);
    std::sort(tickets.begin(), tickets.end(), [](const Ticket& a, const Ticket& b) {
      return a.value != b.value ? a.value > b.value : a.point < b.point;
    });
    Array<Index> result(count);
    for (std::size_t k = 0; k < count; ++k) result[k] = tickets[k].point;
    std::sort(result.begin(), result.end());
    return result;
  }

  void choose_view(const Point3& scanner_origin) {
    Array<double> reach(s_.queries.size());
    for (std::size_t k = 0; k < reach.size(); ++k) reach[k] = reach_[s_.queries[k]];
    s_.viewing = choose_viewing(s_.points, s_.normals, s_.queries, reach, scanner_origin);
    s_.places.resize(n());
    for_each_index(n(), [&](std::size_t i) { s_.places[i] = s_.viewing.place(s_.points[i]); });
    s_.places_tree = std::make_unique<PointTree>(s_.places);
    Array<double> sixths;
    std::vector<Index> found;
    const std::size_t step = std::max<std::size_t>(1, n() / spacing_queries);
    for (std::size_t i = 0; i < n(); i += step) {
      s_.places_tree->nearest(s_.places[i], sixth + 1, found);
      sixths.push_back(length(s_.places[found.back()] - s_.places[i]));
    }
    s_.place_spacing = median(sixths);
  }

  void face_the_eye(Array<Point3>& normals) const {
    for_each_index(n(), [&](std::size_t i) {
      if (dot(normals[i], s_.viewing.line_of_sight(s_.points[i])) < 0) normals[i] = -1.0 * normals[i];
    });
  }

  /// Of the neighbours of i, those in its own half (the point itself among them) or in the other, nearest first.
  void of_half(std::size_t i, bool own, std::size_t most, std::vector<Index>& found) const {
    found.clear();
    for (const Index k : neighbours(i))
      if ((in_first_half(k) == in_first_half(i)) == own && found.size() < most) found.push_back(k);
  }

  void compare_halves() {
    Array<Point3> normals(n());  // of each point by its own half alone
    for_blocks(n(), block, [&](std::size_t begin, std::size_t end) {
      std::vector<Index> found;
      for (std::size_t i = begin; i < end; ++i) {
        of_half(i, true, normal_of, found);
        normals[i] = plane_of(s_.points, found).normal;
      }
    });
    face_the_eye(normals);
    const Array<Index> queries = drawn([&](std::size_t i) { return in_first_half(i); }, noise_queries, 3);
    Array<double> distances;
    ShapeDetail detail;
    std::vector<Index> own, other, others_own;
    for (const Index i : queries) {
      of_half(i, false, of_other_half, other);
      if (other.size() < 4) continue;
      const LocalPlane plane = plane_of(s_.points, other);
      distances.push_back(std::fabs(dot(plane.normal, s_.points[i] - plane.centre)));
      of_half(i, true, normal_of, own);
      of_half(other.front(), true, normal_of, others_own);
      detail.add(s_.points[i], mean_of(normals, own), mean_of(normals, others_own));
    }
    s_.detail = detail.correlation();
    Array<double> copy = distances;
    const double size = length(s_.origin) + s_.extent;
    const double least = std::max(least_noise * s_.spacing, 8 * std::numeric_limits<double>::epsilon() * size);
    s_.noise = std::max(mad_to_sigma * median(copy), least);
    const auto within =
        std::count_if(distances.begin(), distances.end(), [&](double d) { return d < noise_widths * s_.noise; });
    s_.within_noise = distances.empty() ? 1 : static_cast<double>(within) / static_cast<double>(distances.size());
  }

  JudgedScan& s_;
  Array<std::uint64_t> keys_;
  Array<Index> neighbours_;
  Array<double> reach_;  ///< distance of the 16th neighbour
  std::size_t listed_ = 0;
};

}  // namespace

std::uint64_t point_key(const Point3& p, std::uint64_t seed) {
  const auto bits = [](double v) { return std::bit_cast<std::uint64_t>(v + 0.0); };  // -0 is 0
  const std::uint64_t first = RandomStream(seed, bits(p.x)).bits(bits(p.y));
  return RandomStream(first, bits(p.z)).bits(0);
}

JudgedScan judged_scan(const CloudView& cloud, const ProjectOptions& project, const Context& context) {
  context.check();
  JudgedScan scan;
  const Array<Keyed> chosen = chosen_points(cloud, project, context.seed);
  if (chosen.size() < fewest_points) return scan;
  Box3 box;
  for (const Keyed& k : chosen) box.add(k.p);
  scan.origin = 0.5 * (box.min + box.max);
  Array<Point2> plane(chosen.size());
  Box2 plane_box;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const Point3 p = chosen[i].p - scan.origin;
    plane[i] = {p.x, p.y}, plane_box.add(plane[i]);
  }
  Array<std::uint64_t> keys;
  for (const Index i : curve_order(plane, curve_box(plane_box))) {
    scan.points.push_back(chosen[i].p - scan.origin);
    keys.push_back(chosen[i].key);
  }
  Builder(scan, std::move(keys)).run(-1.0 * scan.origin);
  return scan;
}

}  // namespace isopach
