#include "isopach/overlay/regions.hpp"

#include <algorithm>
#include <cmath>

#include "isopach/base/sum.hpp"
#include "isopach/geom/predicates.hpp"

namespace isopach {

namespace {

constexpr std::size_t many_parts = 48;  // above it a cell is halved first: work stays near linear in its parts
constexpr std::size_t most_entries = std::size_t{1} << 24;

// A line with its inner side: what is kept of a cell.
class Cut {
 public:
  static Cut right_of(double x) { return {x, nullptr, 1}; }
  static Cut left_of(double x) { return {x, nullptr, -1}; }
  static Cut above(const Edge& e) { return {0, &e, 1}; }
  static Cut below(const Edge& e) { return {0, &e, -1}; }

  // Sign exact; size in proportion to the distance.
  [[nodiscard]] double operator()(const Corner& p) const {
    if (edge_ == nullptr) return sign_ * (p.x - x_);
    const Point2 at{p.x, p.y};
    const Point2 &a = edge_->a, &b = edge_->b;
    const int side = orientation(a, b, at);
    if (side == 0) return 0;
    const double size = std::fabs((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x));
    return sign_ * side * std::max(size, 1e-300);
  }

 private:
  Cut(double x, const Edge* edge, double sign) : x_(x), edge_(edge), sign_(sign) {}
  double x_;
  const Edge* edge_;
  double sign_;
};

// The same point from whichever end it is asked for: neighbours share it.
Corner crossing(Corner p, double at_p, Corner q, double at_q) {
  if (q.x < p.x || (q.x == p.x && q.y < p.y)) std::swap(p, q), std::swap(at_p, at_q);
  const double t = std::fabs(at_p) / (std::fabs(at_p) + std::fabs(at_q));
  const auto height = [t](double u, double v) {  // no piece rises above its cell, not by rounding either
    return std::clamp(u + t * (v - u), std::min(u, v), std::max(u, v));
  };
  return {p.x + t * (q.x - p.x), p.y + t * (q.y - p.y), height(p.z1, q.z1), height(p.z2, q.z2)};
}

enum class Side { inner, outer, both };

// Both parts of a cell along a line. Untouched (and `kept`, `dropped` not set) unless the line runs through it.
Side part(const ConvexCell& cell, const Cut& cut, ConvexCell& kept, ConvexCell& dropped) {
  std::array<double, ConvexCell::capacity> at;
  bool inner = false, outer = false;
  for (unsigned i = 0; i < cell.corners; ++i) {
    at[i] = cut(cell.at[i]);
    inner = inner || at[i] > 0;
    outer = outer || at[i] < 0;
  }
  if (!outer) return Side::inner;
  if (!inner) return Side::outer;
  kept.corners = dropped.corners = 0;
  for (unsigned i = 0; i < cell.corners; ++i) {
    const unsigned j = i + 1 == cell.corners ? 0 : i + 1;
    if (at[i] >= 0) kept.add(cell.at[i]);
    if (at[i] <= 0) dropped.add(cell.at[i]);
    if ((at[i] > 0 && at[j] < 0) || (at[i] < 0 && at[j] > 0)) {
      const Corner c = crossing(cell.at[i], at[i], cell.at[j], at[j]);
      kept.add(c);
      dropped.add(c);
    }
  }
  return Side::both;
}

std::array<Cut, 4> sides_of(const Trapezoid& t) {
  return {Cut::right_of(t.x0), Cut::left_of(t.x1), Cut::above(t.lower), Cut::below(t.upper)};
}

bool apart(const Box2& a, const Box2& b) {
  return a.max.x <= b.min.x || b.max.x <= a.min.x || a.max.y <= b.min.y || b.max.y <= a.min.y;
}

Box2 box_of(const Trapezoid& t) {
  Box2 box;
  for (const double x : {t.x0, t.x1})
    for (const Edge* e : {&t.lower, &t.upper}) box.add(Point2{x, height_at(*e, x)});
  // height_at is rounded: whoever touches this box in its last bit is asked exactly.
  const double slack = 4e-16 * std::max({std::fabs(box.min.y), std::fabs(box.max.y), box.max.y - box.min.y});
  box.min.y -= slack, box.max.y += slack;
  return box;
}

// Cuts through a cell with many corners, so that a further cut finds room.
bool nearly_full(const ConvexCell& cell) { return cell.corners + 5 > ConvexCell::capacity; }

void halve(const ConvexCell& cell, ConvexCell& first, ConvexCell& second) {
  const unsigned middle = cell.corners / 2;
  first.corners = second.corners = 0;
  for (unsigned i = 0; i <= middle; ++i) first.add(cell.at[i]);
  second.add(cell.at[0]);
  for (unsigned i = middle; i < cell.corners; ++i) second.add(cell.at[i]);
}

void append(const ConvexCell& cell, std::vector<ConvexCell>& to) {
  if (!nearly_full(cell)) {
    to.push_back(cell);
    return;
  }
  ConvexCell first, second;
  halve(cell, first, second);
  to.push_back(first);
  to.push_back(second);
}

}  // namespace

Box2 ConvexCell::box() const {
  Box2 b;
  for (unsigned i = 0; i < corners; ++i) b.add(Point2{at[i].x, at[i].y});
  return b;
}

double ConvexCell::area() const {
  double area = 0;
  for_triangles(*this, [&](double a, const Corner&, const Corner&, const Corner&) { area += a; });
  return area;
}

Regions::Regions(std::vector<Region> regions, std::size_t expected_cells) {
  for (std::size_t r = 0; r < regions.size(); ++r) {
    Sum area;
    for (const Trapezoid& t : regions[r].parts) {
      parts_.push_back({t, box_of(t), static_cast<Index>(r)});
      box_.add(parts_.back().box);
      area.add(area_of(t));
    }
    areas_.push_back(area.value());
  }
  if (parts_.empty()) return;
  make_grid(regions, expected_cells);
}

std::size_t Regions::column(double x) const {
  return static_cast<std::size_t>(std::clamp((x - box_.min.x) / width_, 0.0, static_cast<double>(columns_ - 1)));
}
std::size_t Regions::row(double y) const {
  return static_cast<std::size_t>(std::clamp((y - box_.min.y) / height_, 0.0, static_cast<double>(rows_ - 1)));
}

namespace {

// f(column, lowest y, highest y) of an edge in every column it passes, one more on either side for the rounding of
// column borders.
template <class Column, class F>
void for_columns(const Edge& e, double x0, double x1, const Column& column, double left, double width, F&& f) {
  const std::size_t last = column(x1 + width * 1e-6);
  for (std::size_t c = column(x0 - width * 1e-6); c <= last; ++c) {
    const double from = std::max(x0, left + (static_cast<double>(c) - 1e-6) * width);
    const double to = std::min(x1, left + (static_cast<double>(c) + 1 + 1e-6) * width);
    const double p = height_at(e, std::min(from, x1)), q = height_at(e, std::max(to, x0));
    f(c, std::min(p, q), std::max(p, q));
  }
}

}  // namespace

void Regions::make_grid(const std::vector<Region>& regions, std::size_t expected_cells) {
  const double whole_width = box_.max.x - box_.min.x, whole_height = box_.max.y - box_.min.y;
  double squares = std::clamp(static_cast<double>(expected_cells) / 2, 4096.0, 1048576.0);
  double boxes = 0;  // what all parts' boxes cover, in boxes of everything
  for (const Part& p : parts_)
    boxes += std::max(p.box.max.x - p.box.min.x, whole_width * 1e-4) / whole_width *
             std::max(p.box.max.y - p.box.min.y, whole_height * 1e-4) / whole_height;
  squares = std::clamp(squares, 1.0, std::max(1.0, static_cast<double>(most_entries) / std::max(boxes, 1.0)));
  const double side = std::sqrt(whole_width / squares) * std::sqrt(whole_height);
  columns_ = static_cast<std::size_t>(std::clamp(whole_width / side, 1.0, squares));
  rows_ = static_cast<std::size_t>(std::clamp(whole_height / side, 1.0, squares));
  width_ = whole_width / static_cast<double>(columns_);
  height_ = whole_height / static_cast<double>(rows_);

  const auto column_of = [this](double x) { return column(x); };
  // The grid only sorts: a square that an edge comes near by less than a millionth of it counts as met.
  std::vector<Index> met(columns_ * rows_, no_index);
  struct Square {
    std::size_t square;
    Entry entry;
  };
  std::vector<Square> all;
  std::vector<double> low(columns_), high(columns_);
  Index next = 0;
  for (std::size_t r = 0; r < regions.size(); ++r) {
    const auto mark = [&](std::size_t c, double y0, double y1) {
      const std::size_t last = row(y1 + height_ * 1e-6);
      for (std::size_t k = row(y0 - height_ * 1e-6); k <= last; ++k) met[k * columns_ + c] = static_cast<Index>(r);
    };
    for (Edge e : regions[r].edges) {
      if (e.a.x > e.b.x) std::swap(e.a, e.b);
      if (e.a.x == e.b.x) {
        for (std::size_t c = column(e.a.x - width_ * 1e-6); c <= column(e.a.x + width_ * 1e-6); ++c)
          mark(c, std::min(e.a.y, e.b.y), std::max(e.a.y, e.b.y));
        continue;
      }
      for_columns(e, e.a.x, e.b.x, column_of, box_.min.x, width_, mark);
    }
    for (; next < parts_.size() && parts_[next].region == r; ++next) {
      const Trapezoid& t = parts_[next].shape;
      const std::size_t first = column(t.x0 - width_ * 1e-6), last = column(t.x1 + width_ * 1e-6);
      for_columns(t.lower, t.x0, t.x1, column_of, box_.min.x, width_,
                  [&](std::size_t c, double y0, double) { low[c] = y0; });
      for_columns(t.upper, t.x0, t.x1, column_of, box_.min.x, width_,
                  [&](std::size_t c, double, double y1) { high[c] = y1; });
      for (std::size_t c = first; c <= last; ++c) {
        const std::size_t top = row(high[c] + height_ * 1e-6);
        for (std::size_t k = row(low[c] - height_ * 1e-6); k <= top; ++k)
          all.push_back({k * columns_ + c, {next, met[k * columns_ + c] != r}});
      }
    }
  }
  first_.assign(columns_ * rows_ + 1, 0);
  for (const Square& s : all) ++first_[s.square + 1];
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  entries_.resize(all.size());
  std::vector<std::size_t> at(first_.begin(), first_.end() - 1);
  for (const Square& s : all) entries_[at[s.square]++] = s.entry;
  sole_.assign(columns_ * rows_, no_index);
  for (std::size_t i = 0; i < sole_.size(); ++i) {
    if (first_[i] == first_[i + 1]) continue;
    const Index region = parts_[entries_[first_[i]].part].region;
    bool sole = true;
    for (std::size_t k = first_[i]; k < first_[i + 1]; ++k)
      sole = sole && entries_[k].covers && parts_[entries_[k].part].region == region;
    if (sole) sole_[i] = region;
  }
}

Index Regions::sole_cover(const Box2& box) const {
  if (parts_.empty() ||
      !(box.min.x >= box_.min.x && box.max.x <= box_.max.x && box.min.y >= box_.min.y && box.max.y <= box_.max.y))
    return no_index;
  const std::size_t c0 = column(box.min.x), c1 = column(box.max.x), r0 = row(box.min.y), r1 = row(box.max.y);
  const Index region = sole_[r0 * columns_ + c0];
  for (std::size_t r = r0; r <= r1 && region != no_index; ++r)
    for (std::size_t c = c0; c <= c1; ++c)
      if (sole_[r * columns_ + c] != region) return no_index;
  return region;
}

void Regions::find(const Box2& box, Scratch& s) const {
  s.found.clear();
  s.parts.clear();
  if (parts_.empty() || apart(box, box_)) return;
  const std::size_t c0 = column(box.min.x), c1 = column(box.max.x), r0 = row(box.min.y), r1 = row(box.max.y);
  // Beyond the grid nothing is covered.
  const bool within =
      box.min.x >= box_.min.x && box.max.x <= box_.max.x && box.min.y >= box_.min.y && box.max.y <= box_.max.y;
  s.hits.clear();
  for (std::size_t r = r0; r <= r1; ++r)
    for (std::size_t c = c0; c <= c1; ++c) {
      const std::size_t square = r * columns_ + c;
      for (std::size_t i = first_[square]; i < first_[square + 1]; ++i) {
        const Entry& e = entries_[i];
        s.hits.push_back({parts_[e.part].region, e.part, e.covers && within});
      }
    }
  const std::size_t squares = (c1 - c0 + 1) * (r1 - r0 + 1);
  // Of one square the entries are in the order of parts already.
  if (squares > 1)
    std::sort(s.hits.begin(), s.hits.end(), [](const auto& a, const auto& b) { return a.part < b.part; });
  for (std::size_t i = 0; i < s.hits.size();) {
    const Index region = s.hits[i].region, first = static_cast<Index>(s.parts.size());
    bool covers = within;
    std::size_t end = i;
    for (; end < s.hits.size() && s.hits[end].region == region; ++end) {
      covers = covers && s.hits[end].covers;
      const Index p = s.hits[end].part;
      if ((s.parts.size() == first || s.parts.back() != p) && !apart(parts_[p].box, box)) s.parts.push_back(p);
    }
    // No edge near any of the squares that hold it: then the region covers all of them if it is in all of them, and
    // neighbouring squares without an edge between them are both in or both out.
    if (covers || s.parts.size() > first)
      s.found.push_back({region, first, static_cast<Index>(s.parts.size()), covers});
    i = end;
  }
  if (squares > 1)
    for (Found& f : s.found)
      if (f.covers) {
        std::size_t covered = 0;  // squares of the box that hold an entry of the region
        for (std::size_t r = r0; r <= r1; ++r)
          for (std::size_t c = c0; c <= c1; ++c) {
            const std::size_t square = r * columns_ + c;
            covered += std::any_of(entries_.begin() + static_cast<std::ptrdiff_t>(first_[square]),
                                   entries_.begin() + static_cast<std::ptrdiff_t>(first_[square + 1]),
                                   [&](const Entry& e) { return parts_[e.part].region == f.region; })
                           ? 1
                           : 0;
          }
        f.covers = covered == squares;
      }
}

bool Regions::cut_to(const Trapezoid& t, const ConvexCell& cell, ConvexCell& inside, std::vector<ConvexCell>* rest) {
  ConvexCell current = cell, kept, dropped;
  const std::size_t before = rest != nullptr ? rest->size() : 0;
  for (const Cut& cut : sides_of(t)) {
    const Side side = part(current, cut, kept, dropped);
    if (side == Side::outer) {
      if (rest != nullptr) rest->resize(before);
      return false;
    }
    if (side == Side::inner) continue;
    if (rest != nullptr) rest->push_back(dropped);
    current = kept;
  }
  inside = current;
  return true;
}

Regions::Answer Regions::split_small(const ConvexCell& cell, Scratch& s, std::vector<ConvexCell>& inside,
                                     std::vector<ConvexCell>& outside) const {
  s.left.assign(1, cell);
  bool met = false;
  ConvexCell piece;
  for (const Index p : s.parts) {
    s.next.clear();
    for (const ConvexCell& c : s.left) {
      s.rest.clear();
      if (apart(c.box(), parts_[p].box) || !cut_to(parts_[p].shape, c, piece, &s.rest)) {
        s.next.push_back(c);
        continue;
      }
      met = true;
      append(piece, inside);
      for (const ConvexCell& r : s.rest) append(r, s.next);
    }
    std::swap(s.left, s.next);
    if (s.left.empty()) break;
  }
  if (!met) return Answer::none;
  outside.insert(outside.end(), s.left.begin(), s.left.end());
  return Answer::some;
}

Regions::Answer Regions::split(const ConvexCell& cell, Scratch& s, std::vector<ConvexCell>& inside,
                               std::vector<ConvexCell>& outside) const {
  const Box2 box = cell.box();
  if (sole_cover(box) != no_index) return Answer::all;
  find(box, s);
  if (s.found.empty()) return Answer::none;
  if (std::any_of(s.found.begin(), s.found.end(), [](const Found& f) { return f.covers; })) return Answer::all;
  const double width = box.max.x - box.min.x, height = box.max.y - box.min.y;
  const double x = box.min.x + width / 2, y = box.min.y + height / 2;
  const bool upright = height > width;
  const bool divisible = upright ? y > box.min.y && y < box.max.y : x > box.min.x && x < box.max.x;
  if (s.parts.size() <= many_parts || !divisible || nearly_full(cell)) return split_small(cell, s, inside, outside);
  const Edge middle{{box.min.x, y}, {box.max.x, y}};
  ConvexCell first, second;
  if (part(cell, upright ? Cut::above(middle) : Cut::right_of(x), first, second) != Side::both)
    return split_small(cell, s, inside, outside);
  Answer answers[2];
  for (const ConvexCell* half : {&first, &second}) {
    Answer& answer = answers[half == &first ? 0 : 1];
    answer = split(*half, s, inside, outside);
    if (answer == Answer::all) inside.push_back(*half);
    if (answer == Answer::none) outside.push_back(*half);
  }
  return Answer::some;
}

}  // namespace isopach
