#include "isopach/geom/curve.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "isopach/base/parallel.hpp"

namespace isopach {

namespace {

// One step of the curve: the state says whether the square is turned (swap of axes) and inverted. Input two bits,
// output one base-4 digit and the next state; the table takes four steps at once.
struct Step {
  std::uint8_t digits;
  std::uint8_t state;  // already multiplied by 256: an offset into the table
};
using StepTable = std::array<std::array<Step, 256>, 4>;

constexpr StepTable make_steps() {
  StepTable table{};
  for (unsigned start = 0; start < 4; ++start)
    for (unsigned input = 0; input < 256; ++input) {
      unsigned swapped = start & 1, inverted = start >> 1, digits = 0;
      for (int bit = 3; bit >= 0; --bit) {
        unsigned x = ((input >> (4 + bit)) & 1) ^ inverted;
        unsigned y = ((input >> bit) & 1) ^ inverted;
        if (swapped != 0) {
          const unsigned t = x;
          x = y;
          y = t;
        }
        digits = digits << 2 | ((3 * x) ^ y);
        if (y == 0) {
          inverted ^= x;
          swapped ^= 1;
        }
      }
      table[start][input] = {static_cast<std::uint8_t>(digits), static_cast<std::uint8_t>(inverted << 1 | swapped)};
    }
  return table;
}
constexpr StepTable steps = make_steps();

struct Cell {
  std::uint32_t x, y;
};

inline std::uint32_t clamp_cell(double c) {
  return c > 0 ? (c < 4294967295.0 ? static_cast<std::uint32_t>(static_cast<std::uint64_t>(c)) : 4294967295U) : 0U;
}
inline Cell cell_of(const CurveBox& box, const Point2& p) {
  return {clamp_cell((p.x - box.min.x) * box.scale), clamp_cell((p.y - box.min.y) * box.scale)};
}

inline std::uint64_t key_of(const Cell& c) {
  std::uint64_t key = 0;
  unsigned state = 0;
  for (int shift = 28; shift >= 0; shift -= 4) {
    const unsigned input = ((c.x >> shift) & 15) << 4 | ((c.y >> shift) & 15);
    const Step step = steps[state][input];
    key = key << 8 | step.digits;
    state = step.state;
  }
  return key;
}

struct Item {
  std::uint64_t key;
  Index id;
};

// The whole order: by key, equal keys lexicographically, equal points by id.
struct FullOrder {
  std::span<const Point2> points;
  bool operator()(const Item& a, const Item& b) const {
    if (a.key != b.key) return a.key < b.key;
    const Point2 &p = points[a.id], &q = points[b.id];
    return p == q ? a.id < b.id : lexicographic_less(p, q);
  }
};

void insertion_sort(std::span<Item> items, const FullOrder& less) {
  for (std::size_t i = 1; i < items.size(); ++i) {
    const Item item = items[i];
    std::size_t j = i;
    for (; j > 0 && less(item, items[j - 1]); --j) items[j] = items[j - 1];
    items[j] = item;
  }
}

// A digit of the key: the highest bits in which a range of items differ at all, so that a range that fills a small part
// of the square (clusters, strips, a far outlier) is cut as finely as any other.
struct Digit {
  int shift, bits;
  [[nodiscard]] std::size_t operator()(std::uint64_t key) const {
    return static_cast<std::size_t>(key >> shift) & ((std::size_t{1} << bits) - 1);
  }
  [[nodiscard]] std::size_t values() const { return std::size_t{1} << bits; }
  Digit(std::uint64_t differences, int most_bits) {
    const int width = static_cast<int>(std::bit_width(differences));
    bits = std::min(width, most_bits);
    shift = width - bits;
  }
};

// Sorts a range small enough for the nearer caches: a pass by a digit, the rest by insertion where few items share it.
void sort_small(std::span<Item> items, std::vector<Item>& room, const FullOrder& less) {
  constexpr std::size_t few = 12;
  const std::size_t n = items.size();
  if (n <= few) return insertion_sort(items, less);
  std::uint64_t differences = 0;
  for (const Item& item : items) differences |= item.key ^ items[0].key;
  if (differences == 0) {
    std::sort(items.begin(), items.end(), less);
    return;
  }
  constexpr int most_bits = 10;
  const Digit digit(differences, std::clamp(static_cast<int>(std::bit_width(n)), 4, most_bits));
  std::array<std::uint32_t, (1U << most_bits) + 1> start{};
  for (const Item& item : items) ++start[digit(item.key) + 1];
  for (std::size_t d = 0; d < digit.values(); ++d) start[d + 1] += start[d];
  room.assign(items.begin(), items.end());
  std::uint32_t begin = 0;
  for (const Item& item : room) items[start[digit(item.key)]++] = item;  // start[d] becomes the end of d
  for (std::size_t d = 0; d < digit.values(); ++d) {
    const std::uint32_t end = start[d];
    if (end - begin > few) sort_small(items.subspan(begin, end - begin), room, less);
    begin = end;
  }
  insertion_sort(items, less);
}

// Sorts a large range: a stable pass by a digit, block by block, then every bucket on its own. Blocks and buckets
// depend on the items alone; they only split the work.
void sort_large(std::span<Item> items, std::span<Item> room, const FullOrder& less);

void sort_range(std::span<Item> items, std::span<Item> room, std::vector<Item>& small_room, const FullOrder& less) {
  constexpr std::size_t large = std::size_t{1} << 14;
  if (items.size() > large) return sort_large(items, room, less);
  sort_small(items, small_room, less);
}

void sort_large(std::span<Item> items, std::span<Item> room, const FullOrder& less) {
  const std::size_t n = items.size();
  const std::size_t block = std::max<std::size_t>(n / 16 + 1, std::size_t{1} << 14);
  const std::uint64_t differences = reduce_blocks<std::uint64_t>(
      n, block,
      [&](std::size_t begin, std::size_t end) {
        std::uint64_t some = 0;
        for (std::size_t i = begin; i < end; ++i) some |= items[i].key ^ items[0].key;
        return some;
      },
      [](std::uint64_t& total, std::uint64_t some) { total |= some; });
  if (differences == 0) {
    std::sort(items.begin(), items.end(), less);
    return;
  }
  const Digit digit(differences, std::clamp(static_cast<int>(std::bit_width(n)) - 9, 6, 11));
  const std::size_t values = digit.values(), blocks = (n + block - 1) / block;
  std::vector<std::size_t> place(blocks * values, 0);
  for_blocks(n, block, [&](std::size_t begin, std::size_t end) {
    std::size_t* count = place.data() + begin / block * values;
    for (std::size_t i = begin; i < end; ++i) {
      ++count[digit(items[i].key)];
      room[i] = items[i];
    }
  });
  std::vector<std::size_t> bucket(values + 1);
  std::size_t sum = 0;
  for (std::size_t d = 0; d < values; ++d) {
    bucket[d] = sum;
    for (std::size_t b = 0; b < blocks; ++b) {
      const std::size_t count = place[b * values + d];
      place[b * values + d] = sum;
      sum += count;
    }
  }
  bucket[values] = n;
  for_blocks(n, block, [&](std::size_t begin, std::size_t end) {
    std::size_t* to = place.data() + begin / block * values;
    for (std::size_t i = begin; i < end; ++i) items[to[digit(room[i].key)]++] = room[i];
  });
  for_blocks(values, 16, [&](std::size_t begin, std::size_t end) {
    std::vector<Item> small_room;
    for (std::size_t d = begin; d < end; ++d) {
      const std::size_t first = bucket[d], size = bucket[d + 1] - first;
      if (size > 1) sort_range(items.subspan(first, size), room.subspan(first, size), small_room, less);
    }
  });
}

}  // namespace

CurveBox curve_box(const Box2& box) {
  if (box.empty()) return {};
  const double extent = std::max(box.max.x - box.min.x, box.max.y - box.min.y);
  int exponent = 0;
  if (extent > 0) std::frexp(extent, &exponent);  // extent < 2^exponent
  return {box.min, std::ldexp(1.0, 32 - exponent)};
}

namespace {

// Doubles in their order as integers in theirs.
std::int64_t rank_of(double x) {
  const auto bits = std::bit_cast<std::int64_t>(x + 0.0);
  return bits < 0 ? std::numeric_limits<std::int64_t>::min() - bits : bits;
}
double of_rank(std::int64_t rank) {
  return std::bit_cast<double>(rank < 0 ? std::numeric_limits<std::int64_t>::min() - rank : rank);
}

/// The least double x with (x − min) · scale >= cell, as rounded: cells grow with x.
double least_of_cell(double min, double scale, double cell) {
  const double about = min + cell / scale, far = 4 / scale + 1e-9 * std::fabs(about);
  std::int64_t below = rank_of(about - far), at = rank_of(about + far);
  while (below + 1 < at) {
    const std::int64_t middle = std::midpoint(below, at);
    ((of_rank(middle) - min) * scale >= cell ? at : below) = middle;
  }
  return of_rank(at);
}

}  // namespace

OpenBox curve_square(const CurveBox& box, const Point2& p, int level) {
  OpenBox square;
  if (level == 0) return square;
  const Cell cell = cell_of(box, p);
  const int shift = 32 - level;
  const auto side = [&](double min, std::uint32_t c, double& low, double& high) {
    const std::uint64_t first = std::uint64_t{c} >> shift << shift, next = first + (std::uint64_t{1} << shift);
    if (first > 0) low = least_of_cell(min, box.scale, static_cast<double>(first));
    if (next < std::uint64_t{1} << 32) high = least_of_cell(min, box.scale, static_cast<double>(next));
  };
  side(box.min.x, cell.x, square.low.x, square.high.x);
  side(box.min.y, cell.y, square.low.y, square.high.y);
  return square;
}

std::uint64_t curve_key(const CurveBox& box, const Point2& p) { return key_of(cell_of(box, p)); }

Array<Index> curve_order(std::span<const Point2> points, const CurveBox& box, Array<std::uint64_t>* keys,
                         Array<Point2>* sorted) {
  const std::size_t n = points.size();
  Array<Item> items(n), room(n);
  for_each_index(n, [&](std::size_t i) { items[i] = {key_of(cell_of(box, points[i])), static_cast<Index>(i)}; });
  std::vector<Item> small_room;
  sort_range(items, room, small_room, FullOrder{points});
  Array<Item>().swap(room);
  Array<Index> order(n);
  if (keys != nullptr) keys->resize(n);
  if (sorted != nullptr) sorted->resize(n);
  for_blocks(n, default_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) order[i] = items[i].id;
    if (keys != nullptr)
      for (std::size_t i = begin; i < end; ++i) (*keys)[i] = items[i].key;
    if (sorted != nullptr)
      for (std::size_t i = begin; i < end; ++i) (*sorted)[i] = points[items[i].id];
  });
  return order;
}

}  // namespace isopach
