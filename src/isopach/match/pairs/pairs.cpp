#include "isopach/match/pairs/pairs.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "isopach/base/median.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/distance/vectors.hpp"

namespace isopach {
namespace {

constexpr std::size_t query_block = 1024;
constexpr double least_overlap = 0.3;  // below it a small patch that happens to fit would win
constexpr double tukey_width = 4.685;  // 95 % efficient for normal residuals

/// How many of the shortest to keep, of lengths² in ascending order, where `all` were asked. The power of the share is
/// that for points in space [Phillips2007], section 4.
std::size_t least_frmsd(const Array<double>& length2, double all) {
  std::size_t best = length2.size();
  double least = std::numeric_limits<double>::infinity(), sum = 0;
  const auto first = static_cast<std::size_t>(least_overlap * static_cast<double>(length2.size()));
  for (std::size_t i = 0; i < length2.size(); ++i) {
    sum += length2[i];
    if (i < first) continue;
    const auto k = static_cast<double>(i + 1);
    const double share = k / all, value = std::sqrt(sum / k) / (share * share * share);
    if (value <= least) least = value, best = i + 1;
  }
  return best;
}

/// The first of the sizes in ascending order at which half of the weight is reached; reorders them. O(n).
double weighted_median(std::vector<std::pair<double, double>>& sizes) {
  if (sizes.empty()) return 0;
  Sum all, before;
  for (const auto& [size, weight] : sizes) all.add(weight);
  auto begin = sizes.begin(), end = sizes.end();
  while (end - begin > 1) {
    const auto middle = begin + (end - begin - 1) / 2;
    std::nth_element(begin, middle, end);
    Sum sum = before;
    for (auto i = begin; i <= middle; ++i) sum.add(i->second);
    if (sum.value() >= all.value() / 2)
      end = middle + 1;
    else
      begin = middle + 1, before = sum;
  }
  return begin->first;
}

/// Sorts numbers that are not negative: digit by digit of their bits, which ascend as they do. O(n).
void sort_sizes(Array<double>& values) {
  constexpr std::size_t few = 2048;
  constexpr unsigned digit = 11, digits = 6;
  if (values.size() < few) return std::sort(values.begin(), values.end());
  Array<std::uint64_t> from(values.size()), to(values.size());
  for (std::size_t i = 0; i < from.size(); ++i) from[i] = std::bit_cast<std::uint64_t>(values[i]);
  for (unsigned k = 0; k < digits; ++k) {
    std::array<std::size_t, (1u << digit) + 1> begin{};
    const auto bucket = [&](std::uint64_t bits) { return bits >> digit * k & ((1u << digit) - 1); };
    for (const std::uint64_t bits : from) ++begin[bucket(bits) + 1];
    for (std::size_t b = 1; b < begin.size(); ++b) begin[b] += begin[b - 1];
    for (const std::uint64_t bits : from) to[begin[bucket(bits)]++] = bits;
    from.swap(to);
  }
  for (std::size_t i = 0; i < from.size(); ++i) values[i] = std::bit_cast<double>(from[i]);
}

}  // namespace

PairSearch::PairSearch(const OrientedCloud& queries, const OrientedCloud& target, bool inverse)
    : queries_(queries),
      target_(target),
      made_(target.boxes ? nullptr : std::make_unique<BoxTree>(target.points)),
      boxes_(made_ ? made_.get() : target.boxes.get()),
      inverse_(inverse),
      memory_(queries.points.size()) {
  std::fill(memory_.begin(), memory_.end(), Memory{});
}

Point3 PairSearch::place_of(std::size_t query, const Motion& motion) const {
  return inverse_ ? motion.undo(queries_.points[query]) : motion.apply(queries_.points[query]);
}

/// `begin`: where to begin, if this query has no partner yet.
void PairSearch::look(std::size_t query, const Point3& place, Index begin) {
  Memory& m = memory_[query];
  if (m.partner != no_index) {
    // Any other point was at least `second` away from the old place, hence now second − moved or more.
    constexpr double slack = 1e-12;
    const double moved = length(place - m.place), now = length(place - target_.points[m.partner]);
    if (now < (m.second - moved) * (1 - slack)) return;
    begin = m.partner;
  }
  const BoxTree::Two two = boxes_->nearest_two(place, begin);
  m = {place, std::sqrt(two.second2), two.first};
}

Array<PairSearch::Candidate> PairSearch::candidates(const Motion& motion, std::size_t stride,
                                                    const IcpOptions& options) {
  const std::size_t n = (queries_.points.size() + stride - 1) / stride;
  Array<Candidate> found(n);
  const double least_cosine = std::cos(options.reject_normal * std::numbers::pi / 180);
  for_blocks(n, query_block, [&](std::size_t begin, std::size_t end) {
    Index partner = no_index;
    for (std::size_t k = begin; k < end; ++k) {
      const std::size_t i = k * stride;
      const Point3 place = place_of(i, motion);
      look(i, place, partner);  // neighbours have neighbours
      partner = memory_[i].partner;
      found[k] = {static_cast<Index>(i), partner, squared_length(place - target_.points[partner])};
      const Point3 normal = inverse_ ? motion.turn_back(queries_.normals[i]) : motion.turn(queries_.normals[i]);
      const double cosine = std::fabs(dot(normal, target_.normals[partner]));
      const bool wrong_side = options.reject_normal > 0 && cosine < least_cosine;
      if (wrong_side || (options.reject_boundary && target_.boundary[partner] != 0)) found[k].partner = no_index;
    }
  });
  found.erase(std::remove_if(found.begin(), found.end(), [](const Candidate& c) { return c.partner == no_index; }),
              found.end());
  return found;
}

Array<Link> PairSearch::find(const Motion& motion, std::size_t stride, const IcpOptions& options, double overlap) {
  Array<Candidate> pairs = candidates(motion, stride, options);
  const auto drop_longer = [&](double limit2) {
    pairs.erase(std::remove_if(pairs.begin(), pairs.end(), [&](const Candidate& c) { return c.length2 > limit2; }),
                pairs.end());
  };
  const auto lengths = [&] {
    Array<double> values(pairs.size());
    for (std::size_t i = 0; i < pairs.size(); ++i) values[i] = pairs[i].length2;
    return values;
  };
  if (options.reject_distance > 0 && !pairs.empty()) {
    const double times = options.reject_distance * options.reject_distance;
    Array<double> values = lengths();
    const double unit = inverse_ ? motion.scale : 1;
    drop_longer(options.reject_distance_absolute ? times / (unit * unit) : times * median(values));
  }
  if (options.one_to_one) {
    std::sort(pairs.begin(), pairs.end(), [](const Candidate& a, const Candidate& b) {
      if (a.partner != b.partner) return a.partner < b.partner;
      return a.length2 != b.length2 ? a.length2 < b.length2 : a.query < b.query;
    });
    pairs.erase(std::unique(pairs.begin(), pairs.end(),
                            [](const Candidate& a, const Candidate& b) { return a.partner == b.partner; }),
                pairs.end());
    std::sort(pairs.begin(), pairs.end(), [](const Candidate& a, const Candidate& b) { return a.query < b.query; });
  }
  if (overlap < 1 && !pairs.empty()) {
    Array<double> values = lengths();
    sort_sizes(values);
    const double all = std::ceil(static_cast<double>(queries_.points.size()) / static_cast<double>(stride));
    const std::size_t count =
        overlap > 0 ? std::min(values.size(), static_cast<std::size_t>(std::max(1.0, std::round(overlap * all))))
                    : least_frmsd(values, all);
    drop_longer(values[count - 1]);
  }
  Array<Link> links(pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Point3 &q = queries_.points[pairs[i].query], &t = target_.points[pairs[i].partner];
    const Point3& normal = target_.normals[pairs[i].partner];
    const bool alike = options.weights == IcpOptions::Weights::uniform;
    const double weight = alike ? 1 : queries_.areas[pairs[i].query];
    const Index query = pairs[i].query, partner = pairs[i].partner;
    const Point3& own = queries_.normals[query];
    links[i] = inverse_ ? Link{motion.apply(t), q, motion.turn(normal), weight, query, partner, own}
                        : Link{motion.apply(q), t, normal, weight, query, partner, motion.turn(own)};
  }
  return links;
}

Symmetric3 precision(const Link& l) {
  constexpr double both = 1 - plane_flatness;
  const Point3 &n = l.normal, &m = l.asking;
  const auto entry = [](double a, double b, double one) { return one - both * (a + b); };
  const double xx = entry(n.x * n.x, m.x * m.x, 2), yy = entry(n.y * n.y, m.y * m.y, 2),
               zz = entry(n.z * n.z, m.z * m.z, 2);
  const double xy = entry(n.x * n.y, m.x * m.y, 0), xz = entry(n.x * n.z, m.x * m.z, 0),
               yz = entry(n.y * n.z, m.y * m.z, 0);
  // The eigenvalues of C + D lie between 2ε and 2: the cofactors keep all but three or four digits.
  const double ax = yy * zz - yz * yz, ay = xz * yz - xy * zz, az = xy * yz - xz * yy;
  const double scale = 2 * plane_flatness / (xx * ax + xy * ay + xz * az);
  return {scale * ax,
          scale * ay,
          scale * az,
          scale * (xx * zz - xz * xz),
          scale * (xy * xz - xx * yz),
          scale * (xx * yy - xy * xy)};
}

Point3 pull(const Link& l, PairKind kind) {
  const Point3 d = l.moving - l.fixed;
  if (kind == PairKind::point) return d;
  return kind == PairKind::plane ? dot(d, l.normal) * l.normal : precision(l) * d;
}

double residual(const Link& l, PairKind kind) {
  const Point3 d = l.moving - l.fixed;
  if (kind == PairKind::point) return length(d);
  if (kind == PairKind::plane) return std::fabs(dot(d, l.normal));
  return std::sqrt(std::max(0.0, dot(d, precision(l) * d)));
}

double residual_width(const Array<Link>& links, PairKind kind) {
  std::vector<std::pair<double, double>> sizes(links.size());
  for (std::size_t i = 0; i < links.size(); ++i) sizes[i] = {residual(links[i], kind), links[i].weight};
  return tukey_width * mad_to_sigma * weighted_median(sizes);
}

void set_weights(Array<Link>& links, IcpOptions::Weights weights, PairKind kind) {
  if (weights == IcpOptions::Weights::uniform || links.empty()) return;
  const double width = residual_width(links, kind);
  if (!(width > 0)) return;  // half of them fit exactly: nothing tells good from bad
  for (Link& l : links) {
    const double t = residual(l, kind) / width;
    l.weight *= t < 1 ? (1 - t * t) * (1 - t * t) : 0;
  }
  links.erase(std::remove_if(links.begin(), links.end(), [](const Link& l) { return l.weight == 0; }), links.end());
}

}  // namespace isopach
