#include "isopach/measure/uncertainty/shrinkage.hpp"

#include <cmath>
#include <vector>

#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"

namespace isopach {

namespace {

constexpr std::size_t enough_stretches = 64;  // for the factor of a level; coarser levels take the last one

struct Stretch {
  double weight, mean, sample, square;  // square: variance of the mean, were the values independent
};

Stretch join(const Stretch& l, const Stretch& r) {
  const double weight = l.weight + r.weight;
  if (!(weight > 0)) return {0, 0, 0, 0};
  const double p = l.weight / weight, q = r.weight / weight;
  return {weight, p * l.mean + q * r.mean, p * l.sample + q * r.sample, p * p * l.square + q * q * r.square};
}

using Level = Array<Stretch>;

Level coarser(const Level& fine) {
  Level level((fine.size() + 1) / 2);
  for_each_index(level.size(), [&](std::size_t i) {
    level[i] = 2 * i + 1 < fine.size() ? join(fine[2 * i], fine[2 * i + 1]) : fine[2 * i];
  });
  return level;
}

// Variance of the means of a level over that of independent values, both weighed by area.
double correlation_factor(const Level& level) {
  struct Squares {
    Sum seen, expected;
  };
  const Squares s = reduce_blocks<Squares>(
      level.size(), default_block,
      [&](std::size_t begin, std::size_t end) {
        Squares part;
        for (std::size_t i = begin; i < end; ++i) {
          part.seen.add(level[i].weight * level[i].sample * level[i].sample);
          part.expected.add(level[i].weight * level[i].square);
        }
        return part;
      },
      [](Squares& total, const Squares& part) {
        total.seen.add(part.seen);
        total.expected.add(part.expected);
      });
  return s.expected.value() > 0 ? s.seen.value() / s.expected.value() : 1;
}

}  // namespace

Array<double> shrink(std::span<const double> value, std::span<const double> weight, std::span<const double> variance,
                     std::span<const double> sample, const Context& context) {
  context.check();
  const std::size_t n = value.size();
  std::vector<Level> levels(1);
  levels[0].resize(n);
  for_each_index(n, [&](std::size_t i) {
    levels[0][i] = weight[i] > 0 ? Stretch{weight[i], value[i], sample[i], variance[i]} : Stretch{0, 0, 0, 0};
  });
  while (levels.back().size() > 1) levels.push_back(coarser(levels.back()));

  std::vector<double> factor;
  for (const Level& level : levels)
    factor.push_back(level.size() >= enough_stretches || factor.empty() ? correlation_factor(level) : factor.back());

  const double universal = 2 * std::log(static_cast<double>(std::max<std::size_t>(n, 2)));
  Array<double> coarse(1);
  if (n > 0) coarse[0] = levels.back()[0].mean;
  for (std::size_t k = levels.size() - 1; k-- > 0;) {
    const Level& level = levels[k];
    Array<double> fine(level.size());
    for_each_index(coarse.size(), [&](std::size_t i) {
      if (2 * i + 1 >= level.size()) {
        fine[2 * i] = coarse[i];
        return;
      }
      const Stretch &l = level[2 * i], &r = level[2 * i + 1];
      const double sum = l.weight + r.weight;
      const bool is_known = l.weight > 0 && r.weight > 0;
      const double step = r.mean - l.mean;
      const bool stays = is_known && step * step > universal * factor[k] * (l.square + r.square);
      fine[2 * i] = stays ? coarse[i] - step * (r.weight / sum) : coarse[i];
      fine[2 * i + 1] = stays ? coarse[i] + step * (l.weight / sum) : coarse[i];
    });
    coarse = std::move(fine);
  }
  if (n == 0) coarse.clear();
  return coarse;
}

}  // namespace isopach
