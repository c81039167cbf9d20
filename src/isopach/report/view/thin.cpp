#include "isopach/report/view/thin.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

#include "isopach/base/sum.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/overlay/localise.hpp"

namespace isopach {
namespace {

/// A node, or a corner of a clipped cell.
struct Sample {
  Point2 at;
  double z, d, lod;
};

using Corners = std::array<Index, 3>;

/// What there is: samples in curve order, and the cells of the domain with these as corners.
struct Samples {
  std::vector<Sample> at;
  std::vector<Corners> cells;
};

double level_at(const Cells& cells, const CellPiece& piece, const Point2& p) {
  if (cells.lod.empty()) return 0;
  const auto& v = cells.triangulation.triangles[piece.cell].v;
  const Point2 &a = cells.xy[v[0]], &b = cells.xy[v[1]], &c = cells.xy[v[2]];
  const double all = triangle_area(a, b, c);
  if (!(all > 0)) return cells.lod[v[0]];
  const double wa = triangle_area(p, b, c) / all, wb = triangle_area(a, p, c) / all;
  return wa * cells.lod[v[0]] + wb * cells.lod[v[1]] + (1 - wa - wb) * cells.lod[v[2]];
}

/// Every corner once, nodes before corners of pieces at the same place.
Samples collect(const Comparison& c) {
  const Cells& cells = c.cells;
  std::vector<Sample> found;
  std::vector<Corners> triangles;
  Array<Index> number(cells.xy.size(), no_index);
  for (Index t = 0; t < cells.triangulation.real; ++t) {
    if (!cells.in_domain[t]) continue;
    Corners corners;
    for (std::size_t k = 0; k < 3; ++k) {
      const Index v = cells.triangulation.triangles[t].v[k];
      if (number[v] == no_index) {
        number[v] = static_cast<Index>(found.size());
        found.push_back({cells.xy[v], cells.z1[v], cells.d(v), cells.lod.empty() ? 0 : cells.lod[v]});
      }
      corners[k] = number[v];
    }
    triangles.push_back(corners);
  }
  for (const CellPiece& piece : cells.pieces) {
    Corners corners;
    for (std::size_t k = 0; k < 3; ++k) {
      const Corner& at = piece.at[k];
      corners[k] = static_cast<Index>(found.size());
      found.push_back({{at.x, at.y}, at.z1, at.d(), level_at(cells, piece, {at.x, at.y})});
    }
    triangles.push_back(corners);
  }
  std::vector<Point2> places(found.size());
  for (std::size_t i = 0; i < found.size(); ++i) places[i] = found[i].at;
  const Array<Index> order = curve_order(places, c.frame.curve);
  Samples out;
  Array<Index> place(found.size());
  for (const Index i : order) {
    if (out.at.empty() || !(out.at.back().at == found[i].at)) out.at.push_back(found[i]);
    place[i] = static_cast<Index>(out.at.size() - 1);
  }
  for (Corners& corners : triangles) {
    for (Index& v : corners) v = place[v];
    if (corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0]) out.cells.push_back(corners);
  }
  return out;
}

/// A power of two, so that coordinates on a decimal grid stay on it as far as doubles have it.
double plane_step(const Box2& box, int bits) {
  const double side = std::max(box.max.x - box.min.x, box.max.y - box.min.y);
  if (!(side > 0)) return 1;
  return std::exp2(std::ceil(std::log2(side)) - bits);
}

Quantised quantise_plane(const std::vector<Sample>& samples, double Point2::*axis, double low, double step) {
  Quantised q{std::floor(low / step) * step, step, {}};
  q.numbers.resize(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i)
    q.numbers[i] = static_cast<std::uint32_t>(std::lround((samples[i].at.*axis - q.low) / step));
  return q;
}

/// 0 is kept exactly where it lies within the values: unchanged ground stays so.
Quantised quantise(const std::vector<Sample>& samples, double Sample::*value, int bits) {
  if (samples.empty()) return {};
  double low = INFINITY, high = -INFINITY;
  for (const Sample& s : samples) low = std::min(low, s.*value), high = std::max(high, s.*value);
  const double most = std::exp2(bits) - 1;
  Quantised q{low, (high - low) / (most - 1), {}};
  q.numbers.assign(samples.size(), 0);
  if (!(high - low > 1e-12 * std::max(std::fabs(low), std::fabs(high)))) q.step = 0;
  if (q.step == 0) return q;
  if (low < 0 && high > 0) q.low = -q.step * std::ceil(-low / q.step);
  for (std::size_t i = 0; i < samples.size(); ++i)
    q.numbers[i] = static_cast<std::uint32_t>(std::clamp(std::round((samples[i].*value - q.low) / q.step), 0.0, most));
  return q;
}

constexpr int plane_bits = 22, whole_plane_bits = 24, height_bits = 20, difference_bits = 16, level_bits = 12;

/// The numbers of chosen samples, and these as they are read back.
struct Chosen {
  ThinSurface surface;
  std::vector<Point2> xy;
};

Chosen with_numbers(const std::vector<Sample>& samples, const Box2& box, bool has_level, int bits = plane_bits) {
  Chosen out;
  const double step = plane_step(box, bits);
  out.surface.x = quantise_plane(samples, &Point2::x, box.min.x, step);
  out.surface.y = quantise_plane(samples, &Point2::y, box.min.y, step);
  out.surface.z = quantise(samples, &Sample::z, height_bits);
  out.surface.d = quantise(samples, &Sample::d, difference_bits);
  if (has_level) out.surface.lod = quantise(samples, &Sample::lod, level_bits);
  out.xy.resize(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) out.xy[i] = {out.surface.x.at(i), out.surface.y.at(i)};
  return out;
}

/// Barycentric coordinates; a point on a node or an edge is of any triangle there.
std::array<double, 3> weights_in(const std::array<Point2, 3>& t, const Point2& p) {
  const double all = triangle_area(t[0], t[1], t[2]);
  if (!(all != 0)) return {1, 0, 0};
  const double a = triangle_area(p, t[1], t[2]) / all, b = triangle_area(t[0], p, t[2]) / all;
  return {a, b, 1 - a - b};
}

/// A triangulation of chosen samples, which answers for any place.
class Interpolated {
 public:
  Interpolated(std::span<const Sample> samples, std::span<const Point2> xy, const Triangulation& t)
      : samples_(samples), xy_(xy), t_(t) {}

  struct Value {
    double z, d;
    Index triangle;  ///< no_index outside of the hull
  };
  [[nodiscard]] Value at(const Point2& p, const Location& where) const {
    const Index triangle = triangle_at(where);
    if (triangle == no_index) return {0, 0, no_index};
    const auto& v = t_.triangles[triangle].v;
    const auto w = weights_in({xy_[v[0]], xy_[v[1]], xy_[v[2]]}, p);
    Value out{0, 0, triangle};
    for (std::size_t k = 0; k < 3; ++k) out.z += w[k] * samples_[v[k]].z, out.d += w[k] * samples_[v[k]].d;
    return out;
  }
  [[nodiscard]] bool is_node(const Location& where) const { return where.kind == Location::Kind::node; }

 private:
  [[nodiscard]] Index triangle_at(const Location& where) const {
    switch (where.kind) {
      case Location::Kind::triangle:
        return where.id;
      case Location::Kind::edge:
        return triangle_of(where.id);
      case Location::Kind::outside: {
        const Index inside = triangle_of(t_.twin(where.id));
        return t_.is_ghost(inside) ? no_index : inside;
      }
      default:
        return no_index;
    }
  }
  std::span<const Sample> samples_;
  std::span<const Point2> xy_;
  const Triangulation& t_;
};

/// Chooses samples by number.
class Thinning {
 public:
  Thinning(const Samples& all, const Comparison& c, std::size_t most, const Context& context)
      : all_(all), c_(c), most_(most), context_(context), places_(all.at.size()), taken_(all.at.size(), 0) {
    for (std::size_t i = 0; i < places_.size(); ++i) places_[i] = all.at[i].at, box_.add(all.at[i].at);
    double low_z = INFINITY, high_z = -INFINITY, most_d = 0;
    for (const Sample& s : all.at)
      low_z = std::min(low_z, s.z), high_z = std::max(high_z, s.z), most_d = std::max(most_d, std::fabs(s.d));
    // Heights matter for the look alone: an error of theirs counts a quarter of one of d, each as a share of its range.
    weight_d_ = most_d > 0 ? 1 / most_d : 0, weight_z_ = high_z > low_z ? 0.25 / (high_z - low_z) : 0;
  }

  /// Numbers of the chosen, ascending.
  [[nodiscard]] std::vector<Index> choose() {
    take_changes(most_ / 5);
    take_extremes(most_ * 2 / 5);
    constexpr int rounds = 4;
    for (int round = 1; round <= rounds; ++round) {
      context_.check();
      const std::size_t wanted = count_ + (most_ - count_) / static_cast<std::size_t>(rounds + 1 - round);
      refine(wanted);
    }
    return chosen();
  }

 private:
  [[nodiscard]] std::vector<Index> chosen() const {
    std::vector<Index> out;
    for (std::size_t i = 0; i < taken_.size(); ++i)
      if (taken_[i]) out.push_back(static_cast<Index>(i));
    return out;
  }
  void take(std::size_t i) {
    if (!taken_[i]) taken_[i] = 1, ++count_;
  }

  /// Where the objects among the changes are largest, which is at nodes.
  void take_changes(std::size_t wanted) {
    if (!c_.changes) return;
    std::set<std::pair<double, double>> found;
    for (const Change& change : c_.changes->list)
      if (found.size() < wanted) found.insert({change.largest_at.x, change.largest_at.y});
    for (std::size_t i = 0; i < places_.size(); ++i)
      if (found.contains({places_[i].x, places_[i].y})) take(i);
  }

  /// Of each square the samples of the least and the largest d, and those at the ends of the box.
  void take_extremes(std::size_t wanted) {
    const double width = box_.max.x - box_.min.x, height = box_.max.y - box_.min.y;
    const double area = std::max(width * height, 1e-300);
    const double side = std::sqrt(area / std::max<double>(1, static_cast<double>(wanted) / 2));
    const auto columns = static_cast<std::size_t>(width / side) + 1, rows = static_cast<std::size_t>(height / side) + 1;
    std::vector<std::array<Index, 2>> extremes(columns * rows, {no_index, no_index});
    for (std::size_t i = 0; i < all_.at.size(); ++i) {
      const Sample& s = all_.at[i];
      const auto column = static_cast<std::size_t>((s.at.x - box_.min.x) / side),
                 row = static_cast<std::size_t>((s.at.y - box_.min.y) / side);
      auto& [low, high] = extremes[std::min(row, rows - 1) * columns + std::min(column, columns - 1)];
      if (low == no_index || s.d < all_.at[low].d) low = static_cast<Index>(i);
      if (high == no_index || s.d > all_.at[high].d) high = static_cast<Index>(i);
    }
    for (const auto& pair : extremes)
      for (const Index i : pair)
        if (i != no_index && count_ + 4 < most_) take(i);
    const auto ends = [&](double Point2::*axis) {
      const auto [low, high] = std::minmax_element(places_.begin(), places_.end(),
                                                   [&](const Point2& a, const Point2& b) { return a.*axis < b.*axis; });
      take(static_cast<std::size_t>(low - places_.begin())), take(static_cast<std::size_t>(high - places_.begin()));
    };
    ends(&Point2::x), ends(&Point2::y);
  }

  /// Adds samples where the surface so far is worst: the worst of a triangle before the second of another.
  void refine(std::size_t wanted) {
    const std::vector<Index> nodes = chosen();
    std::vector<Sample> samples;
    std::vector<Point2> xy;
    for (const Index i : nodes) samples.push_back(all_.at[i]), xy.push_back(places_[i]);
    const Triangulation t = triangulate(xy, c_.frame.curve, context_);
    if (t.real == 0) return take_evenly(wanted);
    const Locations where = localise_in_order(places_, t, xy, context_);
    const Interpolated surface(samples, xy, t);
    std::vector<double> error(places_.size(), 0);
    std::vector<Index> home(places_.size(), no_index), worst(t.triangles.size(), no_index);
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (taken_[i]) continue;
      const auto value = surface.at(places_[i], where[i]);
      home[i] = value.triangle != no_index ? value.triangle : t.real;
      const bool is_outside = where.kind[i] == Location::Kind::outside;
      error[i] = is_outside ? 2.0
                            : std::max(weight_d_ * std::fabs(value.d - all_.at[i].d),
                                       weight_z_ * std::fabs(value.z - all_.at[i].z));
      if (home[i] >= worst.size()) continue;
      Index& best = worst[home[i]];
      if (best == no_index || error[i] > error[best]) best = static_cast<Index>(i);
    }
    take_worst(error, worst, wanted);
  }

  void take_worst(const std::vector<double>& error, const std::vector<Index>& worst, std::size_t wanted) {
    const auto is_worse = [&](Index a, Index b) { return error[a] > error[b] || (error[a] == error[b] && a < b); };
    std::vector<Index> first;
    for (const Index i : worst)
      if (i != no_index && error[i] > 0) first.push_back(i);
    std::sort(first.begin(), first.end(), is_worse);
    for (const Index i : first)
      if (count_ < wanted) take(i);
    if (count_ >= wanted) return;
    std::vector<Index> others;
    for (std::size_t i = 0; i < error.size(); ++i)
      if (!taken_[i] && error[i] > 0) others.push_back(static_cast<Index>(i));
    std::sort(others.begin(), others.end(), is_worse);
    for (const Index i : others)
      if (count_ < wanted) take(i);
  }

  void take_evenly(std::size_t wanted) {
    const std::size_t stride = std::max<std::size_t>(1, places_.size() / std::max<std::size_t>(1, wanted));
    for (std::size_t i = 0; i < places_.size() && count_ < wanted; i += stride) take(i);
  }

  const Samples& all_;
  const Comparison& c_;
  std::size_t most_, count_ = 0;
  const Context& context_;
  std::vector<Point2> places_;
  std::vector<unsigned char> taken_;
  Box2 box_;
  double weight_d_ = 0, weight_z_ = 0;
};

/// Whether places lie in the domain.
class DomainTest {
 public:
  explicit DomainTest(const Cells& cells) : cells_(cells) {
    for (std::size_t i = 0; i < cells.pieces.size(); ++i) pieces_.emplace(cells.pieces[i].cell, i);
  }
  [[nodiscard]] bool holds(const Point2& p, const Location& where) const {
    if (where.kind == Location::Kind::triangle) return in(where.id, p);
    if (where.kind == Location::Kind::edge) return in(triangle_of(where.id), p);
    return false;
  }

 private:
  [[nodiscard]] bool in(Index t, const Point2& p) const {
    if (t >= cells_.triangulation.real) return false;
    if (cells_.in_domain[t]) return true;
    const auto [from, to] = pieces_.equal_range(t);
    for (auto i = from; i != to; ++i) {
      const auto& at = cells_.pieces[i->second].at;
      const auto w = weights_in({Point2{at[0].x, at[0].y}, {at[1].x, at[1].y}, {at[2].x, at[2].y}}, p);
      if (w[0] >= 0 && w[1] >= 0 && w[2] >= 0) return true;
    }
    return false;
  }
  const Cells& cells_;
  std::unordered_multimap<Index, std::size_t> pieces_;
};

/// Triangles of the chosen whose centroids lie in the domain.
Array<Corners> triangles_in_domain(const Comparison& c, const Triangulation& t, std::span<const Point2> xy,
                                   const Context& context) {
  std::vector<Point2> centres;
  for (Index i = 0; i < t.real; ++i) {
    const auto& v = t.triangles[i].v;
    centres.push_back({(xy[v[0]].x + xy[v[1]].x + xy[v[2]].x) / 3, (xy[v[0]].y + xy[v[1]].y + xy[v[2]].y) / 3});
  }
  Array<Point2> sorted;
  const Array<Index> order = curve_order(centres, c.frame.curve, nullptr, &sorted);
  const Locations where = localise_in_order(sorted, c.cells.triangulation, c.cells.xy, context);
  const DomainTest domain(c.cells);
  std::vector<unsigned char> is_in(centres.size());
  for (std::size_t i = 0; i < order.size(); ++i) is_in[order[i]] = domain.holds(sorted[i], where[i]);
  Array<Corners> out;
  for (Index i = 0; i < t.real; ++i)
    if (is_in[i]) out.push_back(t.triangles[i].v);
  return out;
}

void sort_triangles(Array<Corners>& triangles) {
  for (Corners& v : triangles) std::rotate(v.begin(), std::min_element(v.begin(), v.end()), v.end());
  std::sort(triangles.begin(), triangles.end());
}

void add_totals(ThinSurface& s) {
  Sum area, above, below;
  for (const Corners& v : s.triangles) {
    const auto place = [&](Index i) { return Point2{s.x.at(i), s.y.at(i)}; };
    const Cell cell{triangle_area(place(v[0]), place(v[1]), place(v[2])), {s.d.at(v[0]), s.d.at(v[1]), s.d.at(v[2])}};
    const Parts parts = split_volume(cell);
    area.add(cell.area), above.add(parts.above), below.add(parts.below);
  }
  s.area = area.value(), s.above = above.value(), s.below = below.value();
}

struct Errors {
  double d = 0, z = 0;
  Sum squares;
  std::size_t count = 0;
  void add(double of_d, double of_z) {
    d = std::max(d, std::fabs(of_d)), z = std::max(z, std::fabs(of_z));
    squares.add(of_d * of_d), ++count;
  }
};

void set_errors(ThinSurface& s, const Errors& e) {
  s.d_error = e.d, s.z_error = e.z;
  s.d_rms = e.count > 0 ? std::sqrt(e.squares.value() / static_cast<double>(e.count)) : 0;
}

/// The cells themselves. What rounding of x and y does to them, a part in 3e7 of the extent times the slope, is not in
/// the errors.
ThinSurface whole_surface(const Samples& all, const Box2& box, bool has_level) {
  ThinSurface s = with_numbers(all.at, box, has_level, whole_plane_bits).surface;
  s.triangles.assign(all.cells.begin(), all.cells.end());
  s.is_whole = true;
  Errors errors;
  for (std::size_t i = 0; i < all.at.size(); ++i) errors.add(s.d.at(i) - all.at[i].d, s.z.at(i) - all.at[i].z);
  set_errors(s, errors);
  return s;
}

ThinSurface chosen_surface(const Samples& all, const Comparison& c, const Box2& box, std::size_t most,
                           const Context& context) {
  std::vector<Sample> samples;
  for (const Index i : Thinning(all, c, most, context).choose()) samples.push_back(all.at[i]);
  Chosen chosen = with_numbers(samples, box, !c.cells.lod.empty());
  // Read back they may coincide, or have changed places on the curve.
  const SortedTriangulation sorted = triangulate_unsorted(chosen.xy, context);
  std::vector<Sample> kept;
  for (const Index i : sorted.order) kept.push_back(samples[i]);
  chosen = with_numbers(kept, box, !c.cells.lod.empty());
  ThinSurface& s = chosen.surface;
  s.triangles = triangles_in_domain(c, sorted.triangulation, sorted.xy, context);
  if (sorted.triangulation.real == 0) return s;

  for (std::size_t i = 0; i < kept.size(); ++i) kept[i].z = s.z.at(i), kept[i].d = s.d.at(i);
  std::vector<Point2> places(all.at.size());
  for (std::size_t i = 0; i < places.size(); ++i) places[i] = all.at[i].at;
  const Locations where = localise_in_order(places, sorted.triangulation, sorted.xy, context);
  const Interpolated surface(kept, sorted.xy, sorted.triangulation);
  Errors errors;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (where.kind[i] == Location::Kind::node) {
      errors.add(kept[where.id[i]].d - all.at[i].d, kept[where.id[i]].z - all.at[i].z);
      continue;
    }
    const auto value = surface.at(places[i], where[i]);
    if (value.triangle != no_index) errors.add(value.d - all.at[i].d, value.z - all.at[i].z);
  }
  set_errors(s, errors);
  return std::move(chosen.surface);
}

}  // namespace

ThinSurface thin_surface(const Comparison& c, std::size_t most, const Context& context) {
  const Samples all = collect(c);
  Box2 box;
  for (const Sample& s : all.at) box.add(s.at);
  ThinSurface s;
  if (!all.at.empty())
    s = all.at.size() <= std::max<std::size_t>(most, 100)
            ? whole_surface(all, box, !c.cells.lod.empty())
            : chosen_surface(all, c, box, std::max<std::size_t>(most, 100), context);
  s.nodes_of_cells = all.at.size();
  sort_triangles(s.triangles);
  add_totals(s);
  return s;
}

}  // namespace isopach
