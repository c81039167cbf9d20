#include "isopach/measure/changes/changes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "isopach/measure/volume/totals.hpp"

namespace isopach {
namespace {

constexpr std::size_t check_every = 1 << 12;  // cells

/// Sets of triangles, by the least of each.
class Sets {
 public:
  explicit Sets(std::size_t n) : parent_(n) {
    for (std::size_t i = 0; i < n; ++i) parent_[i] = static_cast<Index>(i);
  }
  [[nodiscard]] Index find(Index i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(Index i, Index j) {
    i = find(i), j = find(j);
    if (i != j) parent_[std::max(i, j)] = std::min(i, j);
  }

 private:
  std::vector<Index> parent_;
};

/// How far d, of one sign, exceeds the level.
class Excess {
 public:
  Excess(const CellView& cells, const ChangeLevel& level, int sign) : cells_(cells), level_(level), sign_(sign) {}
  [[nodiscard]] double at(Index node) const { return sign_ * cells_.d(node) - level_.at(node); }
  [[nodiscard]] std::array<double, 3> at_corners(const CommonCell& c) const {
    const auto lod = level_.at_corners(c);
    const auto d = c.cell().d;
    return {sign_ * d[0] - lod[0], sign_ * d[1] - lod[1], sign_ * d[2] - lod[2]};
  }
  [[nodiscard]] int sign() const { return sign_; }

 private:
  const CellView& cells_;
  const ChangeLevel& level_;
  int sign_;
};

bool any_positive(const std::array<double, 3>& s) { return s[0] > 0 || s[1] > 0 || s[2] > 0; }

/// By item the least triangle of its object, or no_index.
std::vector<Index> label(const CellView& cells, const Excess& excess, const Context& context) {
  const std::size_t whole = cells.t.real;
  std::vector<unsigned char> has(whole, 0);
  std::vector<Index> of_item(items_of(cells), no_index);
  for_common(cells, 0, items_of(cells), [&](const CommonCell& c, std::size_t item) {
    if (item % check_every == 0) context.check();
    if (!any_positive(excess.at_corners(c))) return;
    has[c.triangle] = 1;
    of_item[item] = c.triangle;
  });
  Sets sets(whole);
  for (std::size_t i = 0; i < whole; ++i) {
    if (has[i] == 0) continue;
    const Triangle& t = cells.t.triangles[i];
    for (Index k = 0; k < 3; ++k) {
      const Index j = triangle_of(t.n[k]);
      if (j > i || cells.t.is_ghost(j) || has[j] == 0) continue;
      if (excess.at(t.v[k]) > 0 || excess.at(t.v[next_side(k)]) > 0) sets.unite(static_cast<Index>(i), j);
    }
  }
  for (Index& object : of_item)
    if (object != no_index) object = sets.find(object);
  return of_item;
}

/// Numbers them from 0 on, in the order of the items; how many there are.
Index number_objects(std::vector<Index>& of_item) {
  std::vector<Index> number(of_item.size(), no_index);
  Index count = 0;
  for (Index& object : of_item) {
    if (object == no_index) continue;
    Index& n = number[object];
    if (n == no_index) n = count++;
    object = n;
  }
  return count;
}

struct ChangeScales {
  SumScales sums;
  FixedScale moment;
  explicit ChangeScales(const SumBounds& b, double reach) : sums(b), moment{b.area, reach} {}
};

struct ChangeSums {
  FixedSum volume, area, x, y;
  double largest = 0;
  Point2 largest_at{HUGE_VAL, HUGE_VAL};

  explicit ChangeSums(const ChangeScales& s) : volume(s.sums.volume), area(s.sums.area), x(s.moment), y(s.moment) {}
  void look_at(double d, const Point2& at) {
    const bool same = d == largest && (at.x != largest_at.x ? at.x < largest_at.x : at.y < largest_at.y);
    if (d > largest || same) largest = d, largest_at = at;
  }
};

/// A corner of the part of a cell beyond the level.
struct PartCorner {
  Point2 at;
  double d;
};

/// Where a side from p to q, which have excesses of different signs, crosses the level; the same from either end.
PartCorner crossing(const PartCorner& p, double sp, const PartCorner& q, double sq) {
  const bool swapped = q.at.x != p.at.x ? q.at.x < p.at.x : q.at.y < p.at.y;
  const PartCorner &a = swapped ? q : p, &b = swapped ? p : q;
  const double sa = swapped ? sq : sp, sb = swapped ? sp : sq, share = sa / (sa - sb);
  return {{a.at.x + share * (b.at.x - a.at.x), a.at.y + share * (b.at.y - a.at.y)}, a.d + share * (b.d - a.d)};
}

/// The part of a triangle beyond the level: its corners in turn, and the side of the triangle that leads from each to
/// the next, 3 for the line of the level.
struct Part {
  std::array<PartCorner, 4> at;
  std::array<unsigned, 4> side;
  unsigned corners = 0;
  void add(const PartCorner& c, unsigned s) { at[corners] = c, side[corners++] = s; }
};

Part part_beyond(const std::array<PartCorner, 3>& at, const std::array<double, 3>& s) {
  Part part;
  for (unsigned k = 0; k < 3; ++k) {
    const unsigned next = k == 2 ? 0 : k + 1, last = k == 0 ? 2 : k - 1;
    if (s[k] > 0) {
      part.add(at[k], k);
      if (s[next] < 0) part.add(crossing(at[k], s[k], at[next], s[next]), 3);
    } else if (s[k] < 0) {
      if (s[next] > 0) part.add(crossing(at[k], s[k], at[next], s[next]), k);
    } else if (s[next] > 0 || s[last] > 0) {
      part.add(at[k], s[next] > 0 ? k : 3);
    }
  }
  return part;
}

std::array<PartCorner, 3> corners_of(const CommonCell& c, int sign) {
  std::array<PartCorner, 3> at{};
  for (std::size_t k = 0; k < 3; ++k) {
    const Corner corner = c.corner(k);
    at[k] = {{corner.x, corner.y}, sign * corner.d()};
  }
  return at;
}

void add_cell(const CommonCell& c, const Excess& excess, ChangeSums& sums) {
  const Cell cell = c.cell();
  const auto s = excess.at_corners(c);
  const auto shares = positive_shares(s);
  const auto at = corners_of(c, excess.sign());
  // As detect() has it, so that the sums are those of the whole.
  sums.volume.add(cell.area * excess.sign() * (shares[0] * cell.d[0] + shares[1] * cell.d[1] + shares[2] * cell.d[2]));
  sums.area.add(cell.area * (shares[0] + shares[1] + shares[2]));
  sums.x.add(cell.area * (shares[0] * at[0].at.x + shares[1] * at[1].at.x + shares[2] * at[2].at.x));
  sums.y.add(cell.area * (shares[0] * at[0].at.y + shares[1] * at[1].at.y + shares[2] * at[2].at.y));
  const Part part = part_beyond(at, s);
  for (unsigned k = 0; k < part.corners; ++k) sums.look_at(part.at[k].d, part.at[k].at);
}

Change change_of(const ChangeSums& sums, bool gained) {
  Change change;
  change.gained = gained;
  change.volume = sums.volume.value(), change.area = sums.area.value();
  change.largest = sums.largest, change.largest_at = sums.largest_at;
  if (change.area > 0) {
    change.mean = change.volume / change.area;
    change.centroid = {sums.x.value() / change.area, sums.y.value() / change.area};
  }
  return change;
}

bool before(const Change& a, const Change& b) {
  if (a.volume != b.volume) return a.volume > b.volume;
  if (a.largest_at.x != b.largest_at.x) return a.largest_at.x < b.largest_at.x;
  if (a.largest_at.y != b.largest_at.y) return a.largest_at.y < b.largest_at.y;
  return a.area != b.area ? a.area > b.area : a.gained > b.gained;
}

/// Objects of one sign, added to what is found of both.
class Sorter {
 public:
  Sorter(const ChangeOptions& options, double min_area, const ChangeScales& scales)
      : options_(options),
        min_area_(min_area),
        all_{FixedSum(scales.sums.volume), FixedSum(scales.sums.volume), FixedSum(scales.sums.area)},
        small_(all_) {}

  void add(const std::vector<ChangeSums>& sums, bool gained) {
    first_[gained ? 0 : 1] = number_.size();
    for (const ChangeSums& s : sums) {
      add_to(all_, s, gained);
      Change change = change_of(s, gained);
      const bool is_small = change.volume < options_.min_volume || change.area < min_area_ || !(change.area > 0);
      number_.push_back(is_small ? no_index : static_cast<Index>(list_.size()));
      if (!is_small) {
        list_.push_back(change);
        continue;
      }
      add_to(small_, s, gained);
      ++(gained ? found_.small.gained : found_.small.lost);
    }
  }

  /// Gives the list in order, and by sign and object as they were numbered the places in it.
  [[nodiscard]] Changes sorted(std::array<std::vector<Index>, 2>& object_of) {
    std::vector<Index> order(list_.size()), place(list_.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<Index>(i);
    std::sort(order.begin(), order.end(), [&](Index i, Index j) { return before(list_[i], list_[j]); });
    for (std::size_t i = 0; i < order.size(); ++i) {
      place[order[i]] = static_cast<Index>(i);
      found_.list.push_back(list_[order[i]]);
    }
    for (std::size_t sign = 0; sign < 2; ++sign)
      for (Index& object : object_of[sign]) {
        if (object == no_index) continue;
        const Index n = number_[first_[sign] + object];
        object = n == no_index ? no_index : place[n];
      }
    found_.all = value_of(all_), found_.small.sum = value_of(small_);
    found_.level = options_.height, found_.min_area = min_area_;
    return std::move(found_);
  }

 private:
  using Three = std::array<FixedSum, 3>;  // above, below, area
  static void add_to(Three& to, const ChangeSums& s, bool gained) {
    to[gained ? 0 : 1].add(s.volume);
    to[2].add(s.area);
  }
  static Detected value_of(const Three& s) { return {s[0].value(), s[1].value(), s[2].value()}; }

  const ChangeOptions& options_;
  double min_area_;
  Three all_, small_;
  std::vector<Change> list_;
  std::vector<Index> number_;
  std::array<std::size_t, 2> first_{};
  Changes found_;
};

/// Sides of the part of a cell that bound its object.
void add_sides(const CommonCell& c, const Excess& excess, const std::vector<unsigned char>& clipped,
               OutlineBuilder& outline) {
  std::array<PartCorner, 3> at = corners_of(c, excess.sign());
  std::array<double, 3> s = excess.at_corners(c);
  if (c.piece != nullptr) {
    const Part part = part_beyond(at, s);
    for (unsigned k = 0; k < part.corners; ++k)
      outline.add_loose({part.at[k].at, part.at[(k + 1) % part.corners].at}, false);
    return;
  }
  const Triangle& t = c.cells.t.triangles[c.triangle];
  for (Index k = 0; k < 3; ++k) {  // as the triangle is written, so that sides have its numbers
    at[k] = {c.cells.xy[t.v[k]], excess.sign() * c.cells.d(t.v[k])};
    s[k] = excess.at(t.v[k]);
  }
  const Part part = part_beyond(at, s);
  for (unsigned k = 0; k < part.corners; ++k) {
    const OutlineSide side{part.at[k].at, part.at[(k + 1) % part.corners].at};
    if (part.side[k] == 3) {
      outline.add(side);
      continue;
    }
    const Index other = triangle_of(t.n[part.side[k]]);
    if (c.cells.t.is_ghost(other) || (c.cells.in_domain[other] == 0 && clipped[other] == 0))
      outline.add(side);
    else if (clipped[other] != 0)
      outline.add_loose(side, true);
  }
}

void draw_outlines(const CellView& cells, const ChangeLevel& level, FoundChanges& found, const Context& context) {
  std::vector<unsigned char> clipped(cells.t.real, 0);
  for (const CellPiece& piece : cells.pieces) clipped[piece.cell] = 1;
  for (std::size_t sign = 0; sign < 2; ++sign) {
    const Excess excess(cells, level, sign == 0 ? 1 : -1);
    std::vector<std::vector<std::size_t>> items(found.changes.list.size());
    for (std::size_t item = 0; item < found.object_of[sign].size(); ++item)
      if (const Index object = found.object_of[sign][item]; object != no_index) items[object].push_back(item);
    for (std::size_t object = 0; object < items.size(); ++object) {
      if (items[object].empty()) continue;
      context.check();
      OutlineBuilder outline;
      for (const std::size_t item : items[object]) add_sides(of_item(cells, item), excess, clipped, outline);
      found.changes.list[object].outline = outline.polygons();
    }
  }
}

}  // namespace

double reach_of(std::span<const Point2> xy) {
  double reach = 0;
  for (const Point2& p : xy) reach = std::max({reach, std::fabs(p.x), std::fabs(p.y)});
  return reach;
}

FoundChanges find_changes(const CellView& cells, const ChangeLevel& level, const ChangeOptions& options,
                          double min_area, const Context& context) {
  return find_changes(cells, level, options, min_area, reach_of(cells.xy), context);
}

FoundChanges find_changes(const CellView& cells, const ChangeLevel& level, const ChangeOptions& options,
                          double min_area, double reach, const Context& context) {
  context.check();
  FoundChanges found;
  const ChangeScales scales(bounds_of(cells), reach);
  Sorter sorter(options, min_area, scales);
  for (std::size_t sign = 0; sign < 2; ++sign) {
    const Excess excess(cells, level, sign == 0 ? 1 : -1);
    std::vector<Index>& object_of = found.object_of[sign];
    object_of = label(cells, excess, context);
    std::vector<ChangeSums> sums(number_objects(object_of), ChangeSums(scales));
    for_common(cells, 0, items_of(cells), [&](const CommonCell& c, std::size_t item) {
      if (item % check_every == 0) context.check();
      if (object_of[item] != no_index) add_cell(c, excess, sums[object_of[item]]);
    });
    sorter.add(sums, sign == 0);
  }
  found.changes = sorter.sorted(found.object_of);
  draw_outlines(cells, level, found, context);
  return found;
}

}  // namespace isopach
