#include "isopach/match/coarse/consensus.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "isopach/base/parallel.hpp"
#include "isopach/distance/vectors.hpp"
#include "isopach/match/pairs/least_squares.hpp"

namespace isopach {
namespace {

constexpr double length_slack = 1.0;  // in cubes: how far the mean of a cube is from the same place in another grid
constexpr double angle_slack = 0.25;  // of cosines
constexpr double least_length = 5;    // in cubes: nearer pairs hold no rotation
constexpr double together = 1.5;      // in cubes
constexpr std::size_t seed_partners = 30;
constexpr std::size_t least_partners = 4;
constexpr std::size_t row_block = 16;

/// Rows of bits.
class Relation {
 public:
  explicit Relation(std::size_t n) : n_(n), words_((n + 63) / 64), bits_(n * words_) {
    std::fill(bits_.begin(), bits_.end(), std::uint64_t{0});
  }
  void set(std::size_t i, std::size_t j) { bits_[i * words_ + j / 64] |= std::uint64_t{1} << (j % 64); }
  [[nodiscard]] bool has(std::size_t i, std::size_t j) const {
    return (bits_[i * words_ + j / 64] >> (j % 64) & 1) != 0;
  }
  [[nodiscard]] std::size_t common(std::size_t i, std::size_t j) const {
    std::size_t count = 0;
    for (std::size_t w = 0; w < words_; ++w)
      count += static_cast<std::size_t>(std::popcount(bits_[i * words_ + w] & bits_[j * words_ + w]));
    return count;
  }
  [[nodiscard]] std::size_t size() const { return n_; }

 private:
  std::size_t n_, words_;
  Array<std::uint64_t> bits_;
};

bool compatible(const Likeness& a, const Likeness& b, double side) {
  const Point3 p = b.moving - a.moving, q = b.fixed - a.fixed;
  const double lp = length(p), lq = length(q);
  if (lp < least_length * side || std::fabs(lp - lq) > length_slack * side) return false;
  const auto near = [](double x, double y) { return std::fabs(x - y) <= angle_slack; };
  return near(dot(a.moving_normal, p) / lp, dot(a.fixed_normal, q) / lq) &&
         near(dot(b.moving_normal, p) / lp, dot(b.fixed_normal, q) / lq) &&
         near(dot(a.moving_normal, b.moving_normal), dot(a.fixed_normal, b.fixed_normal));
}

Relation compatibility(const std::vector<Likeness>& pairs, double side) {
  Relation relation(pairs.size());
  for_blocks(pairs.size(), row_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t j = 0; j < pairs.size(); ++j)
        if (i != j && compatible(pairs[i], pairs[j], side)) relation.set(i, j);
  });
  return relation;
}

/// For each likeness Σ over its compatible ones of what both have in common.
std::vector<std::size_t> second_order(const Relation& relation) {
  std::vector<std::size_t> sums(relation.size(), 0);
  for_blocks(relation.size(), row_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t j = 0; j < relation.size(); ++j)
        if (relation.has(i, j)) sums[i] += relation.common(i, j);
  });
  return sums;
}

Motion fit(const std::vector<Likeness>& pairs, const std::vector<std::size_t>& chosen) {
  Array<Link> links;
  for (const std::size_t i : chosen) links.push_back({pairs[i].moving, pairs[i].fixed, pairs[i].fixed_normal, 1, 0});
  return point_step(links, pair_information(links, PairKind::point), false);
}

std::vector<std::size_t> brought_together(const std::vector<Likeness>& pairs, const Motion& motion, double side) {
  std::vector<std::size_t> found;
  const double limit = together * side;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (squared_length(motion.apply(pairs[i].moving) - pairs[i].fixed) <= limit * limit) found.push_back(i);
  return found;
}

/// The partners of a seed with the most in common with it, and the seed.
std::vector<std::size_t> partners_of(const Relation& relation, std::size_t seed) {
  std::vector<std::pair<std::size_t, std::size_t>> ranked;
  for (std::size_t j = 0; j < relation.size(); ++j)
    if (relation.has(seed, j)) ranked.emplace_back(relation.common(seed, j), j);
  std::sort(ranked.begin(), ranked.end(),
            [](const auto& a, const auto& b) { return a.first != b.first ? a.first > b.first : a.second < b.second; });
  if (ranked.size() > seed_partners) ranked.resize(seed_partners);
  std::vector<std::size_t> chosen{seed};
  for (const auto& [common, j] : ranked) chosen.push_back(j);
  return chosen;
}

}  // namespace

std::vector<Likeness> likenesses(const Landmarks& moving, const Landmarks& fixed, bool turned, std::size_t most,
                                 const Context& context) {
  context.check();
  const std::size_t n = moving.places.size(), m = fixed.places.size();
  std::vector<Likeness> found(n);
  std::vector<char> good(n, 0);
  for_blocks(n, row_block, [&](std::size_t begin, std::size_t end) {
    std::vector<float> differences;
    for (std::size_t i = begin; i < end; ++i) {
      if (squared_length(moving.normals[i]) == 0) continue;
      const SpinImage image = turned ? flipped(moving.images[i]) : moving.images[i];
      differences.clear();
      std::size_t best = m;
      for (std::size_t k = 0; k < m; ++k) {
        const float d = image_distance(image, fixed.images[k]);
        differences.push_back(d);
        if (squared_length(fixed.normals[k]) > 0 && (best == m || d < differences[best])) best = k;
      }
      if (best == m) continue;
      const float least = differences[best];
      const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(m / 2);
      std::nth_element(differences.begin(), middle, differences.end());
      if (!(*middle > 0)) continue;
      found[i] = {moving.places[i], fixed.places[best], (turned ? -1.0 : 1.0) * moving.normals[i], fixed.normals[best],
                  least / *middle};
      good[i] = 1;
    }
  });
  std::vector<Likeness> kept;
  for (std::size_t i = 0; i < n; ++i)
    if (good[i] != 0) kept.push_back(found[i]);
  std::stable_sort(kept.begin(), kept.end(),
                   [](const Likeness& a, const Likeness& b) { return a.difference < b.difference; });
  if (kept.size() > most) kept.resize(most);
  return kept;
}

std::vector<Agreement> agreements(const std::vector<Likeness>& pairs, double side, std::size_t most,
                                  const Context& context) {
  context.check();
  const Relation relation = compatibility(pairs, side);
  const std::vector<std::size_t> strength = second_order(relation);
  context.check();
  std::vector<std::size_t> seeds(pairs.size());
  std::iota(seeds.begin(), seeds.end(), std::size_t{0});
  std::stable_sort(seeds.begin(), seeds.end(), [&](std::size_t a, std::size_t b) { return strength[a] > strength[b]; });
  std::vector<Agreement> found;
  std::vector<char> explained(pairs.size(), 0);
  const std::size_t tries = 8 * most;
  std::size_t tried = 0;
  for (const std::size_t seed : seeds) {
    if (explained[seed] != 0) continue;
    if (tried++ == tries || strength[seed] == 0) break;
    std::vector<std::size_t> chosen = partners_of(relation, seed);
    if (chosen.size() < least_partners) continue;
    Agreement a;
    constexpr int rounds = 3;
    for (int i = 0; i < rounds && chosen.size() >= least_partners; ++i) {
      a.motion = fit(pairs, chosen);
      chosen = brought_together(pairs, a.motion, side);
    }
    a.support = chosen.size();
    if (a.support < least_partners) continue;
    for (const std::size_t i : chosen) explained[i] = 1;
    found.push_back(a);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Agreement& a, const Agreement& b) { return a.support > b.support; });
  if (found.size() > most) found.resize(most);
  return found;
}

}  // namespace isopach
