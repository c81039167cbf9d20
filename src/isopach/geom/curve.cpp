#include "isopach/geom/curve.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

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

template <int Levels>  // the first Levels (a multiple of 4) levels of the key
inline std::uint64_t key_of(const Cell& c) {
  std::uint64_t key = 0;
  unsigned state = 0;
  for (int shift = 28; shift >= 32 - Levels; shift -= 4) {
    const unsigned input = ((c.x >> shift) & 15) << 4 | ((c.y >> shift) & 15);
    const Step step = steps[state][input];
    key = key << 8 | step.digits;
    state = step.state;
  }
  return key;
}

struct Item {
  std::uint32_t key;  // upper half of the curve key
  Index id;
};

// Stable counting sort of items by `bits` bits of the key from `shift` up. Blocks only split the work.
void radix_pass(const Array<Item>& from, Array<Item>& to, int shift, int bits) {
  const std::size_t n = from.size();
  const std::size_t buckets = std::size_t{1} << bits;
  const auto mask = static_cast<std::uint32_t>(buckets - 1);
  const std::size_t block = std::max<std::size_t>(n / 8 + 1, 1 << 16);
  const std::size_t blocks = (n + block - 1) / block;
  std::vector<std::size_t> start(blocks * buckets, 0);
  for_blocks(n, block, [&](std::size_t begin, std::size_t end) {
    std::size_t* count = start.data() + begin / block * buckets;
    for (std::size_t i = begin; i < end; ++i) ++count[(from[i].key >> shift) & mask];
  });
  std::size_t sum = 0;
  for (std::size_t d = 0; d < buckets; ++d)
    for (std::size_t b = 0; b < blocks; ++b) {
      const std::size_t count = start[b * buckets + d];
      start[b * buckets + d] = sum;
      sum += count;
    }
  for_blocks(n, block, [&](std::size_t begin, std::size_t end) {
    std::size_t* place = start.data() + begin / block * buckets;
    for (std::size_t i = begin; i < end; ++i) to[place[(from[i].key >> shift) & mask]++] = from[i];
  });
}

// The order within runs that the radix passes left equal: full key, then lexicographic, then id.
struct FullOrder {
  std::span<const Point2> points;
  const CurveBox& box;
  bool operator()(const Item& a, const Item& b) const {
    if (a.key != b.key) return a.key < b.key;
    const Point2 &p = points[a.id], &q = points[b.id];
    const std::uint64_t k = curve_key(box, p), l = curve_key(box, q);
    if (k != l) return k < l;
    if (p == q) return a.id < b.id;
    return lexicographic_less(p, q);
  }
};

// A long run (a far outlier leaves the rest of the points in few cells) is sorted by keys made once.
void sort_run(std::span<Item> run, const FullOrder& less) {
  constexpr std::size_t long_run = 32;
  if (run.size() <= long_run) {
    std::sort(run.begin(), run.end(), less);
    return;
  }
  struct Keyed {
    std::uint64_t key;
    Item item;
  };
  std::vector<Keyed> keyed(run.size());
  for (std::size_t i = 0; i < run.size(); ++i) keyed[i] = {curve_key(less.box, less.points[run[i].id]), run[i]};
  std::sort(keyed.begin(), keyed.end(),
            [&](const Keyed& a, const Keyed& b) { return a.key != b.key ? a.key < b.key : less(a.item, b.item); });
  for (std::size_t i = 0; i < run.size(); ++i) run[i] = keyed[i].item;
}

void sort_runs(Array<Item>& items, int unsorted_bits, const FullOrder& less) {
  const std::size_t n = items.size();
  const auto same_run = [&](std::size_t i, std::size_t j) {
    return (static_cast<std::uint64_t>(items[i].key) >> unsorted_bits) ==
           (static_cast<std::uint64_t>(items[j].key) >> unsorted_bits);
  };
  // A run belongs to the block it starts in. Where that is, is settled before any run is sorted: two blocks never touch
  // the same item.
  constexpr std::size_t block = std::size_t{1} << 16;
  std::vector<std::size_t> first((n + block - 1) / block + 1, n);
  for_blocks(first.size() - 1, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      std::size_t i = b * block;
      const std::size_t stop = std::min(n, i + block);
      while (i > 0 && i < stop && same_run(i, i - 1)) ++i;
      first[b] = i;
    }
  });
  for (std::size_t b = first.size() - 1; b-- > 0;)
    if (first[b] == std::min(n, (b + 1) * block)) first[b] = first[b + 1];  // no run starts here
  for_blocks(first.size() - 1, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b)
      for (std::size_t i = first[b], j = i; i < first[b + 1]; i = j) {
        for (j = i + 1; j < first[b + 1] && same_run(i, j);) ++j;
        if (j - i > 1) sort_run({items.data() + i, j - i}, less);
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

std::uint64_t curve_key(const CurveBox& box, const Point2& p) { return key_of<32>(cell_of(box, p)); }

Array<Index> curve_order(std::span<const Point2> points, const CurveBox& box, Array<std::uint64_t>* keys) {
  const std::size_t n = points.size();
  Array<Item> items(n), buffer(n);
  for_each_index(n, [&](std::size_t i) {
    items[i] = {static_cast<std::uint32_t>(key_of<16>(cell_of(box, points[i]))), static_cast<Index>(i)};
  });
  // Two passes over the most significant bits leave runs of about one point; the runs are then sorted on their own.
  const int pass = std::clamp((static_cast<int>(std::bit_width(n)) + 3) / 2, 4, 13);
  radix_pass(items, buffer, 32 - 2 * pass, pass);
  radix_pass(buffer, items, 32 - pass, pass);
  sort_runs(items, 32 - 2 * pass, FullOrder{points, box});
  Array<Index> order(n);
  for_each_index(n, [&](std::size_t i) { order[i] = items[i].id; });
  if (keys != nullptr) {
    keys->resize(n);
    for_each_index(n, [&](std::size_t i) { (*keys)[i] = curve_key(box, points[order[i]]); });
  }
  return order;
}

}  // namespace isopach
