#include "isopach/match/residuals.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "isopach/base/parallel.hpp"
#include "isopach/base/prefetch.hpp"
#include "isopach/geom/predicates.hpp"
#include "isopach/overlay/localise.hpp"

namespace isopach {

namespace {

constexpr double huber_bound = 1.345, tukey_bound = 4.685;
constexpr double patch_bound = 4;           // scales of the patches' means
constexpr double median_to_sigma = 1.4826;  // of a normal distribution
constexpr std::size_t block = 4096;
static_assert(block % Residuals::largest_patch == 0);

/// Loss and weight (its derivative over n).
struct Valued {
  double loss, weight;
};
Valued value(const Loss& loss, double n) {
  if (loss.kind == Loss::Kind::huber) {
    const double k = huber_bound * loss.scale, a = std::fabs(n);
    if (a <= k) return {0.5 * n * n, 1};
    return {k * (a - 0.5 * k), k / a};
  }
  const double c = tukey_bound * loss.scale, most = c * c / 6, u2 = n * n / (c * c), v = 1 - u2;
  if (v <= 0) return {most, 0};
  return {most * (1 - v * v * v), v * v};
}

/// Nodes of one side as the other surface sees them, and back; the derivatives of residuals there.
struct View {
  View(const ResidualSide& side, const Motion& motion, const Point3& middle, double length)
      : centre(middle), inverse_length(1 / length), turn(motion.rotation) {
    const auto& r = motion.rotation;
    const double s = motion.scale, w = 1 / motion.scale;
    const Point3& t = motion.shift;
    if (side.moving_nodes) {
      m = {s * r[0], s * r[1], s * r[2], t.x, s * r[3], s * r[4], s * r[5], t.y, s * r[6], s * r[7], s * r[8], t.z};
    } else {
      const Point3 back = motion.undo({0, 0, 0});
      m = {w * r[0], w * r[3], w * r[6], back.x,   w * r[1], w * r[4],
           w * r[7], back.y,   w * r[2], w * r[5], w * r[8], back.z};
      size = s;
    }
  }
  [[nodiscard]] Point3 there(const Point3& p) const {
    return {m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3], m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
            m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]};
  }
  [[nodiscard]] Point3 arm(const Point3& place) const {
    return {(place.x - centre.x) * inverse_length, (place.y - centre.y) * inverse_length,
            (place.z - centre.z) * inverse_length};
  }
  /// By the scaled parameters, of the residual n of a node at `own`, `there` in the other surface's coordinates, over a
  /// facet with this normal.
  template <bool moving_nodes>
  [[nodiscard]] Vector7 derivative(const Point3& own, const Point3& there, const Point3& normal, double n) const {
    if constexpr (moving_nodes) {
      const Point3 a = arm(there);
      return along(a, normal, 1);
    } else {  // the surface moves under the node; what grows is the surface
      const auto& r = turn;
      const Point3 turned{r[0] * normal.x + r[1] * normal.y + r[2] * normal.z,
                          r[3] * normal.x + r[4] * normal.y + r[5] * normal.z,
                          r[6] * normal.x + r[7] * normal.y + r[8] * normal.z};
      Vector7 j = along(arm(own), turned, -1);
      j[6] += n * inverse_length;
      return j;
    }
  }

  Point3 centre;
  double inverse_length, size = 1;  // size: of lengths in the fixed scan over those in the surface's own
  std::array<double, 9> turn;
  std::array<double, 12> m;

 private:
  static Vector7 along(const Point3& arm, const Point3& normal, double sign) {
    return {sign * (arm.y * normal.z - arm.z * normal.y),
            sign * (arm.z * normal.x - arm.x * normal.z),
            sign * (arm.x * normal.y - arm.y * normal.x),
            sign * normal.x,
            sign * normal.y,
            sign * normal.z,
            sign * (arm.x * normal.x + arm.y * normal.y + arm.z * normal.z)};
  }
};

/// Where the node is: the triangle from which it was not seen to be outside goes first, without a call.
bool locate_again(const MatchSurface& target, const Point2& q, Index& hint, std::uint64_t& visited) {
  if (!target.t.is_ghost(hint)) {
    const auto& v = target.t.triangles[hint].v;
    const Point2 &a = target.xy[v[0]], &b = target.xy[v[1]], &c = target.xy[v[2]];
    if (orientation_filtered(a, b, q) == 1 && orientation_filtered(b, c, q) == 1 &&
        orientation_filtered(c, a, q) == 1) {
      ++visited;
      return target.facets[hint].cosine > 0;
    }
  }
  const Location found = locate(q, target.t, target.xy, hint, visited);
  return found.kind != Location::Kind::outside && found.kind != Location::Kind::none && !target.t.is_ghost(hint) &&
         target.facets[hint].cosine > 0;
}

// Triangles lie in memory nearly as the nodes that are looked up in them: nearly.
constexpr std::size_t ahead = 12;
void prefetch_facet(const MatchSurface& target, Index triangle) {
  if (triangle >= target.t.real) return;
  prefetch(&target.t.triangles[triangle]);
  prefetch(&target.facets[triangle]);
}

/// Vertical distance of a point above a facet.
double above(const MatchSurface& s, Index triangle, const Point3& p) {
  const Facet& f = s.facets[triangle];
  const Index corner = s.t.triangles[triangle].v[0];
  return p.z - (s.z[corner] + f.gx * (p.x - s.xy[corner].x) + f.gy * (p.y - s.xy[corner].y));
}

Point3 normal_of(double gx, double gy, double cosine) { return {-gx * cosine, -gy * cosine, cosine}; }

/// The rows of one patch: derivatives and, as the last column, residuals. Their sums of products are made column by
/// column, two rows at a time, so that the compiler can keep them in vector registers.
class Rows {
 public:
  void add(const Vector7& j, double n, double weight) {
    for (std::size_t k = 0; k < parameters; ++k) column_[k][count_] = j[k];
    column_[parameters][count_] = n;
    weight_[count_++] = weight;
  }
  /// Adds them to `sums` and forgets them.
  void flush(ResidualSums& sums) {
    if (count_ == 0) return;
    if (count_ % 2 != 0) add({}, 0, 0);
    double* out = sums.h.m.data();
    flush_row<0>(out, sums), flush_row<1>(out, sums), flush_row<2>(out, sums), flush_row<3>(out, sums);
    flush_row<4>(out, sums), flush_row<5>(out, sums), flush_row<6>(out, sums);
    count_ = 0;
  }

 private:
  static constexpr std::size_t most = Residuals::largest_patch;
  static_assert(most % 2 == 0);

  template <std::size_t row>
  void flush_row(double*& out, ResidualSums& sums) const {
    constexpr std::size_t columns = parameters + 1 - row;
    double sum[columns][2] = {};
    for (std::size_t i = 0; i < count_; i += 2) {
      const double x[2] = {weight_[i] * column_[row][i], weight_[i + 1] * column_[row][i + 1]};
      for (std::size_t c = 0; c < columns; ++c)
        for (std::size_t l = 0; l < 2; ++l) sum[c][l] += x[l] * column_[row + c][i + l];
    }
    for (std::size_t c = 0; c + 1 < columns; ++c) *out++ += sum[c][0] + sum[c][1];
    sums.b[row] -= sum[columns - 1][0] + sum[columns - 1][1];
  }

  alignas(16) double column_[parameters + 1][most];
  alignas(16) double weight_[most];
  std::size_t count_ = 0;
};

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
  total.visited += part.visited;
}

template <bool moving_nodes>
ResidualSums evaluate_block(ResidualSide& side, const View& view, const Loss& loss, std::size_t patch,
                            std::size_t begin, std::size_t end) {
  const MatchSurface &nodes = *side.nodes, &target = *side.target;
  ResidualSums sums;
  Rows rows;
  Index last = 0;
  for (std::size_t first = begin; first < end; first += patch) {
    const double trust = side.trust[first / patch];
    for (std::size_t i = first; i < std::min(end, first + patch); ++i) {
      side.n[i] = std::numeric_limits<double>::quiet_NaN();
      const double area = nodes.weight[i];
      if (!(area > 0)) continue;
      const Point3 own{nodes.xy[i].x, nodes.xy[i].y, nodes.z[i]}, there = view.there(own);
      Index& at = side.hint[i];
      if (at == no_index) at = last;
      if (i + ahead < end) prefetch_facet(target, side.hint[i + ahead]);
      const bool over = locate_again(target, {there.x, there.y}, at, sums.visited);
      last = at;
      if (!over) continue;
      const Facet& facet = target.facets[at];
      const double vertical = above(target, at, there) * view.size, n = vertical * facet.cosine;
      side.n[i] = n;
      const Valued v = value(loss, n);
      const double counted = area * facet.weight, trusted = counted * trust, weight = trusted * v.weight;
      sums.area += counted;
      sums.trusted += trusted;
      sums.loss += trusted * v.loss;
      if (weight == 0) continue;
      sums.within += trusted;
      sums.fitted += weight;
      sums.volume += trusted * std::fabs(vertical);
      sums.squares += weight * vertical * vertical;
      const Point3 normal = normal_of(facet.smooth_gx, facet.smooth_gy, facet.cosine);
      rows.add(view.derivative<moving_nodes>(own, there, normal, n), n, weight);
    }
    rows.flush(sums);
  }
  return sums;
}

ResidualSums evaluate_side(ResidualSide& side, const Motion& motion, const Loss& loss, const Point3& centre,
                           double length, std::size_t patch) {
  const View view(side, motion, centre, length);
  return reduce_blocks<ResidualSums>(
      side.nodes->xy.size(), block,
      [&](std::size_t begin, std::size_t end) {
        return side.moving_nodes ? evaluate_block<true>(side, view, loss, patch, begin, end)
                                 : evaluate_block<false>(side, view, loss, patch, begin, end);
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

template <bool moving_nodes>
Information information_of(const ResidualSide& side, const View& view, const Loss& loss, double noise,
                           const Array<SlopeNoise>& slopes, std::size_t patch, std::size_t begin, std::size_t end) {
  const MatchSurface &nodes = *side.nodes, &target = *side.target;
  Information sum;
  for (std::size_t first = begin; first < end; first += patch) {
    Vector7 score{};
    for (std::size_t i = first; i < std::min(end, first + patch); ++i) {
      if (std::isnan(side.n[i])) continue;
      const Facet& f = target.facets[side.hint[i]];
      const double weight = nodes.weight[i] * f.weight * side.trust[first / patch] * value(loss, side.n[i]).weight;
      if (!(weight > 0)) continue;
      const Point3 own{nodes.xy[i].x, nodes.xy[i].y, nodes.z[i]}, there = view.there(own);
      const Vector7 j =
          view.derivative<moving_nodes>(own, there, normal_of(f.smooth_gx, f.smooth_gy, f.cosine), side.n[i]);
      sum.h.add(j, weight);
      if (noise > 0)
        add_slope_noise(target, slopes, side.hint[i], view.arm(moving_nodes ? there : own),
                        weight * noise * noise * f.cosine * f.cosine, sum.noise);
      for (std::size_t k = 0; k < parameters; ++k) score[k] -= weight * j[k] * side.n[i];
    }
    sum.score.add(score, 1);
  }
  return sum;
}

}  // namespace

Residuals::Residuals(const MatchSurface& moving, const MatchSurface& fixed, const Point3& centre, double length)
    : centre_(centre), length_(length) {
  const std::size_t fewest = std::min(moving.xy.size(), fixed.xy.size());
  patch_ = largest_patch;
  while (patch_ > 1 && fewest / patch_ < 64) patch_ /= 2;
  sides_[0] = {&moving, &fixed, true, {}, {}, {}};
  sides_[1] = {&fixed, &moving, false, {}, {}, {}};
  for (ResidualSide& side : sides_) {
    const std::size_t n = side.nodes->xy.size();
    side.hint.assign(n, no_index);
    side.n.assign(n, std::numeric_limits<double>::quiet_NaN());
    side.trust.assign((n + patch_ - 1) / patch_, 1.0);
  }
}

Twist Residuals::twist(const Vector7& step) const {
  return {step[0] / length_, step[1] / length_, step[2] / length_, step[3], step[4], step[5], step[6] / length_};
}

ResidualSums Residuals::evaluate(const Motion& motion, const Loss& loss, const Context& context) {
  context.check();
  ResidualSums parts[2];
  if (sides_[0].target->t.real == 0 || sides_[1].target->t.real == 0) return parts[0];
  both([&] { parts[0] = evaluate_side(sides_[0], motion, loss, centre_, length_, patch_); },
       [&] { parts[1] = evaluate_side(sides_[1], motion, loss, centre_, length_, patch_); });
  add_to(parts[0], parts[1]);
  return parts[0];
}

double Residuals::spread() const {
  constexpr std::size_t enough = 50000;  // of each side: the median of these is good to half a per cent
  std::vector<double> sizes;
  for (const ResidualSide& side : sides_) {
    const std::size_t stride = 1 + side.n.size() / enough;
    for (std::size_t i = 0; i < side.n.size(); i += stride)
      if (!std::isnan(side.n[i]) && side.trust[i / patch_] > 0) sizes.push_back(std::fabs(side.n[i]));
  }
  if (sizes.empty()) return 0;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return median_to_sigma * *middle;
}

bool Residuals::fitted(std::size_t i, const Loss& loss) const {
  const double n = sides_[0].n[i];
  return !std::isnan(n) && sides_[0].trust[i / patch_] * value(loss, n).weight > 0;
}

std::vector<Residuals::PatchMean> Residuals::patch_means() const {
  std::vector<PatchMean> means;
  for (std::size_t s = 0; s < 2; ++s) {
    const ResidualSide& side = sides_[s];
    for (std::size_t p = 0; p < side.trust.size(); ++p) {
      PatchMean m{0, 0, s, p};
      std::size_t count = 0;
      const std::size_t end = std::min(side.n.size(), (p + 1) * patch_);
      for (std::size_t i = p * patch_; i < end; ++i) {
        if (std::isnan(side.n[i])) continue;
        m.mean += side.nodes->weight[i] * side.n[i];
        m.area += side.nodes->weight[i];
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
  for (ResidualSide& side : sides_) std::fill(side.trust.begin(), side.trust.end(), 1.0);
}

void Residuals::trust_by_mean() {
  std::vector<PatchMean> means = patch_means();
  if (means.empty()) return;
  std::vector<double> sizes;
  for (const PatchMean& m : means) sizes.push_back(std::fabs(m.mean));
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  const double bound = patch_bound * median_to_sigma * *middle;
  for (const PatchMean& m : means) {
    const double u = bound > 0 ? m.mean / bound : (m.mean == 0 ? 0 : 1), v = 1 - u * u;
    sides_[m.side].trust[m.patch] = v > 0 ? v * v : 0;
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
  for (const PatchMean& m : means) {
    sides_[m.side].trust[m.patch] = used < share * all ? 1 : 0;
    used += m.area;
  }
}

Information Residuals::information(const Motion& motion, const Loss& loss, double noise, const Context& context) const {
  context.check();
  Information total;
  const auto add = [](Information& sum, const Information& part) {
    sum.h.add(part.h);
    sum.score.add(part.score);
    sum.noise.add(part.noise);
  };
  for (const ResidualSide& side : sides_) {
    const View view(side, motion, centre_, length_);
    const Array<SlopeNoise> slopes = noise > 0 ? slope_noise(*side.target) : Array<SlopeNoise>{};
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

}  // namespace isopach
