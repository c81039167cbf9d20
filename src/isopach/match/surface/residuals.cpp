#include "isopach/match/surface/residuals.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "isopach/base/median.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/match/surface/balance.hpp"
#include "isopach/match/surface/patch.hpp"

namespace isopach {

namespace {

constexpr double patch_bound = 4;            // scales of the patches' means
constexpr std::size_t cells_of_a_patch = 4;  // of the score, at least
constexpr std::size_t most_cells = 4096;     // of the score
constexpr double window = 0.4;               // of the bound of a share, to either side
constexpr std::size_t block = 4096;
static_assert(block % Residuals::largest_patch == 0);

void add_to(ResidualSums& total, const ResidualSums& part) {
  total.h.add(part.h);
  for (std::size_t k = 0; k < parameters; ++k) total.b[k] += part.b[k];
  total.area += part.area;
  total.trusted += part.trusted;
  total.loss += part.loss;
  total.fitted += part.fitted;
  total.volume += part.volume;
  total.within += part.within;
  total.squares += part.squares;
  total.curvature += part.curvature;
  total.bend += part.bend;
  total.nodes += part.nodes;
  total.visited += part.visited;
}

template <bool moving_nodes>
ResidualSums evaluate_block(ResidualSide& side, const View& view, const Evaluation& what, std::size_t patch,
                            std::size_t stride, std::size_t begin, std::size_t end) {
  ResidualSums sums;
  PatchRows rows((stride - 1) * patch);
  auto last = static_cast<Index>(begin * side.target->t.real / side.nodes->xy.size());  // both lie along one curve
  for (std::size_t first = begin; first < end; first += patch) {
    if (first / patch % stride != 0) continue;
    if (what.again)
      rows.recall(side, first, std::min(end, first + patch));
    else
      rows.gather<moving_nodes>(side, view, first, std::min(end, first + patch), last, sums.visited);
    rows.weigh(side, what.loss, first / patch, sums);
    if (what.equations) rows.add_equations<moving_nodes>(view, sums);
  }
  return sums;
}

ResidualSums evaluate_side(ResidualSide& side, const Motion& motion, const Evaluation& what, const Point3& centre,
                           double length, std::size_t patch, std::size_t stride) {
  const View view(side, motion, centre, length);
  return reduce_blocks<ResidualSums>(
      side.nodes->xy.size(), block,
      [&](std::size_t begin, std::size_t end) {
        return side.moving_nodes ? evaluate_block<true>(side, view, what, patch, stride, begin, end)
                                 : evaluate_block<false>(side, view, what, patch, stride, begin, end);
      },
      add_to);
}

// What noise of the heights adds to the information through the smoothed slope of a facet: n depends on the slope g
// through J = d(−g, 1)·motion, so that only its x and y parts carry noise. The mean of three slopes has at most the
// mean of their variances, as it has where the noise of all three is the same.
void add_slope_noise(const MatchSurface& s, const Array<SlopeNoise>& slopes, Index triangle, const Point3& arm,
                     double weight, Symmetric7& noise) {
  const auto& v = s.t.triangles[triangle].v;
  double xx = 0, xy = 0, yy = 0;
  for (const Index node : v) xx += slopes[node].xx / 3, xy += slopes[node].xy / 3, yy += slopes[node].yy / 3;
  const Vector7 along_x{0, -arm.z, arm.y, 1, 0, 0, arm.x}, along_y{arm.z, 0, -arm.x, 0, 1, 0, arm.y};
  Vector7 both_ways;
  for (std::size_t k = 0; k < parameters; ++k) both_ways[k] = along_x[k] + along_y[k];
  noise.add(along_x, weight * (xx - xy));
  noise.add(along_y, weight * (yy - xy));
  noise.add(both_ways, weight * xy);
}

Point3 normal_of(const Facet& f, double factor) { return {-f.smooth_gx * factor, -f.smooth_gy * factor, factor}; }

/// What each node of a side with a weight brings along: f(node, place there, facet, weight). `begin`: of a patch.
template <class F>
void for_fitted(const ResidualSide& side, const View& view, const Loss& loss, std::size_t patch, std::size_t begin,
                std::size_t end, const F& f) {
  const MatchSurface &nodes = *side.nodes, &target = *side.target;
  for (std::size_t first = begin; first < end; first += patch) {
    const double trust = side.trust[first / patch];
    for (std::size_t i = first; i < std::min(end, first + patch); ++i) {
      if (i + ahead < end && side.hint[i + ahead] < target.t.real) prefetch(&target.facets[side.hint[i + ahead]]);
      if (std::isnan(side.n[i])) continue;
      const double weight = side.weight(i) * facet_weight(target, side.hint[i]) * trust * weight_of(loss, side.n[i]);
      if (!(weight > 0)) continue;
      const Point3 own{nodes.xy[i].x, nodes.xy[i].y, nodes.z[i]};
      f(i, own, view.there(own), target.facets[side.hint[i]], weight);
    }
  }
}

template <bool moving_nodes>
Information information_of(const ResidualSide& side, const View& view, const Loss& loss, double noise,
                           const Array<SlopeNoise>& slopes, std::size_t patch, std::size_t begin, std::size_t end) {
  Information sum;
  for_fitted(side, view, loss, patch, begin, end,
             [&](std::size_t i, const Point3& own, const Point3& there, const Facet& f, double weight) {
               const double factor = side.factors()[side.hint[i]];
               sum.h.add(view.derivative<moving_nodes>(own, there, normal_of(f, factor), side.n[i]), weight);
               add_slope_noise(*side.target, slopes, side.hint[i], view.arm(moving_nodes ? there : own),
                               weight * noise * noise * factor * factor, sum.noise);
             });
  return sum;
}

/// By cell: `cell` nodes in a row of the moving scan, or over facets with such a first corner.
template <bool moving_nodes>
std::vector<ScoreCell> cells_of(const ResidualSide& side, const View& view, const Loss& loss, std::size_t patch,
                                std::size_t cell) {
  const std::size_t moving = moving_nodes ? side.nodes->xy.size() : side.target->xy.size();
  const int shift = std::countr_zero(cell);  // a power of two
  std::vector<ScoreCell> cells((moving + cell - 1) / cell);
  for_fitted(side, view, loss, patch, 0, side.n.size(),
             [&](std::size_t i, const Point3& own, const Point3& there, const Facet& f, double weight) {
               const Index at = side.hint[i];
               const Point3 normal = normal_of(f, side.factors()[at]);
               const Vector7 j = view.derivative<moving_nodes>(own, there, normal, side.n[i]);
               ScoreCell& c = cells[(moving_nodes ? i : side.target->t.triangles[at].v[0]) >> shift];
               for (std::size_t k = 0; k < parameters; ++k) c.score[k] -= weight * j[k] * side.n[i];
               c.information.add(j, weight);
               const Point3& place = moving_nodes ? there : own;
               c.weight += weight, c.x += weight * place.x, c.y += weight * place.y;
             });
  return cells;
}

}  // namespace

Residuals::Residuals(const MatchSurface& moving, const MatchSurface& fixed, const Point3& centre, double length)
    : centre_(centre), length_(length) {
  const std::size_t fewest = std::min(moving.xy.size(), fixed.xy.size());
  patch_ = largest_patch;
  while (patch_ > 1 && fewest / patch_ < 64) patch_ /= 2;
  sides_[0].nodes = sides_[1].target = &moving;
  sides_[1].nodes = sides_[0].target = &fixed;
  sides_[1].moving_nodes = false;
  for (ResidualSide& side : sides_) {
    const std::size_t n = side.nodes->xy.size();
    side.hint.assign(n, no_index);
    side.n.assign(n, std::numeric_limits<double>::quiet_NaN());
    side.row.resize(n);
    side.trust.assign((n + patch_ - 1) / patch_, 1.0);
    side.bend.assign(side.trust.size(), 0.0);
  }
}

Twist Residuals::twist(const Vector7& step) const {
  return {step[0] / length_, step[1] / length_, step[2] / length_, step[3], step[4], step[5], step[6] / length_};
}

ResidualSums Residuals::evaluate(const Motion& motion, const Evaluation& what, const Context& context) {
  context.check();
  ResidualSums parts[2];
  if (sides_[0].target->t.real == 0 || sides_[1].target->t.real == 0) return parts[0];
  both([&] { parts[0] = evaluate_side(sides_[0], motion, what, centre_, length_, patch_, stride_); },
       [&] { parts[1] = evaluate_side(sides_[1], motion, what, centre_, length_, patch_, stride_); });
  add_to(parts[0], parts[1]);
  return parts[0];
}

void Residuals::sample(std::size_t stride) {
  stride_ = stride;
  for (ResidualSide& side : sides_) std::fill(side.n.begin(), side.n.end(), std::numeric_limits<double>::quiet_NaN());
}

template <class Visit>
void Residuals::sizes_of(const Visit& visit) const {
  constexpr std::size_t enough = 20000;  // of each side: the median of these is good to a per cent
  for (std::size_t s = 0; s < 2; ++s) {
    const ResidualSide& side = sides_[s];
    const std::size_t stride = 1 + side.n.size() / stride_ / enough;
    std::size_t to_skip = 0;
    for (std::size_t p = 0; p < side.trust.size(); p += stride_) {
      if (!(side.trust[p] > 0)) continue;
      for (std::size_t i = p * patch_; i < std::min(side.n.size(), (p + 1) * patch_); ++i) {
        if (std::isnan(side.n[i])) continue;
        if (to_skip == 0) visit(s, i, std::fabs(side.n[i]));
        to_skip = to_skip == 0 ? stride - 1 : to_skip - 1;
      }
    }
  }
}

double Residuals::spread() const {
  std::vector<double> sizes;
  sizes_of([&](std::size_t, std::size_t, double size) { sizes.push_back(size); });
  return mad_to_sigma * median(sizes);
}

void Residuals::even_out() {
  constexpr std::size_t classes = 16, fewest = 400;
  const auto class_of = [](float cosine) {
    return std::min(classes - 1, static_cast<std::size_t>(cosine * static_cast<float>(classes)));
  };
  std::array<std::vector<double>, classes> sizes;
  std::vector<double> all;
  sizes_of([&](std::size_t s, std::size_t i, double size) {
    sizes[class_of(sides_[s].target->cosine[sides_[s].hint[i]])].push_back(size);
    all.push_back(size);
  });
  const double typical = median(all);
  if (!(typical > 0)) return;
  std::array<float, classes> shrink;
  float last = 1;  // steep classes are small: those with too few nodes take after the next flatter one
  for (std::size_t k = classes; k-- > 0;) {
    constexpr double most = 8;
    if (sizes[k].size() >= fewest) last = static_cast<float>(std::clamp(typical / median(sizes[k]), 1 / most, most));
    shrink[k] = last;
  }
  for (ResidualSide& side : sides_) {
    const Array<float>& cosine = side.target->cosine;
    side.factor.resize(cosine.size());
    for_each_index(cosine.size(), [&](std::size_t f) { side.factor[f] = cosine[f] * shrink[class_of(cosine[f])]; });
  }
}

void Residuals::balance(const Motion& motion) {
  isopach::balance(sides_, {View(sides_[0], motion, centre_, length_), View(sides_[1], motion, centre_, length_)},
                   patch_);
}

bool Residuals::fitted(std::size_t i, const Loss& loss) const {
  const double n = sides_[0].n[i];
  return !std::isnan(n) && sides_[0].trust[i / patch_] * weight_of(loss, n) > 0;
}

std::vector<Residuals::PatchMean> Residuals::patch_means() const {
  std::vector<PatchMean> means;
  for (std::size_t s = 0; s < 2; ++s) {
    const ResidualSide& side = sides_[s];
    for (std::size_t p = 0; p < side.trust.size(); p += stride_) {
      PatchMean m{0, 0, s, p};
      std::size_t count = 0;
      const std::size_t end = std::min(side.n.size(), (p + 1) * patch_);
      for (std::size_t i = p * patch_; i < end; ++i) {
        if (std::isnan(side.n[i])) continue;
        m.mean += side.weight(i) * side.n[i];
        m.area += side.weight(i);
        ++count;
      }
      if (count == 0) continue;
      m.mean /= m.area;
      if (count < patch_ / 2) m.mean *= std::sqrt(static_cast<double>(2 * count) / static_cast<double>(patch_));
      means.push_back(m);
    }
  }
  return means;
}

void Residuals::trust_all() {
  for (ResidualSide& side : sides_) {
    std::fill(side.trust.begin(), side.trust.end(), 1.0);
    std::fill(side.bend.begin(), side.bend.end(), 0.0);
  }
}

void Residuals::trust_by_mean() {
  std::vector<PatchMean> means = patch_means();
  if (means.empty()) return;
  std::vector<double> sizes;
  for (const PatchMean& m : means) sizes.push_back(std::fabs(m.mean));
  const double bound = patch_bound * mad_to_sigma * median(sizes);
  for (const PatchMean& m : means) {
    const double u = bound > 0 ? m.mean / bound : (m.mean == 0 ? 0 : 1), v = 1 - u * u;
    sides_[m.side].trust[m.patch] = v > 0 ? v * v : 0;
    sides_[m.side].bend[m.patch] = v > 0 ? -4 * u * u * v : 0;
  }
}

void Residuals::trust_share(double share) {
  std::vector<PatchMean> means = patch_means();
  double all = 0, used = 0;
  for (const PatchMean& m : means) all += m.area;
  std::sort(means.begin(), means.end(), [](const PatchMean& a, const PatchMean& b) {
    const double x = std::fabs(a.mean), y = std::fabs(b.mean);
    return x < y || (x == y && (a.side < b.side || (a.side == b.side && a.patch < b.patch)));
  });
  double bound = 0;
  for (const PatchMean& m : means) {
    const bool is_used = used < share * all;
    sides_[m.side].trust[m.patch] = is_used ? 1 : 0;
    if (is_used) bound = std::fabs(m.mean);
    used += m.area;
  }
  // A motion takes patches over the bound in and out: what trust has there, a step at the bound, as a mean of patches
  // around it.
  for (const PatchMean& m : means) {
    const double mean = std::fabs(m.mean);
    const bool is_near = share < 1 && std::fabs(mean - bound) < window * bound;
    sides_[m.side].bend[m.patch] = is_near ? -mean / (2 * window * bound) : 0;
  }
}

Information Residuals::information(const Motion& motion, const Loss& loss, const std::array<double, 2>& noises,
                                   const Context& context) const {
  context.check();
  Information total;
  const auto add = [](Information& sum, const Information& part) {
    sum.h.add(part.h);
    sum.noise.add(part.noise);
  };
  for (const ResidualSide& side : sides_) {
    const View view(side, motion, centre_, length_);
    const Array<SlopeNoise> slopes = slope_noise(*side.target);
    const double noise = noises[side.moving_nodes ? 1 : 0];  // of the facets
    add(total, reduce_blocks<Information>(
                   side.nodes->xy.size(), block,
                   [&](std::size_t begin, std::size_t end) {
                     return side.moving_nodes
                                ? information_of<true>(side, view, loss, noise, slopes, patch_, begin, end)
                                : information_of<false>(side, view, loss, noise, slopes, patch_, begin, end);
                   },
                   add));
  }
  return total;
}

std::vector<ScoreCell> Residuals::score_cells(const Motion& motion, const Loss& loss, const Context& context) const {
  context.check();
  const std::size_t moving = sides_[0].nodes->xy.size(), fixed = sides_[1].nodes->xy.size();
  std::size_t cell = std::max<std::size_t>(1, patch_ / cells_of_a_patch);
  while (2 * cell * fixed < moving * patch_ / cells_of_a_patch) cell *= 2;  // not less of the sparser scan
  while (moving / cell > most_cells) cell *= 2;
  std::vector<ScoreCell> a, b;
  both([&] { a = cells_of<true>(sides_[0], View(sides_[0], motion, centre_, length_), loss, patch_, cell); },
       [&] { b = cells_of<false>(sides_[1], View(sides_[1], motion, centre_, length_), loss, patch_, cell); });
  for (std::size_t c = 0; c < a.size(); ++c) {
    for (std::size_t k = 0; k < parameters; ++k) a[c].score[k] += b[c].score[k];
    a[c].information.add(b[c].information);
    a[c].weight += b[c].weight, a[c].x += b[c].x, a[c].y += b[c].y;
  }
  return a;
}

}  // namespace isopach
